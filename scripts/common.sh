# shellcheck shell=bash
# Shared by the scripts of this folder; sourced, not run.
set -euo pipefail

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
                sed -n '2,/^[^#]/{/^#/s/^# \{0,1\}//p}' "$ROOT/scripts/$(basename "$0")"
                exit 0
                ;;
        esac
    done
}

known_preset() {
    case "$1" in
        dev | release | asan | tsan) ;;
        *) die "unknown preset '$1' (dev, release, asan, tsan)" ;;
    esac
}

# shellcheck disable=SC2034  # for the scripts that source this one
JOBS="${FACET_JOBS:-$(nproc)}"
