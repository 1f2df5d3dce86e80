#!/usr/bin/env bash
# tests/same_bits.sh OLD NEW [--scene FOLDER] [--keep FOLDER] [--short]: whether two builds of `cosplat` train to
# the same bits on the CPU. Trains the same short runs with both, OLD on one thread, NEW on one and on
# two, and compares every .ply and .glb by its SHA-256; exits with 1 where one differs.
#   --scene FOLDER   a scene of images, too (transforms.json or COLMAP), at an eighth of its size
#   --keep FOLDER    where the runs go, and stay; without it they are deleted
#   --short          the first of the runs only
# For changes that must not change results: before and after a redesign.
set -euo pipefail

[[ $# -ge 2 ]] || { sed -n '2,8s/^# \{0,1\}//p' "$0"; exit 2; }
old=$1 new=$2
shift 2
scene= keep= short=0
while [[ $# -gt 0 ]]; do
  case $1 in
    --scene | --keep)
      [[ $# -ge 2 ]] || { echo "same_bits.sh: $1 needs a value" >&2; exit 2; }
      if [[ $1 == --scene ]]; then scene=$2; else keep=$2; fi
      shift 2
      ;;
    --short) short=1; shift ;;
    *) echo "same_bits.sh: there is no '$1'" >&2; exit 2 ;;
  esac
done
work=${keep:-$(mktemp -d)}
mkdir -p "$work"
[[ -n $keep ]] || trap 'rm -rf "$work"' EXIT

"$old" make-head -o "$work/head" --frames 40 --test-frames 8 --size 128 --quiet
avatar=(train-avatar -s "$work/head" --flame "$work/head/model.npz" --gaussians 2000)

# The sums of what a run leaves: `run BINARY THREADS ARGUMENTS...`
run() {
  local binary=$1 threads=$2
  shift 2
  rm -rf "$work/run"
  "$binary" "$@" -m "$work/run" --threads "$threads" --quiet >&2
  (cd "$work/run" && find . -name '*.ply' -o -name '*.glb' | LC_ALL=C sort | xargs sha256sum)
}

differing=0
compare() {
  local name=$1
  shift
  local expected
  expected=$(run "$old" 1 "$@")
  for threads in 1 2; do
    if [[ $(run "$new" "$threads" "$@") == "$expected" ]]; then
      echo "same      $name, $threads thread(s), $(wc -l <<<"$expected") files"
    else
      echo "DIFFERENT $name, $threads thread(s)"
      differing=1
    fi
  done
}

compare "made head" "${avatar[@]}" --iterations 300
[[ $short -eq 0 ]] || exit $differing
compare "made head, track refined" "${avatar[@]}" --iterations 300 --refine-track
compare "made head, pruned to 1000" "${avatar[@]}" --iterations 300 --prune-to 1000
compare "made head, as SplattingAvatar" "${avatar[@]}" --iterations 200 --preset splatting-avatar
compare "made head, released rules" "${avatar[@]}" --iterations 200 --preset splatting-avatar-released
compare "made head, budget" "${avatar[@]}" --iterations 300 --budget auto --eval
if [[ -n $scene ]]; then
  images=(train-scene -s "$scene" -r 8)
  compare "scene" "${images[@]}" --iterations 600
  compare "scene, as 3DGS, SH" "${images[@]}" --iterations 600 --preset 3dgs --basis sh
  compare "scene, pruned to 3000" "${images[@]}" --iterations 600 --prune-to 3000
  compare "scene, learned mask" "${images[@]}" --iterations 400 --prune lp
  compare "scene, budget" "${images[@]}" --iterations 400 --budget auto --eval
fi
exit $differing
