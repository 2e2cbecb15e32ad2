# What ./demo, ./test and .ci/run share: Debian packages and the build. Sourced by bash under `set -euo pipefail`;
# expects `root`, the folder of the checkout.

# zlib1g-dev: libassimp-dev's CMake package names libz.so, but the Debian package does not depend on it.
build_packages=(
    g++ cmake ninja-build pkg-config
    ocl-icd-opencl-dev opencl-clhpp-headers pocl-opencl-icd clinfo
    libtbb-dev libtinyobjloader-dev libassimp-dev zlib1g-dev libxxhash-dev libcli11-dev libfmt-dev nlohmann-json3-dev libstb-dev libembree-dev
)
test_packages=(catch2 oclgrind python3)

say() { printf '== %s\n' "$*"; }

die() {
    printf '%s: %s\n' "$(basename "$0")" "$*" >&2
    exit 1
}

is_installed() { [[ $(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null) == installed ]]; }

# install_packages NAME...: installs those that are missing, and says which before it does.
install_packages() {
    local missing=() as_root=() name
    command -v apt-get >/dev/null && command -v dpkg-query >/dev/null ||
        die "no apt-get here. Install what corresponds to these Debian packages, then use --no-install: $*"
    for name in "$@"; do
        is_installed "$name" || missing+=("$name")
    done
    ((${#missing[@]})) || return 0
    if ((EUID != 0)); then
        command -v sudo >/dev/null ||
            die "packages are missing, and neither root nor sudo is at hand. As root: apt-get install ${missing[*]}"
        as_root=(sudo)
    fi
    say "Installing Debian packages: ${missing[*]}"
    local apt_get=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=120)
    "${apt_get[@]}" update || die "apt-get update failed; its messages are above"
    "${apt_get[@]}" install --yes --no-install-recommends "${missing[@]}" >/dev/null ||
        die "apt-get could not install ${missing[*]}; its messages are above"
}

# build PRESET FOLDER: configures the preset, whose build folder is FOLDER, and builds it; with Ninja where that is installed.
build() {
    local preset=$1 folder=$root/$2 generator=()
    command -v cmake >/dev/null || die "no cmake here; run without --no-install, or install: ${build_packages[*]}"
    if [[ ! -e $folder/CMakeCache.txt ]] && command -v ninja >/dev/null; then
        generator=(-G Ninja)
    fi
    say "Configuring and building in $folder"
    (cd "$root" && cmake --preset "$preset" "${generator[@]}" && cmake --build --preset "$preset" -j "$(nproc)")
}
