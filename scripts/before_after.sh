#!/usr/bin/env bash
# Makes the README's picture from the demo episode: the source above, the composite below.
# usage: scripts/before_after.sh out/demo assets/demo/before_after.png
set -euo pipefail
demo=$1 picture=$2
pick="select='eq(n\,35)+eq(n\,62)+eq(n\,92)',scale=400:-2,tile=3x1"
ffmpeg -nostdin -v error -y -i "$demo/synthetic/clip.mp4" -i "$demo/episode/composite.mp4" -filter_complex \
  "[0:v]$pick[before];[1:v]$pick[after];[before][after]vstack" -frames:v 1 "$picture"
