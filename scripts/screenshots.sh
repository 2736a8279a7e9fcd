#!/usr/bin/env bash
# Takes a picture of every step of the real window, in both themes: screenshots.sh [CLIP|SESSION|MANIFEST] [DIR]
# Without a clip it makes the demo episode and shows that.
set -euo pipefail
cd "$(dirname "$0")/.."

input=${1:-}
out=${2:-out/screenshots}
mkdir -p "$out"
if [ -z "$input" ]; then
  [ -e out/demo/episode.afs ] || cargo run --locked --quiet -- demo --out out/demo
  input=out/demo/episode.afs
fi
run=(cargo run --locked --quiet -p agenticfocus-ui -- --screenshots "$out" --out "$out/sessions" "$input")
if [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]; then
  exec "${run[@]}"
fi
command -v Xvfb >/dev/null || { echo "screenshots: no display and no Xvfb: sudo apt-get install xvfb" >&2; exit 1; }
display=:$((90 + RANDOM % 800))
Xvfb "$display" -screen 0 1440x900x24 -nolisten tcp >/dev/null 2>&1 &
server=$!
trap 'kill "$server"' EXIT
sleep 1
DISPLAY=$display "${run[@]}"
echo "screenshots: in $out"
