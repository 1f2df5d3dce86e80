#!/usr/bin/env bash
# Everything that needs a GPU, in one command, for a machine that has one and little else (nvcc,
# CMake, ninja, a C++ compiler): builds the lean configuration, runs the parity tests, which fail
# where there is no device, compute-sanitizer's tools over small cases, the tests over and over, and
# the benchmark, and whole trainings of the scene that tests/gpu/carry.sh --scene packed. Writes
# summary.json, bench.json, scene.json, scene_pruned.json, image.ppm and log.txt. Prints a table at
# the end; exits with 0 only if all of it passed. There is no display on such a machine: OpenGL's
# textures (splat/render/cuda/gl_texture.cpp) are not covered.
set -uo pipefail

show_help() {
  cat <<'TEXT'
tests/gpu/run.sh [--out DIR] [--build DIR] [--carried DIR] [--minutes N] [--prune-to N] [--dry-run]
  --out DIR      where results go: $OUT, or out/gpu
  --build DIR    where to build: build/gpu-tests
  --carried DIR  what tests/gpu/carry.sh gathered: build/gpu-carried, or the system's where that is
                 not there
  --minutes N    for all of it, at most: 8
  --prune-to N   Gaussians that the packed scene's second training leaves: 56700
  --dry-run      checks what can be checked without a GPU and says what would be run
Not covered, since it needs a display: pictures that go straight into a window (cosplat play --device cuda).
TEXT
}

root=$(readlink -f "$(dirname "${BASH_SOURCE[0]}")/../..")
out=${OUT:-$root/out/gpu}
build=$root/build/gpu-tests
carried=$root/build/gpu-carried
minutes=8
prune_to=56700  # docs/performance.md has it of the chair
dry=false
while [[ $# -gt 0 ]]; do
  case $1 in
    --out | --build | --carried | --minutes | --prune-to)
      [[ $# -ge 2 ]] || { echo "run.sh: $1 needs a value" >&2; exit 2; }
      name=${1#--}
      declare "${name//-/_}=$2"
      shift 2
      ;;
    --dry-run) dry=true; shift ;;
    -h | --help) show_help; exit 0 ;;
    *) show_help >&2; echo "run.sh: there is no '$1'" >&2; exit 2 ;;
  esac
done
[[ $minutes =~ ^[0-9]+$ ]] || { echo "run.sh: --minutes $minutes is no number" >&2; exit 2; }
[[ -d $carried ]] || carried=/usr
export PATH=$PATH:/usr/local/cuda/bin
export COSPLAT_REQUIRE_DEVICE=1
tests=$build/tests/gpu/cosplat_test_parity
player=$build/tests/gpu/cosplat_test_player_parity
training=$build/tests/gpu/cosplat_test_training_parity
avatar=$build/tests/gpu/cosplat_test_avatar_training_parity
bench=$build/tests/gpu/cosplat_bench_cuda

names=() results=() seconds=()

# step NAME LIMIT_S COMMAND...: runs it within its limit and what is left of all; its output goes
# into log.txt.
step() {
  local name=$1 limit=$2 left=$((minutes * 60 - SECONDS)) begin=$SECONDS result
  shift 2
  [[ $left -lt $limit ]] && limit=$left
  if $dry; then
    echo "$name: $*"
    result=planned
  elif [[ $limit -lt 5 ]]; then
    result="no time left"
  else
    local log=$build/$name.log
    if timeout "$limit" "$@" >"$log" 2>&1; then
      result=passed
    else
      result="failed ($?)"
      echo "--- $name: the end of what it said" >&2
      tail -n 15 "$log" >&2
    fi
    { echo "=== $name: $*"; cat "$log"; } >>"$out/log.txt"
  fi
  names+=("$name") results+=("$result") seconds+=("$((SECONDS - begin))")
  [[ $result == passed || $result == planned ]]
}

# The GPU's architecture; without a GPU nvcc's usual one.
architecture() {
  local capability
  capability=$(nvidia-smi --query-gpu=compute_cap --format=csv,noheader 2>/dev/null | head -n 1)
  echo "${capability:-9.0}" | tr -d '. '
}

check_tools() {
  local tool missing=()
  for tool in nvcc cmake ninja c++; do
    command -v "$tool" >/dev/null || missing+=("$tool")
  done
  [[ ${#missing[@]} -eq 0 ]] || { echo "run.sh: not found: ${missing[*]}" >&2; exit 2; }
}

# With `cosplat train-scene`'s settings, unpruned and pruned.
train_scene() {
  local scene=$build/scene
  if [[ -f $carried/scene.xz ]]; then
    step unpack 60 sh -c "xz -dc '$carried/scene.xz' > '$scene'" || return
    step scene 240 "$bench" scene "$scene" --out "$out/scene.json"
    step scene_pruned 240 "$bench" scene "$scene" --out "$out/scene_pruned.json" \
      --prune-to "$prune_to"
  fi
}

# Small cases: the tools slow a program down a hundredfold.
sanitize() {
  local tool=$1
  shift
  step "$tool" 100 compute-sanitizer --tool "$tool" --error-exitcode 9 "$@" "$tests" \
    --gtest_filter='RasterizerParity.*:LossParity.OnConstant*:OptimizerParity.*:DeviceSort.*:StepParity.*:*Room*'
}

write_summary() {
  local i card
  card=$(nvidia-smi --query-gpu=name,driver_version --format=csv,noheader 2>/dev/null | head -n 1)
  {
    echo "{\"card\": \"${card}\", \"nvcc\": \"$(nvcc --version | sed -n 's/.*release \([0-9.]*\).*/\1/p')\","
    echo " \"steps\": ["
    for i in "${!names[@]}"; do
      [[ $i -eq 0 ]] || echo ","
      printf '  {"name": "%s", "result": "%s", "seconds": %s}' \
        "${names[$i]}" "${results[$i]}" "${seconds[$i]}"
    done
    echo "]}"
  } >"$out/summary.json.part"
  mv "$out/summary.json.part" "$out/summary.json"
}

finish() {
  local i failed=0
  $dry || write_summary
  for i in "${!names[@]}"; do
    printf '%-14s %-14s %4s s\n' "${names[$i]}" "${results[$i]}" "${seconds[$i]}"
    [[ ${results[$i]} == passed || ${results[$i]} == planned ]] || failed=1
  done
  exit $failed
}

check_tools
if ! $dry; then
  mkdir -p "$out" "$build"
  : >"$out/log.txt"
fi
configure=(cmake --preset gpu-tests -S "$root" -B "$build" "-DCOSPLAT_CARRIED=$carried"
  "-DCMAKE_CUDA_ARCHITECTURES=$(architecture)")
if $dry; then
  # Configuring needs no GPU, and finds what is missing.
  (cd "$root" && "${configure[@]}") >/dev/null || exit 1
fi
cd "$root" || exit 1
step configure 60 "${configure[@]}" || finish
step build 240 cmake --build "$build" --parallel "$(nproc)" || finish
step parity 60 "$tests"
step player 60 "$player"
step repeats 60 "$tests" --gtest_repeat=10 --gtest_break_on_failure \
  --gtest_filter='*SameBits*:*LeavesNoTrace*:StepParity.*'
step training 60 "$training"
step avatar 60 "$avatar"
step bench 150 "$bench" --out "$out/bench.json" --image "$out/image.ppm"
train_scene
if $dry || command -v compute-sanitizer >/dev/null; then
  sanitize memcheck --leak-check full
  sanitize initcheck
  sanitize racecheck
  for tool in memcheck initcheck; do
    step "$tool-player" 60 compute-sanitizer --tool "$tool" --error-exitcode 9 "$player" \
      --gtest_filter='PosingParity.*:PlayerParity.DrawsOneGaussianAndNone'
    step "$tool-training" 60 compute-sanitizer --tool "$tool" --error-exitcode 9 "$training" \
      --gtest_filter='DensityParity.*:MaskParity.ASoft*:TrainingParity.TheRegulariserOfScales'
    step "$tool-avatar" 60 compute-sanitizer --tool "$tool" --error-exitcode 9 "$avatar" \
      --gtest_filter='AvatarTrainingParity.RefinesTheTrack'
  done
else
  names+=(sanitizer) results+=("not found") seconds+=(0)
fi
finish
