#!/usr/bin/env bash
# The one list of Debian packages, in groups; installs those of the named groups that are missing. Says nothing and needs no
# network when none is. Groups: build (the programs), page (WebAssembly module and web page), test (what ./check adds),
# package (what makes and tests Debian's packages), processors (compiler and emulator of others). The site of the documents
# (tools/make_site.sh) needs test's mkdocs.
# With --check as the first word nothing is installed; exits 1 if something is missing. --libraries alone prints which of build's and
# test's packages another processor's programs and tests are built with (tools/make_sysroot.sh).
set -euo pipefail

readonly build_packages=(
  ca-certificates git cmake ninja-build g++ ccache python3
  libgdal-dev gdal-bin libproj-dev proj-data
  libopenexr-dev
  libpng-dev libjpeg-dev libwebp-dev
  libpugixml-dev
  libgeographiclib-dev
  libglm-dev
  libembree-dev libtbb-dev
  libboost1.74-dev libssl-dev libcurl4-openssl-dev
  libflatbuffers-dev flatbuffers-compiler
  libzstd-dev libxxhash-dev
  libspdlog-dev libfmt-dev libcli11-dev nlohmann-json3-dev libtomlplusplus-dev
  zlib1g-dev libbrotli-dev libmeshoptimizer-dev libdraco-dev libseccomp-dev
)
readonly page_packages=(clang-19 lld-19 llvm-19 wasi-libc libc++-19-dev-wasm32 libclang-rt-19-dev-wasm32)
readonly test_packages=(curl openssl libsdl2-dev libgl-dev libgl1-mesa-dri xvfb xauth pkg-config clang-format clang-tidy clang-19 libclang-rt-19-dev libgtest-dev librapidcheck-dev proj-bin haproxy prometheus docker-compose nginx-light caddy chromium fonts-dejavu-core man-db mkdocs mkdocs-material)
readonly package_packages=(dpkg-dev file lintian debootstrap systemd qemu-user)
readonly processors_packages=(g++-aarch64-linux-gnu qemu-user)

usage() {
  echo "usage: tools/install_packages.sh [--check] GROUP...   (groups: build page test package processors)" >&2
  exit 2
}

isInstalled() {
  [[ "$(dpkg-query -W -f='${db:Status-Abbrev}' "$1" 2>/dev/null)" == ii* ]]
}

# Node may be here from elsewhere than Debian; 18 is what Debian 12 has and what the page needs at least.
hasNode() {
  command -v node >/dev/null && command -v npm >/dev/null &&
    [[ "$(node -p 'process.versions.node.split(".")[0]')" -ge 18 ]]
}

asRoot() {
  if [[ $EUID -eq 0 ]]; then "$@"
  elif command -v sudo >/dev/null; then sudo "$@"
  else
    echo "install_packages: missing: ${missing[*]}" >&2
    echo "install_packages: needs root to install them; run as root, or install sudo" >&2
    exit 2
  fi
}

if [[ "${1:-}" == --libraries ]]; then
  printf '%s\n' "${build_packages[@]}" libgtest-dev librapidcheck-dev | grep -E -- '-dev$'
  exit
fi

only_check=no
if [[ "${1:-}" == --check ]]; then only_check=yes; shift; fi
[[ $# -gt 0 ]] || usage
wanted=()
for group in "$@"; do
  case "$group" in
    build) wanted+=("${build_packages[@]}") ;;
    page) wanted+=("${page_packages[@]}"); hasNode || wanted+=(nodejs npm) ;;
    test) wanted+=("${test_packages[@]}") ;;
    package) wanted+=("${package_packages[@]}") ;;
    processors) wanted+=("${processors_packages[@]}") ;;
    *) usage ;;
  esac
done

if ! command -v dpkg-query >/dev/null; then
  echo "install_packages: this is not a Debian system; install the equivalents of: ${wanted[*]}" >&2
  exit 2
fi

missing=()
for package in "${wanted[@]}"; do
  isInstalled "$package" || missing+=("$package")
done
[[ ${#missing[@]} -gt 0 ]] || exit 0
[[ "$only_check" == no ]] || exit 1

echo "installing ${#missing[@]} packages: ${missing[*]}"
asRoot env DEBIAN_FRONTEND=noninteractive apt-get update -qq </dev/null
asRoot env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends -o APT::Status-Fd=1 "${missing[@]}" </dev/null
