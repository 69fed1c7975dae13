#!/usr/bin/env bash
# Runs a command on each of three Vulkan drivers for the CPU: the system's lavapipe, lavapipe of Debian's backports (another
# Mesa and LLVM) and SwiftShader (a driver of its own, from Debian's chromium-common package). Nothing is installed: packages are
# unpacked into a folder.
#
#   tests/drivers.sh [-w] [-d FOLDER] [COMMAND ...]
#
# Comes in: Debian with apt-get and dpkg; the folder (default target/drivers), which is filled on the first run; a command
# (default: the hard cases at the full tier), to which `{driver}` is the driver's name. Goes out: the command's output in
# FOLDER/DRIVER.log, a table of drivers and results, and exit code 1 where any run failed. The command runs with VK_DRIVER_FILES
# (and LD_LIBRARY_PATH where the driver needs it) set. With -w, or without a command, pictures of the drivers are then held
# against each other by Welch's test (tests/drivers.rs, FOLDER/agreement.log).
set -euo pipefail
cd "$(dirname "$0")/.."

fail() {
    echo "drivers.sh: $*" >&2
    exit 1
}

folder=target/drivers
welch=
while getopts d:w option; do
    case $option in
        d) folder=$OPTARG ;;
        w) welch=yes ;;
        *) fail "usage: tests/drivers.sh [-w] [-d FOLDER] [COMMAND ...]" ;;
    esac
done
shift $((OPTIND - 1))
if [ $# -eq 0 ]; then
    welch=yes
    set -- cargo test --release --test hard_cases
fi
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)

# apt with lists and sources of its own: the system's suites and its backports, at the site that the system uses.
private_apt() {
    local apt=$folder/apt tool=$1
    shift
    "$tool" -o Dir::Etc::sourcelist="$apt/sources.list" -o Dir::Etc::sourceparts=/dev/null -o Dir::State::lists="$apt/lists" \
        -o Dir::Cache="$apt/cache" -o APT::Sandbox::User= "$@"
}

prepare_apt() {
    local apt=$folder/apt suite site keyring=/usr/share/keyrings/debian-archive-keyring.gpg
    [ -f "$apt/ready" ] && return
    suite=$(. /etc/os-release && echo "${VERSION_CODENAME:-}")
    site=$(apt-get indextargets --format '$(SITE) $(CODENAME)' 'Identifier: Packages' |
        sed -n "s/ $suite\$//p" | head -n 1)
    [ -n "$suite" ] && [ -n "$site" ] && [ -f "$keyring" ] || fail "needs Debian: no suite, site or keyring of it was found"
    mkdir -p "$apt/lists/partial" "$apt/cache/archives/partial"
    printf "deb [signed-by=$keyring] $site %s main\n" "$suite" "$suite-backports" >"$apt/sources.list"
    private_apt apt-get -qq update
    echo "$suite" >"$apt/ready"
}

# Unpacks packages (NAME or NAME/SUITE) below the folder's NAME.
unpack() {
    local to=$folder/$1
    shift
    [ -f "$to/ready" ] && return
    prepare_apt
    rm -rf "$to" "$folder/packages"
    mkdir -p "$to" "$folder/packages"
    (cd "$folder/packages" && private_apt apt-get -qq download "$@")
    for package in "$folder"/packages/*.deb; do
        dpkg -x "$package" "$to"
    done
    rm -rf "$folder/packages"
    touch "$to/ready"
}

backports() {
    prepare_apt
    cat "$folder/apt/ready" | sed "s/\$/-backports/"
}

if ! [ -f "$folder/lavapipe-backports/ready" ]; then
    suite=$(backports)
    # The LLVM that this Mesa was built with is named in its dependencies.
    llvm=$(private_apt apt-cache show "mesa-vulkan-drivers/$suite" 2>/dev/null | grep -o 'libllvm[0-9]*' | head -n 1)
    unpack lavapipe-backports "mesa-vulkan-drivers/$suite" "libdrm2/$suite" "libdrm-amdgpu1/$suite" "${llvm:?}"
fi
unpack swiftshader chromium-common

# Files that name the drivers to the Vulkan loader, with absolute paths.
describe() {
    printf '{"file_format_version": "1.0.0", "ICD": {"library_path": "%s", "api_version": "%s"}}\n' "$2" "$3" >"$folder/$1.json"
}
system=
for file in /usr/share/vulkan/icd.d/lvp_icd*.json /etc/vulkan/icd.d/lvp_icd*.json; do
    [ -f "$file" ] && system=$file && break
done
[ -n "$system" ] || fail "the system has no lavapipe: run ./setup.sh"
libraries=$(find "$folder/lavapipe-backports" -name libvulkan_lvp.so -printf '%h' -quit)
describe lavapipe-backports "$libraries/libvulkan_lvp.so" 1.4.305
# Chromium's own file has no api_version, which the loader wants.
describe swiftshader "$(find "$folder/swiftshader" -name libvk_swiftshader.so -print -quit)" 1.3.0

cp "$system" "$folder/lavapipe.json"

declare -A path=([lavapipe-backports]=$libraries)
result=0
table=$(printf '%-20s %-8s %-10s %s' driver result seconds 'last line of its log')
# run LOG COMMAND ...: runs it and adds a line to the table.
run() {
    local log=$folder/$1.log name=$1 verdict=passed started=$SECONDS last
    shift
    "$@" >"$log" 2>&1 || { verdict=failed && result=1; }
    last=$(grep . "$log" | tail -n 1 | cut -c1-80 || true)
    table+=$(printf '\n%-20s %-8s %-10s %s' "$name" "$verdict" $((SECONDS - started)) "$last")
}
for driver in lavapipe lavapipe-backports swiftshader; do
    libraries=${path[$driver]:-}${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
    run "$driver" env VK_DRIVER_FILES="$folder/$driver.json" LD_LIBRARY_PATH="${libraries#:}" "${@//\{driver\}/$driver}"
done
if [ -n "$welch" ]; then
    run agreement env DRIVERS_FOLDER="$folder" cargo test --release --test drivers -- --ignored --nocapture
fi
echo "$table"
exit $result
