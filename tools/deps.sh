#!/usr/bin/env bash
# Installs the Debian packages that furrow's build and tests need, and only those that are missing.
set -euo pipefail

packages=(
  # build
  cmake make ninja-build g++ pkg-config flatbuffers-compiler
  # runtime
  libflatbuffers-dev libxxhash-dev libdraco-dev libhwy-dev libepoxy-dev glslang-tools spirv-tools
  # pipeline and tools
  libglm-dev libtinygltf-dev nlohmann-json3-dev libmeshoptimizer-dev libopenmesh-dev libopenimageio-dev libpng-dev libeigen3-dev libstb-dev libcli11-dev
  # preview and editor
  libimgui-dev libglfw3-dev libegl1 libgl1 libgl1-mesa-dri libopengl0
  # figures and gallery
  gnuplot-nox fonts-dejavu-core netpbm pngquant
  # tests
  libgtest-dev libgmock-dev libbenchmark-dev libvulkan-dev mesa-vulkan-drivers xvfb xauth python3-jsonschema
)
# The test other_cpu: a compiler for 64-bit ARM and an emulator.
[[ $(dpkg --print-architecture 2>/dev/null) == amd64 ]] && packages+=(g++-aarch64-linux-gnu qemu-user)

if ! command -v apt-get >/dev/null; then
  echo "deps: this is no Debian; install the equivalents of: ${packages[*]}" >&2
  exit 1
fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${Status}' "$package" 2>/dev/null || true)
  [[ $status == "install ok installed" ]] || missing+=("$package")
done
if [[ ${#missing[@]} -eq 0 ]]; then
  echo "deps: all ${#packages[@]} packages are installed"
  exit 0
fi

echo "deps: missing: ${missing[*]}"
as_root=()
if [[ $(id -u) -ne 0 ]]; then
  command -v sudo >/dev/null || { echo "deps: not root, and no sudo: install them yourself" >&2; exit 1; }
  as_root=(sudo)
fi
install=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}")
# A machine whose package lists are fresh needs no update.
"${install[@]}" || { "${as_root[@]}" apt-get update && "${install[@]}"; }
