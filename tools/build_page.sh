#!/usr/bin/env bash
# Builds the client's package into client/js/dist, and the page, which uses it, into client/web/dist. npm packages come by the lock
# files, and only when one has changed since the last time. The WebAssembly module must have been built (preset `wasm`); the package
# takes it from build/wasm/bin.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../client"

install() {
  local lock stamp="$1/node_modules/.foreland-lock"
  lock="$(cat "$1/package-lock.json" "$1/package.json" | sha256sum | cut -d' ' -f1)"
  [[ "$(cat "$stamp" 2>/dev/null || true)" != "$lock" ]] || return 0
  (cd "$1" && npm ci --no-audit --no-fund --loglevel=error)
  echo "$lock" >"$stamp"
}

install js
(cd js && npm run --silent build)
install web
(cd web && npm run --silent build)
