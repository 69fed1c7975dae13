#!/usr/bin/env bash
# Counts the instructions that a path takes in lavapipe's code, under valgrind, where no neighbour and no clock has a
# say.
#
#   tests/count.sh [-p PROGRAM] [-r REPEATS] [-s WIDTHxHEIGHT] SCENE ...
#
# Comes in: scenes; valgrind, and lavapipe as the device that is picked by itself; PROGRAM, a build of
# tests/count/paths.rs (default: that of this checkout, which is built first; another checkout's is built there with
# `cargo build --release --example count_paths`). Goes out: a line a scene and repeat, paths and instructions per path,
# which is the difference of 32 and 16 samples over the paths between them; then the least and the most of the repeats.
# Only code that the driver made is counted, none of the compiler's nor of the host's: callgrind books it under the
# object `???`. Valgrind knows no AVX-512, so it is AVX2's on every machine; figures compare on one machine and one
# Mesa.
set -euo pipefail

fail() {
    echo "count.sh: $*" >&2
    exit 1
}

program=
repeats=2
size=32x24
usage="usage: tests/count.sh [-p PROGRAM] [-r REPEATS] [-s WIDTHxHEIGHT] SCENE ..."
while getopts p:r:s: option; do
    case $option in
        p) program=$OPTARG ;;
        r) repeats=$OPTARG ;;
        s) size=$OPTARG ;;
        *) fail "$usage" ;;
    esac
done
shift $((OPTIND - 1))
[ $# -gt 0 ] || fail "$usage"
command -v valgrind >/dev/null || fail "needs valgrind"
if [ -z "$program" ]; then
    root=$(cd "$(dirname "$0")/.." && pwd)
    cargo build --quiet --release --manifest-path "$root/Cargo.toml" --example count_paths
    program=${CARGO_TARGET_DIR:-$root/target}/release/examples/count_paths
fi
[ -x "$program" ] || fail "$program is no program"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Own cost of the lines of one object. A number in brackets stands for a name once it has been given; the line after
# `calls=` is what the called function cost.
sum_of_unnamed='
/^c?ob=/ {
    match($0, /\([0-9]+\)/)
    id = substr($0, RSTART, RLENGTH)
    given = substr($0, RSTART + RLENGTH + 1)
    if (given != "") name[id] = given
    if ($0 ~ /^ob=/) object = id
    next
}
/^calls=/ { skip = 1; next }
/^[0-9+*-]/ { if (skip) skip = 0; else cost[object] += $NF; next }
END { for (id in cost) if (name[id] == "???") sum += cost[id]; printf "%.0f\n", sum }'

# Paths and instructions of a render: count SCENE SPP.
count() {
    local paths
    paths=$(LP_NUM_THREADS=1 RAYON_NUM_THREADS=1 MESA_SHADER_CACHE_DISABLE=1 valgrind -q --tool=callgrind \
        --callgrind-out-file="$work/out" "$program" "$1" "${size%x*}" "${size#*x}" "$2")
    echo "$paths $(awk "$sum_of_unnamed" "$work/out")"
}

for scene in "$@"; do
    least= most=
    for ((repeat = 1; repeat <= repeats; repeat++)); do
        few=$(count "$scene" 16)
        many=$(count "$scene" 32)
        per_path=$(awk -v few="$few" -v many="$many" 'BEGIN {
            split(few, a); split(many, b)
            if (a[2] == 0 || b[1] == a[1]) exit 1
            printf "%.2f", (b[2] - a[2]) / (b[1] - a[1])
        }') || fail "no code of a driver was met: is lavapipe the device?"
        echo "$scene $repeat: $((${many% *} - ${few% *})) paths, $per_path instructions per path"
        least=$(printf '%s\n' $least "$per_path" | sort -n | head -n 1)
        most=$(printf '%s\n' $most "$per_path" | sort -n | tail -n 1)
    done
    echo "$scene: $least to $most instructions per path in $repeats repeats"
done
