#!/usr/bin/env bash
# Makes Debian's packages foreland, foreland-lab, libforeland-client0 and -dev in build/packages: builds programs, library, module, page and what node runs, packs,
# and lets lintian judge. What is built already is not built again.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
readonly out=build/packages

tools/install_packages.sh build page package

cmake --preset release -DFORELAND_LAB=ON
targets=(programs foreland_c foreland-bench foreland-link)
if cmake --build --preset release --target help | grep -q '^manual:'; then targets+=(manual); fi
cmake --build --preset release --target "${targets[@]}"
cmake --preset wasm -DFORELAND_LAB=ON
cmake --build --preset wasm --target foreland_wasm foreland_decoder_wasm foreland_mesher_wasm
tools/build_page.sh
tools/pack_lab_scripts.sh

rm -rf "$out"
cpack --config build/release/CPackConfig.cmake -B "$out"
rm -rf "$out/_CPack_Packages"
# CPack's own scripts call ldconfig, beside the trigger that Debian wants; the library is of one architecture, in /usr/lib.
lintian --fail-on error,warning --tag-display-limit 0 --suppress-tags maintscript-calls-ldconfig,pkg-config-unavailable-for-cross-compilation "$out"/*.deb
ls -l "$out"/*.deb
