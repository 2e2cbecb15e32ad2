#!/usr/bin/env bash
# Puts what the host half and its tests need of Debian's arm64 packages into FOLDER, for a cross build on amd64; nothing
# of it is installed. Adds the architecture arm64 to dpkg where it is missing, which needs root.
#   cmake/aarch64-sysroot.sh build-aarch64-sysroot
set -euo pipefail

(($# == 1)) || {
    printf 'usage: %s FOLDER\n' "$0" >&2
    exit 2
}
mkdir -p "$1"
cd "$1"
if ! dpkg --print-foreign-architectures | grep -qx arm64; then
    dpkg --add-architecture arm64
    apt-get -qq update
fi
# _apt, which downloads, need not be allowed to write here.
apt-get -qq -o APT::Sandbox::User=root download \
    libtbb12:arm64 libtbb-dev:arm64 libtbbbind-2-5:arm64 libtbbmalloc2:arm64 libtinyobjloader-dev:arm64 libxxhash-dev:arm64 nlohmann-json3-dev catch2
for package in ./*.deb; do
    dpkg -x "$package" .
    rm "$package"
done
