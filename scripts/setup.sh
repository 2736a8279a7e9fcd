#!/usr/bin/env bash
# Sets up everything the build and the demo need, once. Works again offline when it is done.
#   1. Debian packages, through apt, with sudo only where something is missing
#   2. native libraries out of pinned, checksummed wheels, into .deps/
#   3. the hand estimator's Python environment, into .deps/venv
set -euo pipefail
cd "$(dirname "$0")/.."

say() { printf 'setup: %s\n' "$*"; }
fail() { printf 'setup: error: %s\n' "$*" >&2; exit 1; }

debian_packages=(
  build-essential pkg-config clang libclang-dev cmake
  libopencv-dev libegl1 libegl-mesa0 libgl1-mesa-dri libgl1
  mesa-vulkan-drivers libxkbcommon-x11-0
  ffmpeg python3 python3-venv python3-pip unzip
)

install_debian_packages() {
  if ! command -v dpkg-query >/dev/null; then
    say "not a Debian system: please install the equivalents of: ${debian_packages[*]}"
    return
  fi
  local missing=() package
  for package in "${debian_packages[@]}"; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
  done
  if [ "${#missing[@]}" -eq 0 ]; then
    return
  fi
  local sudo=()
  [ "$(id -u)" -eq 0 ] || sudo=(sudo)
  say "installing Debian packages: ${missing[*]}"
  "${sudo[@]}" apt-get update -qq
  "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

check_rust() {
  command -v cargo >/dev/null ||
    fail "cargo is missing: install Rust 1.95 or newer from https://rustup.rs, then run this again"
}

# The environment first: its pip also fetches the wheels below.
make_python_environment() {
  local stamp=.deps/venv/.agenticfocus
  if [ -f "$stamp" ] && cmp -s "$stamp" models/estimators/requirements.txt; then
    return
  fi
  say "making the hand estimator's Python environment in .deps/venv"
  local python=python3
  for candidate in python3.11 python3.12 python3.10 python3; do
    if command -v "$candidate" >/dev/null &&
      "$candidate" -c 'import sys; sys.exit(not (3, 9) <= sys.version_info[:2] <= (3, 12))' 2>/dev/null; then
      python=$candidate
      break
    fi
  done
  if "$python" -c 'import sys; sys.exit(not (3, 9) <= sys.version_info[:2] <= (3, 12))'; then
    "$python" -m venv --clear .deps/venv
  else
    # MediaPipe 0.10.21 has no wheels for newer interpreters: let uv bring one that it supports.
    say "python3 is too new for MediaPipe 0.10.21; fetching Python 3.11 with uv"
    "$python" -m venv --clear .deps/uv
    .deps/uv/bin/pip install -q uv
    .deps/uv/bin/uv venv -q --clear --seed --python 3.11 .deps/venv
  fi
  # --no-deps: MediaPipe names packages (jax, opencv-contrib, sounddevice) that hand tracking never imports.
  .deps/venv/bin/python -m pip install -q --disable-pip-version-check --no-deps -r models/estimators/requirements.txt
  cp models/estimators/requirements.txt "$stamp"
}

# fetch_library NAME VERSION PATH_IN_WHEEL TARGET SHA256_X86_64 SHA256_AARCH64
fetch_library() {
  local name=$1 version=$2 member=$3 target=$4 sum
  [ -f "$target" ] && return
  case "$(uname -m)" in
    x86_64) sum=$5 ;;
    aarch64) sum=$6 ;;
    *) fail "no pinned $name wheel for $(uname -m): put the library at $target yourself" ;;
  esac
  say "fetching $name $version"
  local work
  work=$(mktemp -d .deps/fetch.XXXXXX)
  .deps/venv/bin/python -m pip download -q --disable-pip-version-check --no-deps --only-binary=:all: --python-version 311 \
    --implementation cp --abi cp311 --platform "manylinux_2_28_$(uname -m)" -d "$work" "$name==$version"
  local wheel
  wheel=$(echo "$work"/*.whl)
  echo "$sum  $wheel" | sha256sum --check --quiet || fail "the $name wheel does not have its pinned checksum"
  mkdir -p "$(dirname "$target")"
  unzip -qo "$wheel" "$member" -d "$work"
  mv "$work/$member" "$target.part"
  mv "$target.part" "$target"
  rm -rf "$work"
}

install_debian_packages
check_rust
mkdir -p .deps
make_python_environment
fetch_library mujoco 3.17.0 mujoco/libmujoco.so.3.17.0 .deps/mujoco/lib/libmujoco.so.3.17.0 \
  d66928d86a2d1b601bbaa4dc11db50214d17d5301bb8afd84721313b67ff0874 \
  91a70ed9979c383ff1f5c03f25cc2e1280a8254c1a8e558d5dd7f4184f01efc9
ln -sfn libmujoco.so.3.17.0 .deps/mujoco/lib/libmujoco.so
fetch_library onnxruntime 1.31.1 onnxruntime/capi/libonnxruntime.so.1.31.1 .deps/onnxruntime/libonnxruntime.so.1.31.1 \
  5752bd508126ae7c49894d3b9d2e83f0c3d487319246d04c444b393308d7ad7f \
  da05378364c44d4407e463982d2bf8d5e4cfea873283757e48beeb41df97b7f3
say "ready"
