#!/usr/bin/env bash
# tests/scales.sh COSPLAT SCENE [-r N] [--iterations N] [--keep FOLDER] [-- OPTIONS]: what
# `train-scene --antialiasing` is worth at other image sizes than it was trained at, as the paper of
# Mip-Splatting measures it. Trains SCENE with and without it on images of 1/N of their size and of
# 1/8 of that, draws the test views of each at 1, 1/2, 1/4 and 1/8, and prints their PSNR as a table.
#   -r N             the largest size: 1/N of the data's (1)
#   --iterations N   of every training (30000)
#   --keep FOLDER    where the runs go, and stay, and are not trained again
#   -- OPTIONS       of train-scene, for all of them
set -euo pipefail

arguments=(cosplat scene) divisor=1 iterations=30000
source "$(dirname "${BASH_SOURCE[0]}")/support/measure_options.sh"

# Mean PSNR of the run's test views at 1/$2 of the data's size.
psnr() {
  "$cosplat" render -m "$1" -r "$2" --quiet || return 1
  "$cosplat" metrics -m "$1" > "$work/metrics.txt" || return 1
  figure PSNR "$1/results.json"
}

echo "$(basename "$scene"), largest size 1/$divisor of the data's, $iterations steps, PSNR in dB"
echo
echo "| trained at | anti-aliasing | 1 | 1/2 | 1/4 | 1/8 | mean |"
echo "|---|---|---|---|---|---|---|"
for trained in 1 8; do
  for option in "" --antialiasing; do
    run=$work/trained_$trained$option
    # shellcheck disable=SC2086 # no option is no argument
    "$cosplat" train-scene -s "$scene" -m "$run" -r $((trained * divisor)) --eval --resume --quiet \
      --iterations "$iterations" --save_iterations "$iterations" $option "${options[@]}"
    row=()
    for drawn in 1 2 4 8; do
      value=$(psnr "$run" $((drawn * divisor))) || exit 1
      row+=("$value")
    done
    printf '%s\n' "${row[@]}" | awk -v trained="$trained" -v option="${option:+yes}" '
      { line = line sprintf(" %.2f |", $1); sum += $1 }
      END { printf "| %s | %s |%s %.2f |\n", trained == 1 ? "1" : "1/8", option ? option : "no",
                   line, sum / NR }'
  done
done
