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

# Lets the kernel run programs for 64-bit ARM, in chroots too, by qemu; needs root. Undone by forget_emulator, which a
# trap at the exit must call.
EMULATOR=""
register_emulator() {
    local binfmt=/proc/sys/fs/binfmt_misc qemu
    qemu="$(command -v qemu-aarch64-static)" || die "no qemu-aarch64-static: run scripts/setup --cross"
    [[ -e $binfmt/register ]] || mount -t binfmt_misc binfmt_misc $binfmt \
        || die "no binfmt_misc: arm64 cannot be run here"
    if [[ ! -e $binfmt/qemu-aarch64 && ! -e $binfmt/facet-aarch64 ]]; then
        # The head of an ELF file for AArch64, its mask, and what runs it; F: opened now, so the chroot needs no copy.
        printf '%s' ':facet-aarch64:M::\x7fELF\x02\x01\x01\x00\x00\x00\x00\x00\x00\x00\x00\x00\x02\x00\xb7\x00:' \
            '\xff\xff\xff\xff\xff\xff\xff\x00\xff\xff\xff\xff\xff\xff\xff\xff\xfe\xff\xff\xff:' \
            "$qemu:F" > $binfmt/register
        EMULATOR=$binfmt/facet-aarch64
    fi
}
forget_emulator() { [[ -z "$EMULATOR" ]] || echo -1 > "$EMULATOR"; }
