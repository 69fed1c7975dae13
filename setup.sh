#!/usr/bin/env bash
# Installs what texray needs beside Rust: the glslang compiler, the Vulkan loader, lavapipe (Vulkan on the CPU) and the
# validation layers. Comes in: Debian, Ubuntu, Fedora or Arch. Does nothing, quickly, where nothing is missing.
set -euo pipefail
cd "$(dirname "$0")"

fail() {
    echo "setup.sh: $*" >&2
    exit 1
}

as_root() {
    if [ "$(id -u)" -eq 0 ]; then
        "$@"
    elif command -v sudo >/dev/null; then
        sudo "$@"
    else
        fail "root is needed to run '$*', and sudo is not installed"
    fi
}

check_rust() {
    local need have
    need=$(sed -n 's/^rust-version *= *"\(.*\)"/\1/p' Cargo.toml)
    command -v cargo >/dev/null || fail "cargo is not installed; get Rust $need or newer from https://rustup.rs"
    have=$(cargo --version | cut -d' ' -f2)
    # The older of the two comes first in version order.
    [ "$(printf '%s\n%s\n' "$need" "${have%%-*}" | sort -V | head -n 1)" = "$need" ] ||
        fail "cargo $have is too old; Rust $need or newer is needed (rustup update)"
}

# Rust links with the C compiler's driver.
check_linker() {
    local how
    command -v cc >/dev/null && return
    case $manager in
        apt-get) how="apt-get install build-essential" ;;
        dnf) how="dnf install gcc" ;;
        pacman) how="pacman -S base-devel" ;;
    esac
    fail "there is no C linker (cc), which cargo needs; install one: $how"
}

# Prints those of the packages that are not installed.
missing() {
    local package
    for package in "$@"; do
        case $manager in
            apt-get) [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || echo "$package" ;;
            dnf) rpm -q --whatprovides "$package" >/dev/null 2>&1 || echo "$package" ;;
            pacman) pacman -T "$package" || true ;;
        esac
    done
}

check_rust

if command -v apt-get >/dev/null; then
    manager=apt-get
    packages=(glslang-tools libvulkan1 mesa-vulkan-drivers vulkan-validationlayers)
elif command -v dnf >/dev/null; then
    manager=dnf
    packages=(glslang vulkan-loader mesa-vulkan-drivers vulkan-validation-layers)
elif command -v pacman >/dev/null; then
    manager=pacman
    packages=(glslang vulkan-icd-loader vulkan-swrast vulkan-validation-layers)
else
    fail "no apt-get, dnf or pacman here. Install by hand: a C linker (cc), glslang, the Vulkan loader, a Vulkan driver, and" \
        "the Khronos validation layers; then run cargo."
fi
check_linker

mapfile -t wanted < <(missing "${packages[@]}")
if [ "${#wanted[@]}" -eq 0 ]; then
    exit 0
fi
echo "setup.sh: installing ${wanted[*]}" >&2
case $manager in
    apt-get)
        as_root apt-get update
        as_root env DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends "${wanted[@]}"
        ;;
    dnf) as_root dnf install --assumeyes "${wanted[@]}" ;;
    # A full upgrade: Arch does not support installing against an older system.
    pacman) as_root pacman -Syu --needed --noconfirm "${wanted[@]}" ;;
esac
