#!/usr/bin/env bash
# Makes build/sysroot-arm64: a folder with the libraries of Debian 12 for arm64, which a cross compiler and qemu-aarch64 take for the
# root (cmake/aarch64-linux.cmake). The packages are those of tools/install_packages.sh. They are fetched from this system's mirror, and
# unpacked without being installed, so this needs no root, and this system's own packages stay as they are. Does nothing if it is there.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
readonly architecture=arm64 suite=bookworm
readonly sysroot="$PWD/build/sysroot-$architecture" work="$PWD/build/sysroot-$architecture.making"

mapfile -t packages < <(tools/install_packages.sh --libraries)
readonly contents="$suite $architecture ${packages[*]}"
if [[ "$(cat "$sysroot/contents" 2>/dev/null)" == "$contents" ]]; then exit 0; fi

# The mirror that this system takes its packages from.
mirror="$(apt-get indextargets --format '$(REPO_URI) $(RELEASE) $(ORIGIN)' 'Created-By: Packages' 2>/dev/null | sed -n "s/ $suite Debian\$//p" | head -1)"

rm -rf "$work" "$sysroot"
mkdir -p "$work"/{state/lists/partial,cache/archives/partial,root}
touch "$work/status"
echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] ${mirror:-http://deb.debian.org/debian} $suite main" >"$work/sources.list"

# apt with a world of its own, in which nothing is installed.
apt() {
  apt-get -qq -o Dir::State="$work/state" -o Dir::State::status="$work/status" -o Dir::Cache="$work/cache" -o Dir::Etc::sourcelist="$work/sources.list" \
    -o Dir::Etc::sourceparts=/dev/null -o Dir::Etc::preferencesparts=/dev/null -o APT::Architecture="$architecture" -o APT::Architectures="$architecture" \
    -o APT::Sandbox::User= -o Debug::NoLocking=true "$@" </dev/null
}
apt update
apt install --no-install-recommends --download-only -y libc6-dev libstdc++-12-dev "${packages[@]}" >"$work/apt.log" || { tail -n 20 "$work/apt.log" >&2; exit 1; }
mkdir -p "$work"/root/usr/{bin,sbin,lib}
for folder in bin sbin lib; do ln -s "usr/$folder" "$work/root/$folder"; done  # Debian's merged /usr
for package in "$work"/cache/archives/*.deb; do dpkg-deb --fsys-tarfile "$package" | tar -C "$work/root" --keep-directory-symlink -xf -; done

# Links to the root are to this one.
while IFS= read -r -d '' link; do
  ln -sfnr "$work/root$(readlink "$link")" "$link"
done < <(find "$work/root" -lname '/*' -print0)

# What dpkg's scripts would have chosen.
libraries="$work/root/usr/lib/aarch64-linux-gnu"
for name in blas lapack; do
  [[ -e "$libraries/lib$name.so.3" || ! -e "$libraries/$name/lib$name.so.3" ]] || ln -s "$name/lib$name.so.3" "$libraries/lib$name.so.3"
done
# Some libraries say to CMake where Debian puts them.
grep -rlZ '"/usr/*' --include='*.cmake' "$libraries/cmake" | xargs -0 -r sed -i "s|\"/usr\b|\"$sysroot/usr|g"
# PROJ asks that who uses it is compiled as it was, on the processor that it is for.
sed -i 's/^if (CMAKE_CROSSCOMPILING)/if (FALSE)/' "$libraries"/cmake/proj*/*-version.cmake
echo "$contents" >"$work/root/contents"
mv "$work/root" "$sysroot"
rm -rf "$work"
