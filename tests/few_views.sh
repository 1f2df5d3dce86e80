#!/usr/bin/env bash
# tests/few_views.sh COSPLAT SCENE [-r N] [--iterations N] [--keep FOLDER] [-- OPTIONS]: what a scene
# keeps of few views. Trains on 10, 20 and 35 of SCENE's training views (transforms_train.json),
# evenly spread, and prints figures of 32 others of them as a table. Needs python3.
#   -r N             images of 1/N of their size (8)
#   --iterations N   of every training (3000)
#   --keep FOLDER    where data and runs go, and stay, and are not made again
#   -- OPTIONS       of train-scene, for all of them
set -euo pipefail

arguments=(cosplat scene) divisor=8 iterations=3000
source "$(dirname "${BASH_SOURCE[0]}")/support/measure_options.sh"

# subset COUNT FOLDER
subset() {
  python3 - "$scene" "$1" "$2" <<'PY'
import json, os, sys
scene, count, folder = os.path.abspath(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
os.makedirs(folder)
for name in os.listdir(scene):
    if not name.startswith("transforms"):
        os.symlink(os.path.join(scene, name), os.path.join(folder, name))
data = json.load(open(os.path.join(scene, "transforms_train.json")))
frames = data["frames"]
chosen = [round(i * (len(frames) - 1) / (count - 1)) for i in range(count)]
others = [i for i in range(len(frames)) if i not in chosen]
for split, which in ("train", chosen), ("test", others[::2][:32]):
    with open(os.path.join(folder, f"transforms_{split}.json"), "w") as file:
        json.dump({**data, "frames": [frames[i] for i in which]}, file)
PY
}

echo "$(basename "$scene"), 1/$divisor of its size, $iterations steps"
echo
echo "| training views | PSNR | SSIM | Gaussians |"
echo "|---|---|---|---|"
for views in 10 20 35; do
  [[ -d $work/$views ]] || subset "$views" "$work/$views"
  "$cosplat" train-scene -s "$work/$views" -m "$work/run-$views" -r "$divisor" --eval --resume \
    --quiet --iterations "$iterations" "${options[@]}"
  printf '| %d | %.2f dB | %.4f | %d |\n' "$views" \
    "$(figure PSNR "$work/run-$views/results.json")" \
    "$(figure SSIM "$work/run-$views/results.json")" \
    "$(figure gaussians "$work/run-$views/stats.json")"
done
