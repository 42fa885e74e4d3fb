#!/usr/bin/env bash
# Puts what `foreland bench` runs under node, with the npm packages that it needs, into build/lab_scripts, for the package
# foreland-lab: report/draw.mjs as one file, and the packages of rivals as they are. The page's packages must be there
# (tools/build_page.sh): esbuild is one of them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
readonly out="$PWD/build/lab_scripts"

for folder in lab/report lab/martini lab/wire/peers; do
  lock="$(sha256sum "$folder"/package-lock.json "$folder"/package.json | sha256sum | cut -d' ' -f1)"
  stamp="$folder/node_modules/.foreland-lock"
  if [[ "$(cat "$stamp" 2>/dev/null || true)" != "$lock" ]]; then
    npm ci --prefix "$folder" --no-audit --no-fund --loglevel=error
    echo "$lock" >"$stamp"
  fi
done

rm -rf "$out"
mkdir -p "$out/report"
# copyRival FOLDER PACKAGE FILE: the script, and of the package what it reads.
copyRival() {
  local to="$out/$1/node_modules/$2"
  mkdir -p "$to"
  cp lab/"$1"/*.mjs "$out/$1/"
  (cd "lab/$1/node_modules/$2" && cp --parents package.json "$3" "$to/")
}
copyRival martini @mapbox/martini index.js
copyRival wire/peers @here/quantized-mesh-decoder dist/quantized-mesh-decoder.js
# linkedom draws on `canvas` if that is there, which is not needed.
client/web/node_modules/.bin/esbuild lab/report/draw.mjs --bundle --platform=node --format=esm --minify --legal-comments=none \
  --external:canvas --log-level=warning --outfile="$out/report/draw.mjs"
