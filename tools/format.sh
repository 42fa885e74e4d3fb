#!/usr/bin/env bash
# Formats every C++ file of ours in place, or, with --check, says which are not formatted and exits 1.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
files() { python3 -c 'import sys; sys.path.insert(0, "tools"); import source_files as s; print("\0".join(s.ours(suffixes=s.CPP)), end="")'; }
case "${1:-}" in
  "") files | xargs -0 -r -n 20 -P "$(nproc)" clang-format -i ;;
  --check)
    # Only the names: clang-format would print every place. Most of its time is its start, so files are looked at one by one only where
    # not all of several are formatted.
    unformatted="$(files | xargs -0 -r -n 50 -P "$(nproc)" sh -c \
      'clang-format --dry-run -Werror "$@" 2>/dev/null || for f; do clang-format --dry-run -Werror "$f" 2>/dev/null || echo "$f"; done' sh | sort)"
    [[ -z "$unformatted" ]] && exit 0
    printf '%s\n' "$unformatted" "not formatted; run tools/format.sh"
    exit 1
    ;;
  *) echo "usage: tools/format.sh [--check]" >&2; exit 2 ;;
esac
