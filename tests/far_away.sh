#!/usr/bin/env bash
# tests/far_away.sh COSPLAT SCENE [-r N] [--iterations N] [--keep FOLDER] [-- OPTIONS]: what a scene
# loses far from the origin, and in other units. Trains on SCENE (COLMAP's, binary) where it is, in
# UTM, turned in ECEF, in millimetres and in kilometres, and prints figures of its test views as a
# table. Needs python3.
#   -r N             images of 1/N of their size (8)
#   --iterations N   of every training (1000)
#   --keep FOLDER    where data and runs go, and stay, and are not made again
#   -- OPTIONS       of train-scene, for all of them
set -euo pipefail

arguments=(cosplat scene) divisor=8 iterations=1000
source "$(dirname "${BASH_SOURCE[0]}")/support/measure_options.sh"

# moved FOLDER SCALE DEGREES X Y Z: the scene, scaled, turned about (1, 1, 1) and moved.
moved() {
  python3 - "$scene" "$@" <<'PY'
import math, os, shutil, struct, sys
scene, folder = map(os.path.abspath, sys.argv[1:3])
scale, degrees, *middle = map(float, sys.argv[3:])
c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees)) / math.sqrt(3)
turn = [[c + (1 - c) / 3 if i == j else (1 - c) / 3 + s * (-1 if (j - i) % 3 == 1 else 1)
         for j in range(3)] for i in range(3)]

def times(matrix, v):
    return [sum(a * b for a, b in zip(row, v)) for row in matrix]

def product(p, q):  # of quaternions, w first
    return [p[0] * q[0] - sum(p[i] * q[i] for i in (1, 2, 3))] + [
        p[0] * q[i] + p[i] * q[0] + p[j] * q[k] - p[k] * q[j] for i, j, k in ((1, 2, 3), (2, 3, 1), (3, 1, 2))]

def turned(q, v):
    return product(product(q, [0, *v]), [q[0], *(-x for x in q[1:])])[1:]

half = math.radians(degrees) / 2
back = [math.cos(half)] + [-math.sin(half) / math.sqrt(3)] * 3

def copy(name, head, change, tail):
    data = open(f"{scene}/sparse/0/{name}", "rb").read()
    out, at = bytearray(data[:8]), 8
    for _ in range(struct.unpack_from("<Q", data)[0]):
        values = struct.unpack_from(head, data, at)
        out += struct.pack(head, *change(values))
        at += struct.calcsize(head)
        end = tail(data, at)
        out += data[at:end]
        at = end
    open(f"{folder}/sparse/0/{name}", "wb").write(out)

def image(v):  # x_camera = R x + t
    rotation = product(v[1:5], back)
    away = turned(rotation, middle)
    return (v[0], *rotation, *(scale * t - a for t, a in zip(v[5:8], away)), v[8])

def after_image(data, at):
    at = data.index(b"\0", at) + 1
    return at + 8 + 24 * struct.unpack_from("<Q", data, at)[0]

os.makedirs(f"{folder}/sparse/0")
for name in os.listdir(scene):
    if name.startswith("images"):
        os.symlink(f"{scene}/{name}", f"{folder}/{name}")
shutil.copy(f"{scene}/sparse/0/cameras.bin", f"{folder}/sparse/0")
copy("images.bin", "<I7dI", image, after_image)
copy("points3D.bin", "<Q3d", lambda v: (v[0], *(scale * x + m for x, m in zip(times(turn, v[1:]), middle))),
     lambda data, at: at + 19 + 8 * struct.unpack_from("<Q", data, at + 11)[0])
PY
}

echo "$(basename "$scene"), 1/$divisor of its size, $iterations steps"
echo
echo "| where | PSNR, seeds 0 to 2 |"
echo "|---|---|"
while IFS='|' read -r name place; do
  data="$work/${name//[ ,]/-}" psnr=
  # shellcheck disable=SC2086
  [[ -d $data ]] || moved "$data" $place
  for seed in 0 1 2; do
    run="$data-$seed"
    "$cosplat" train-scene -s "$data" -m "$run" -r "$divisor" --eval --resume --quiet \
      --iterations "$iterations" --seed "$seed" "${options[@]}"
    psnr+=$(printf '%s%.2f' "${psnr:+, }" "$(figure PSNR "$run/results.json")")
  done
  echo "| $name | $psnr dB |"
done <<'PLACES'
where it is|1 0 0 0 0
turned|1 70 0 0 0
in UTM|1 0 691000 5336000 520
turned, in ECEF|1 70 4180000 850000 4730000
in millimetres|1000 0 0 0 0
in kilometres|0.001 0 0 0 0
PLACES
