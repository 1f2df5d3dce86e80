#!/usr/bin/env bash
# tests/altitudes/measure.sh BUILD [--iterations N] [--keep FOLDER] [-- OPTIONS]: what a scene that is
# photographed from 1, 5 and 25 metres' height keeps of each, with few and many pictures. Makes the
# village (cosplat_make_village), trains it on all heights together, and prints the PSNR of each
# height's test views as a table: with SH, by default, and with --antialiasing.
#   --iterations N   of every training (5000)
#   --keep FOLDER    where data and runs go, and stay, and are not made again
#   -- OPTIONS       of train-scene, for all of them
set -euo pipefail

arguments=(build) divisor=1 iterations=5000
source "$(dirname "${BASH_SOURCE[0]}")/../support/measure_options.sh"
cosplat=$build/apps/cosplat make=$build/tests/altitudes/cosplat_make_village

echo "400x300 px, $iterations steps, 8 test views per height, PSNR in dB"
echo
echo "| pictures per height | options | 1 m | 5 m | 25 m | mean | Gaussians |"
echo "|---|---|---|---|---|---|---|"
for pictures in 10 60; do
  [[ -f $work/$pictures/transforms_test.json ]] || "$make" "$work/$pictures" "$pictures"
  for option in "--basis sh" "" --antialiasing; do
    run=$work/run-$pictures${option// /-}
    # shellcheck disable=SC2086 # no option is no argument, and a basis is two
    "$cosplat" train-scene -s "$work/$pictures" -m "$run" --eval --resume --quiet \
      --iterations "$iterations" $option "${options[@]}"
    # Test views are numbered in their file's order, 8 of each height.
    sed -n '/"PSNR": {/,/}/s/.*"\([0-9]*\).png": \([0-9.]*\),*$/\1 \2/p' "$run/per_view.json" |
      awk -v pictures="$pictures" -v option="${option:-none}" \
        -v gaussians="$(figure gaussians "$run/stats.json")" '
        { sum[int($1 / 8)] += $2 }
        END { printf "| %d | `%s` | %.2f | %.2f | %.2f | %.2f | %d |\n", pictures, option, sum[0] / 8,
                     sum[1] / 8, sum[2] / 8, (sum[0] + sum[1] + sum[2]) / 24, gaussians }'
  done
done
