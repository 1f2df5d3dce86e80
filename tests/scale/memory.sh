#!/usr/bin/env bash
# tests/scale/memory.sh COSPLAT SCENE [-r N] [--iterations N] [--keep FOLDER] [-- OPTIONS]: how much
# memory and time a training of millions of Gaussians takes, against what it says before it begins.
# Trains a SCENE that has no points of its own on 2, 4, 8 and 10 million random ones, none of which
# it removes or adds in so few steps, and prints the peaks as a table. 10 million need 16 GB, and
# 3 GB of disk.
#   -r N             images of 1/N of the data's size (1)
#   --iterations N   of every training (100)
#   --keep FOLDER    where the runs go, and stay, and are not trained again
#   -- OPTIONS       of train-scene, for all of them
set -euo pipefail

arguments=(cosplat scene) divisor=1 iterations=100
source "$(dirname "${BASH_SOURCE[0]}")/../support/measure_options.sh"

echo "$(basename "$scene"), 1/$divisor of the data's size, $iterations steps"
echo
echo "| Gaussians | foretold | peak | bytes per Gaussian | time of a step |"
echo "|---|---|---|---|---|"
for millions in 2 4 8 10; do
  run=$work/$millions
  if [[ ! -f $run/results.txt ]]; then
    "$cosplat" train-scene -s "$scene" -m "$run" -r "$divisor" --iterations "$iterations" \
      --random-points "${millions}000000" --max-gaussians "${millions}000000" --overwrite \
      "${options[@]}" >"$work/log.txt" 2>"$work/progress.txt"
    foretold=$(sed -n 's/^memory: at most \([0-9.]*\) GB.*/\1/p' "$work/log.txt")
    stats=$run/stats.json
    echo "$foretold $(figure gaussians "$stats") $(figure peak_mb "$stats")" \
      "$(figure ms_per_step "$stats")" >"$run/results.txt"
    rm -rf "$run/point_cloud" "$run/input.ply" # gigabytes
  fi
  awk '{ printf "| %.2f million | %.2f GB | %.2f GB | %.0f | %.2f s |\n",
         $2 / 1e6, $1, $3 * 1048576 / 1e9, $3 * 1048576 / $2, $4 / 1e3 }' "$run/results.txt"
done
