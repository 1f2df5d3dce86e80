#!/usr/bin/env bash
# tests/photographs/measure.sh BUILD SCENE [-r N] [--iterations N] [--keep FOLDER] [-- OPTIONS]: what
# `train-scene --exposure` and masks bring back of what uneven exposure and things in the way cost.
# Spoils the training photographs of a COLMAP SCENE (cosplat_spoil_photographs), trains, and prints
# the test views' PSNR as a table: as they are, and with the exposure fitted on their left half and
# measured on the right.
#   -r N             images of 1/N of the data's size (8)
#   --iterations N   of every training (2000)
#   --keep FOLDER    where data and runs go, and stay, and are not made again
#   -- OPTIONS       of train-scene, for all of them
set -euo pipefail

arguments=(build scene) divisor=8 iterations=2000
source "$(dirname "${BASH_SOURCE[0]}")/../support/measure_options.sh"
cosplat=$build/apps/cosplat spoil=$build/tests/photographs/cosplat_spoil_photographs

for how in clean gains rectangles; do
  [[ -d $work/$how ]] || "$spoil" "$scene" "$work/$how" "$divisor" "$how"
done
for from in clean rectangles; do
  [[ -d $work/$from-other ]] || cp -r "$work/$from" "$work/$from-other"
done
rm -rf "$work/rectangles-other/masks"
[[ -d $work/clean-other/masks ]] || cp -r "$work/rectangles/masks" "$work/clean-other"

# row NAME DATA OPTIONS...
row() {
  local name=$1 data=$2 run=$work/run-$2-${*:3:1}
  "$cosplat" train-scene -s "$work/$data" -m "$run" --eval --resume --quiet \
    --iterations "$iterations" "${@:3}" "${options[@]}"
  "$cosplat" metrics -m "$run" --fit-exposure >"$work/metrics.txt"
  sed -n 's/.*PSNR \([0-9.]*\) dB .*/\1/p' "$work/metrics.txt" | paste -sd ' ' |
    { read -r as_is fitted && echo "| $name | $as_is | $fitted |"; }
}

echo "$(basename "$scene"), 1/$divisor of the data's size, $iterations steps, PSNR in dB"
echo
echo "| training photographs | as they are | exposure fitted |"
echo "|---|---|---|"
row "as they are" clean
row "as they are, \`--exposure\`" clean --exposure
row "gains of 0.7 to 1.3 per channel" gains
row "gains, \`--exposure\`" gains --exposure
row "three rectangles painted over" rectangles-other
row "rectangles, with masks" rectangles
row "as they are, with the rectangles' masks" clean-other
