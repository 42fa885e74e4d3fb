#!/usr/bin/env bash
# Installs the packages of build/packages (tools/make_packages.sh) into a fresh Debian, and flies there: makes a landscape and a
# scene, serves it as the unit of systemd does, loads the page, flies, stops the server, reads a manual page, removes everything.
#
#   tools/test_packages.sh              in a chroot of debootstrap; where none can be made (no root, no network), unpacked beside this system
#   tools/test_packages.sh --unpacked   without trying
#
# All of it happens in mount and process namespaces of its own, so nothing that it mounts or starts is left behind.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
readonly packages="$PWD/build/packages" suite=bookworm

fail() { echo "test_packages: $*" >&2; exit 1; }
say() { printf '%4d s  %s\n' "$SECONDS" "$*"; }

# Again, alone with our processes and mounts, which end with us. Where namespaces cannot be had, nothing is mounted.
if [[ "${1:-}" != --within ]]; then
  work="$(mktemp -d "${TMPDIR:-/tmp}/foreland-packages-XXXXXX")"
  trap 'rm -rf "$work"' EXIT
  alone=(unshare --mount --pid --fork --kill-child --mount-proc) mode="${1:-}"
  [[ $EUID -eq 0 ]] || alone+=(--user --map-root-user)
  "${alone[@]}" true 2>/dev/null || alone=() mode=--unpacked
  "${alone[@]}" "tools/${0##*/}" --within "$work" "$EUID" "$mode"
  exit
fi
readonly work="$2" user="$3" mode="$4" tree="$2/tree" root="$2/root"

foreland="$(ls "$packages"/foreland_*.deb)" lab="$(ls "$packages"/foreland-lab_*.deb)" || fail "there are no packages; run tools/make_packages.sh first"
version="$(dpkg-deb -f "$foreland" Version)"

# ---- what is in them ----

unpack() { mkdir -p "$tree" && dpkg-deb -x "$1" "$tree"; }

# As a unit of this system, with the unpacked program.
checkUnit() {
  local said
  sed "s|/usr/bin/foreland|$tree/usr/bin/foreland|" "$tree/usr/lib/systemd/system/foreland.service" >"$work/foreland.service"
  said="$(systemd-analyze verify --man=no "$work/foreland.service" 2>&1)" || fail "systemd-analyze: $said"
  [[ -z "$said" ]] || fail "systemd-analyze: $said"
  [[ -f "$tree/etc/foreland/serve.toml" && ! -e "$tree/etc/systemd" ]] || fail "the service has no configuration, or is enabled"
}

# The least processor there is, as QEMU makes one of this, builds the same scene. QEMU does not follow `foreland` into its subcommands.
checkProcessor() {
  local programs="$tree/usr/libexec/foreland" heights="$work/heights.exr" emulator
  qemu-x86_64 -cpu qemu64 "$tree/usr/bin/foreland" --version | grep -qF "$version" || fail "an old processor does not run foreland --version"
  "$programs/foreland-synth" -o "$heights" --size 129 --seed 7 >/dev/null 2>&1 || fail "foreland synth failed"
  for emulator in "" "qemu-x86_64 -cpu qemu64"; do
    $emulator "$programs/foreland-build" "$heights" -o "$work/scene${emulator:+-old}.fls" >"$work/build.log" 2>&1 || fail "$emulator foreland-build: $(cat "$work/build.log")"
  done
  cmp "$work/scene.fls" "$work/scene-old.fls" || fail "an old processor builds another scene"
}

checkLaboratoryIsApart() {
  local said status=0
  said="$("$tree/usr/bin/foreland" bench 2>&1)" || status=$?
  [[ $status -eq 2 && "$said" == *"install the package foreland-lab"* ]] || fail "without the laboratory: exit code $status: $said"
}

# The client for other engines, and that programs are built with it.
checkLibrary() {
  local library said
  unpack "$(ls "$packages"/libforeland-client0_*.deb)" && unpack "$(ls "$packages"/libforeland-client-dev_*.deb)" || fail "there are no packages of the library"
  library="$tree/usr/lib/libforeland_client.so.0"
  said="$(python3 -c 'import ctypes, sys; l = ctypes.CDLL(sys.argv[1]); l.foreland_version.restype = ctypes.c_char_p; print(l.foreland_version().decode())' "$library" 2>&1)" ||
    fail "the library does not load: $said"
  [[ "$said" == "$version" ]] || fail "the library is of version $said"
  [[ -f "$tree/usr/include/foreland.h" && -f "$tree/usr/lib/pkgconfig/foreland.pc" ]] || fail "there is nothing to build programs with"
}

# ---- a flight from installed programs: run by bash as `fly PREFIX`, with PREFIX/bin in PATH ----

readonly flight='
set -euo pipefail
etc="$1" page="$2" exec_start="$3"
folder="$(mktemp -d)" server=""
trap '\''[[ -z "$server" ]] || kill -KILL "$server" 2>/dev/null; rm -rf "$folder"'\'' EXIT
cd "$folder"
foreland synth -o hills.exr --size 257 --seed 7 >/dev/null 2>synth.log
foreland build hills.exr -o hills.fls >/dev/null 2>build.log
foreland verify hills.fls >/dev/null

# The shipped configuration with a scene, and a port that is free.
sed -e "s|^#SCENE = .*|SCENE = \"$folder/hills.fls\"|" -e "s|^#listen = .*|listen = \"127.0.0.1:0\"|" "$etc/foreland/serve.toml" >serve.toml
mkfifo said
$(sed "s|--config [^ ]*|--config serve.toml|" <<<"$exec_start") >said 2>serve.log &
server=$!
exec 4<said
read -r line <&4 || { cat serve.log >&2; exit 1; }
port="${line%/}" port="${port##*:}"

ask() {
  exec 3<>"/dev/tcp/127.0.0.1/$port"
  printf "GET %s HTTP/1.0\r\nHost: localhost\r\n\r\n" "$1" >&3
  cat <&3 | tr -d "\r"
}
ask / >answer
grep -q "^HTTP/1.. 200" answer || { echo "the page: $(head -1 answer)" >&2; exit 1; }
sed "1,/^$/d" answer | cmp - "$page/index.html"
for asset in $(sed -n "s/.* src=\"\.\(\/[^\"]*\.js\)\".*/\1/p" "$page/index.html") $(cd "$page" && ls assets/*.wasm | sed "s|^|/|"); do
  ask "$asset" >answer
  head -1 answer | grep -q "^HTTP/1.. 200" || { echo "the server has no $asset" >&2; exit 1; }
done

foreland fly "ws://127.0.0.1:$port" --tour survey --seconds 3 --truth hills.fls >fly.out || { cat fly.out serve.log >&2; exit 1; }
kill -TERM "$server"
status=0
wait "$server" || status=$?
server=""
[[ $status -eq 0 ]] || { echo "the server stopped with exit code $status" >&2; cat serve.log >&2; exit 1; }
'

# The laboratory: a measurement, an experiment, and its page where there is node.
readonly measure='
set -euo pipefail
folder="$(mktemp -d)"
trap '\''rm -rf "$folder"'\'' EXIT
cd "$folder"
foreland synth -o hills.exr --size 129 --seed 7 >/dev/null 2>synth.log
foreland build hills.exr -o hills.fls >/dev/null 2>build.log
foreland bench sections hills.fls --seconds 1 >/dev/null
foreland link --help >/dev/null
foreland bench load hills.fls --viewers 2 --run-in 2 --seconds 1 --out load >/dev/null
if command -v node >/dev/null; then
  foreland bench report load >/dev/null
  test -s load/report.html
  foreland bench client hills.fls --seconds 1 --json >client.json
  foreland bench wire hills.fls --seconds 1 --json >wire.json
  if grep -E "(quantized_mesh|wasm)_skipped" client.json wire.json; then exit 1; fi
  head -c 100 /dev/zero >heights
  node "$1"/martini/martini.mjs heights 5 "[]" >martini.json
fi
'

execStart() { sed -n 's/^ExecStart=//p' "$1/usr/lib/systemd/system/foreland.service"; }

flyUnpacked() {
  local start
  start="$(execStart "$tree")"
  PATH="$tree/usr/bin:$PATH" bash -c "$flight" fly "$tree/etc" "$tree/usr/share/foreland/web" "${start//\/usr\/bin/$tree/usr/bin}" || fail "the flight failed"
}

# ---- a Debian of its own ----

within() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }

# The mirror that this system takes its packages from.
mirror() {
  local found
  found="$(apt-get indextargets --format '$(REPO_URI) $(RELEASE) $(ORIGIN)' 'Created-By: Packages' 2>/dev/null | sed -n "s/ $suite Debian\$//p" | head -1)"
  echo "${found:-http://deb.debian.org/debian}"
}

# Prints why not, if it cannot.
makeDebian() {
  local from
  [[ "$user" -eq 0 ]] || { say "only root can make a chroot"; return 1; }
  from="$(mirror)"
  debootstrap --variant=minbase "$suite" "$root" "$from" >"$work/debootstrap.log" 2>&1 || { say "debootstrap: $(tail -n 1 "$work/debootstrap.log")"; return 1; }
  echo "deb $from $suite main" >"$root/etc/apt/sources.list"
  echo force-unsafe-io >"$root/etc/dpkg/dpkg.cfg.d/in-a-test"
  mount -t proc proc "$root/proc" && within apt-get -qq update
}

aptGet() { within apt-get -qq --no-install-recommends "$@" >"$work/apt.log" 2>&1 || { tail -n 20 "$work/apt.log" >&2; fail "apt-get $* failed"; }; }

checkInDebian() {
  cp "$foreland" "$lab" "$root/tmp/"
  aptGet -y install man-db bash-completion "/tmp/${foreland##*/}"
  say "installed"
  [[ "$(within foreland --version)" == "foreland $version" ]] || fail "foreland --version is not $version"
  [[ ! -e "$root/etc/systemd/system/multi-user.target.wants/foreland.service" ]] || fail "the service is enabled"
  [[ "$(within dpkg-query -W -f '${Conffiles}' foreland)" == *" /etc/foreland/serve.toml "* ]] || fail "serve.toml is no conffile"
  within bash -c "$flight" fly /etc /usr/share/foreland/web "$(execStart "$root")" || fail "the flight failed"
  say "flown"
  checkHelp
  aptGet -y install "/tmp/${lab##*/}"
  within bash -c "$measure" measure /usr/share/foreland/lab || fail "the laboratory failed"
  say "measured"
  aptGet -y purge foreland foreland-lab
  local left
  left="$(cd "$root" && find etc usr/bin usr/libexec usr/share usr/lib/systemd var/lib/dpkg/info -path '*foreland*' ! -path 'usr/share/doc')"
  [[ -z "$left" ]] || fail "purged, but there is still: $left"
}

# Manual pages, and completion in bash.
checkHelp() {
  within man foreland-build | grep -q -- '--nodata' || fail "there is no manual page of foreland build"
  local completed
  completed="$(within bash -c '
    source /usr/share/bash-completion/bash_completion
    source /usr/share/bash-completion/completions/foreland
    complete_words() {
      COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMP_LINE="$*" COMP_POINT=$((${#COMP_LINE})) COMPREPLY=()
      local function
      function="$(complete -p foreland | sed "s/.*-F \([^ ]*\).*/\1/")"
      "$function" foreland "${@: -1}" "${@: -2:1}"
      echo "${COMPREPLY[@]}"
    }
    complete_words foreland bu
    complete_words foreland build --nod')"
  [[ "$completed" == build*--nodata* ]] || fail "bash completes: $completed"
}

# ----

tools/package_documents.py --self-test

unpack "$foreland"
checkUnit
checkProcessor
checkLaboratoryIsApart
checkLibrary
unpack "$lab"
PATH="$tree/usr/bin:$PATH" bash -c "$measure" measure "$tree/usr/share/foreland/lab" || fail "the laboratory failed"
say "unpacked, and measured"
if [[ "$mode" != --unpacked ]] && makeDebian; then
  say "made a Debian"
  checkInDebian
  say "installed, flown and removed: foreland and foreland-lab $version"
else
  flyUnpacked
  say "unpacked and flown: foreland and foreland-lab $version"
fi
