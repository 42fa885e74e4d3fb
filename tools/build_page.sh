#!/usr/bin/env bash
# Builds the page into client/web/dist. npm packages come by the lock file, and only when it has changed since the last time.
# The WebAssembly module must have been built (preset `wasm`); the page's build takes it from build/wasm/bin.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../client/web"

lock="$(sha256sum package-lock.json package.json | sha256sum | cut -d' ' -f1)"
stamp=node_modules/.foreland-lock
if [[ "$(cat "$stamp" 2>/dev/null || true)" != "$lock" ]]; then
  npm ci --no-audit --no-fund --loglevel=error
  echo "$lock" >"$stamp"
fi
npm run --silent build
