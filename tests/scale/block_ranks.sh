#!/usr/bin/env bash
# tests/scale/block_ranks.sh BUILD [--iterations N] [--keep FOLDER] [-- OPTIONS]: what blocks cost
# and gain where photographs show a part of the scene each. Makes the village (cosplat_make_village)
# as seen from 1 and 5 metres, alone and four of it far from each other, trains each in one piece
# and in blocks, by one rank of one thread and by two, and prints as a table: Gaussians, PSNR of the test views, seconds of training. Blocks that differ with the number of ranks
# are an error. Needs mpirun.
#   --iterations N   of every training of one village (3000), four times as many of four
#   --keep FOLDER    where data and runs go, and stay, and are not made again
#   -- OPTIONS       of train-scene, for all of them
set -euo pipefail

arguments=(build) divisor=1 iterations=3000
source "$(dirname "${BASH_SOURCE[0]}")/../support/measure_options.sh"
cosplat=$build/apps/cosplat make=$build/tests/altitudes/cosplat_make_village

# train RUN RANKS SCENE BLOCKS ITERATIONS
train() {
  local run=$1 ranks=$2 scene=$3
  [[ -f $run/results.json ]] && return
  mpirun --allow-run-as-root --oversubscribe -n "$ranks" "$cosplat" train-scene -s "$scene" \
    -m "$run" --overwrite --eval --threads 1 --blocks "$4" --iterations "$5" "${options[@]}" \
    >"$run.log" 2>"$run.err"
}

echo "400x300 px, 60 pictures per height and village, 16 test views per village"
echo
echo "| villages | blocks | ranks | Gaussians | PSNR | training |"
echo "|---|---|---|---|---|---|"
for case in "1 6" "4 4"; do
  read -r places blocks <<<"$case"
  scene=$work/villages-$places
  [[ -f $scene/transforms_test.json ]] || "$make" "$scene" 60 2 "$places"
  for count in "1 1" "$blocks 1" "$blocks 2"; do
    read -r in_blocks ranks <<<"$count"
    run=$work/villages-$places-blocks-$in_blocks-ranks-$ranks
    train "$run" "$ranks" "$scene" "$in_blocks" $((places * iterations))
      awk -v places="$places" -v blocks="$in_blocks" -v ranks="$ranks" \
      -v n="$(figure gaussians "$run/stats.json")" -v psnr="$(figure PSNR "$run/results.json")" \
      -v s="$(figure seconds "$run/stats.json")" 'BEGIN {
        printf "| %d | %d | %d | %d | %.2f dB | %.0f s |\n", places, blocks, ranks, n, psnr, s }'
  done
  cmp "$work/villages-$places-blocks-$blocks-ranks-"{1,2}/point_cloud/iteration_*/point_cloud.ply
done
