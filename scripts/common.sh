# shellcheck shell=bash
# Shared by the scripts of this folder and of target/; sourced, not run.
set -euo pipefail

SCRIPT="$(realpath -- "$0")" # before the working folder changes
ROOT="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
cd "$ROOT"

say() { printf '==> %s\n' "$*"; }
die() {
    printf '%s: %s\n' "$(basename "$0")" "$*" >&2
    exit 2
}

# Prints the comment block at the head of the calling script if it was asked for help.
help_if_asked() {
    local argument
    for argument in "$@"; do
        case "$argument" in
            -h | --help)
                sed -n '2,/^[^#]/{/^#/s/^# \{0,1\}//p}' "$SCRIPT"
                exit 0
                ;;
        esac
    done
}

known_preset() {
    case "$1" in
        dev | release | asan | tsan | aarch64 | armv7) ;;
        *) die "unknown preset '$1' (dev, release, asan, tsan, aarch64, armv7)" ;;
    esac
}

# Where the cross build for an architecture of Debian finds the target's libraries; toolchains/debian_cross.cmake has
# the same default.
sysroot_of() { echo "${FACET_SYSROOT:-${XDG_CACHE_HOME:-$HOME/.cache}/facet/sysroot-$1}"; }

# shellcheck disable=SC2034  # for the scripts that source this one
{
    JOBS="${FACET_JOBS:-$(nproc)}"
    SYSROOT="$(sysroot_of arm64)"
    # Debian packages that the program, or its tests, are compiled and linked with: on the host and in the sysroot.
    # Two single OpenCV modules: libopencv-dev, or features2d alone, would pull in several hundred packages.
    LIBRARY_PACKAGES=(
        libeigen3-dev libboost-dev libopencv-core-dev libopencv-imgproc-dev libpng-dev
        libyaml-cpp-dev libcli11-dev nlohmann-json3-dev libfmt-dev libgpiod-dev
        libbz2-dev libjpeg-dev liblz4-dev libsqlite3-dev libtiff-dev libzstd-dev zlib1g-dev
    )
    TEST_LIBRARY_PACKAGES=(catch2 libbenchmark-dev)
}
