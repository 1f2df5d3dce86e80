#!/usr/bin/env bash
# tests/scale/blocks.sh COSPLAT SCENE [-r N] [--iterations N] [--keep FOLDER] [-- OPTIONS]: what
# `train-scene --blocks` saves and costs. Trains SCENE in one piece and in 4 blocks, and prints
# as a table: the peak of the process's memory, reading and evaluation included, also as a share of
# that of one piece; PSNR of the test views; seconds, also of the processor. Needs Debian's `time`.
#   -r N             images of 1/N of the data's size (8)
#   --iterations N   of every training (3000)
#   --keep FOLDER    where the runs go, and stay, and are not trained again
#   -- OPTIONS       of train-scene, for all of them
set -euo pipefail

arguments=(cosplat scene) divisor=8 iterations=3000
source "$(dirname "${BASH_SOURCE[0]}")/../support/measure_options.sh"

echo "$(basename "$scene"), 1/$divisor of the data's size, $iterations steps"
echo
echo "| blocks | Gaussians | peak | share | PSNR | time | of the processor |"
echo "|---|---|---|---|---|---|---|"
for blocks in 1 4; do
  run=$work/$blocks
  [[ -f $run/time.txt ]] || {
    rm -rf "$run"
    /usr/bin/time -o "$work/time.txt" -f "%M %e %U" "$cosplat" train-scene -s "$scene" -m "$run" \
      -r "$divisor" --eval --quiet --iterations "$iterations" --blocks "$blocks" "${options[@]}"
    mv "$work/time.txt" "$run/time.txt"
  }
  read -r kilobytes seconds of_processor <"$run/time.txt"
  [[ $blocks != 1 ]] || whole=$kilobytes
  awk -v blocks="$blocks" -v n="$(figure gaussians "$run/stats.json")" -v psnr="$(figure PSNR "$run/results.json")" \
    -v kb="$kilobytes" -v whole="$whole" -v s="$seconds" -v cpu="$of_processor" 'BEGIN {
      printf "| %d | %d | %.2f GB | %.2f | %.2f dB | %.0f s | %.0f s |\n",
             blocks, n, kb * 1024 / 1e9, kb / whole, psnr, s, cpu }'
done
