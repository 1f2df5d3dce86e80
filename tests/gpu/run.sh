#!/usr/bin/env bash
# Everything that needs a GPU, in one command, for a machine that has one and little else (nvcc,
# CMake, ninja, a C++ compiler): builds the lean configuration and runs the parity tests (which fail
# without a device), the benchmark, whole trainings of the scene that tests/gpu/carry.sh --scene
# packed, and compute-sanitizer's tools on small cases.
#
# Writes summary.json after every step, and bench.json, scene.json, scene_pruned.json, image.ppm and
# log.txt. It ends within --minutes, whatever a step does. What was built stays in --build: a second
# call builds nothing again, and runs the sanitizers before the long trainings. OpenGL textures
# (splat/render/cuda/gl_texture.cpp) are not covered, since such a machine has no display.
set -uo pipefail

show_help() {
  cat <<'TEXT'
tests/gpu/run.sh [--out DIR] [--build DIR] [--carried DIR] [--minutes N] [--prune-to N]
                 [--only STEP,STEP...] [--dry-run [--fail STEP] [--hang STEP]]
  --out DIR      where results go: $OUT, or out/gpu
  --build DIR    where to build: build/gpu-tests
  --carried DIR  what tests/gpu/carry.sh gathered: build/gpu-carried, or the system's packages if
                 that does not exist
  --minutes N    for all of it, at most: 8
  --prune-to N   Gaussians that the packed scene's second training leaves: 56700
  --only STEPS   these steps only, besides configure and build: parity, player, repeats, training,
                 avatar, bench, scene, scene_pruned, memcheck, initcheck, racecheck, and
                 memcheck-player, -training, -avatar, initcheck-player, -training, -avatar
  --dry-run      needs no GPU: configures, prints each step's command and pretends to run it
  --fail STEP    in a dry run, pretends that the step fails
  --hang STEP    in a dry run, pretends that the step hangs
Exits with 0 only if every step that was to run passed. Not covered, since it needs a display: images
that go straight into a window (cosplat play --device cuda).
TEXT
}

root=$(readlink -f "$(dirname "${BASH_SOURCE[0]}")/../..")
out=${OUT:-$root/out/gpu}
build=$root/build/gpu-tests
carried=$root/build/gpu-carried
minutes=8
prune_to=56700  # docs/performance.md has the chair's figures
only='' fail='' hang=''
dry=false
while [[ $# -gt 0 ]]; do
  case $1 in
    --out | --build | --carried | --minutes | --prune-to | --only | --fail | --hang)
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
[[ $minutes =~ ^[1-9][0-9]*$ ]] || { echo "run.sh: --minutes $minutes is no number" >&2; exit 2; }
$dry || [[ -z $fail$hang ]] || { echo "run.sh: --fail and --hang need --dry-run" >&2; exit 2; }
[[ -d $carried ]] || carried=/usr
export PATH=$PATH:/usr/local/cuda/bin
export COSPLAT_REQUIRE_DEVICE=1
tests=$build/tests/gpu/cosplat_test_parity
player=$build/tests/gpu/cosplat_test_player_parity
training=$build/tests/gpu/cosplat_test_training_parity
avatar=$build/tests/gpu/cosplat_test_avatar_training_parity
bench=$build/tests/gpu/cosplat_bench_cuda

all_steps=(parity player repeats training avatar bench scene scene_pruned memcheck initcheck racecheck)
for tool in memcheck initcheck; do all_steps+=("$tool-player" "$tool-training" "$tool-avatar"); done
for name in ${only//,/ }; do
  [[ " ${all_steps[*]} " == *" $name "* ]] || { echo "run.sh: --only: no step '$name'" >&2; exit 2; }
done

# Seconds that are left at the end for the summary, and for a step that does not obey the first
# signal.
reserve=20
grace=5

names=() results=() seconds=()

is_wanted() { [[ -z $only || ",$only," == *",$1,"* ]]; }

write_summary() {
  local i gpu
  gpu=$(nvidia-smi --query-gpu=name,driver_version --format=csv,noheader 2>/dev/null | head -n 1)
  {
    echo "{\"gpu\": \"${gpu}\", \"nvcc\": \"$(nvcc --version | sed -n 's/.*release \([0-9.]*\).*/\1/p')\","
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

# note NAME RESULT SECONDS
note() {
  names+=("$1") results+=("$2") seconds+=("$3")
  write_summary
}

# step NAME LIMIT_S COMMAND...: runs it within its limit and what is left of all; its output goes
# into log.txt.
step() {
  local name=$1 limit=$2 left=$((minutes * 60 - reserve - SECONDS)) begin=$SECONDS result status=0
  shift 2
  local command=("$@") log=$build/$name.log
  [[ $left -lt $limit ]] && limit=$left
  if $dry; then
    echo "$name: $*"
    command=(true)
    [[ $name == "$fail" ]] && command=(false)
    # Deaf to the first signal, as a kernel that never ends can make a process.
    [[ $name == "$hang" ]] && command=(bash -c 'trap "" TERM; while :; do sleep 1; done')
    [[ $limit -gt 5 ]] && limit=5
  fi
  if [[ $limit -lt 5 ]]; then
    result="no time left"
  else
    timeout --kill-after "$grace" "$limit" "${command[@]}" >"$log" 2>&1 || status=$?
    case $status in
      0) result=passed ;;
      124 | 137) result="over $limit s" ;;
      *) result="failed ($status)" ;;
    esac
    if [[ $status -ne 0 ]]; then
      echo "--- $name: $result; the end of its output:" >&2
      tail -n 15 "$log" >&2
    fi
    { echo "=== $name: $*"; cat "$log"; } >>"$out/log.txt"
  fi
  note "$name" "$result" "$((SECONDS - begin))"
  [[ $result == passed ]]
}

# The same, unless --only leaves it out.
wanted_step() { ! is_wanted "$1" || step "$@"; }

# The GPU's architecture; without a GPU nvcc's usual one.
architecture() {
  local capability
  capability=$(nvidia-smi --query-gpu=compute_cap --format=csv,noheader 2>/dev/null | head -n 1)
  echo "${capability:-9.0}" | tr -d '. '
}

check_tools() {
  local tool missing=()
  for tool in nvcc cmake ninja c++ timeout; do
    command -v "$tool" >/dev/null || missing+=("$tool")
  done
  [[ ${#missing[@]} -eq 0 ]] || { echo "run.sh: not found: ${missing[*]}" >&2; exit 2; }
}

# With the settings of `cosplat train-scene`, unpruned and pruned.
train_scenes() {
  local archive=$carried/scene.tar.xz
  is_wanted scene || is_wanted scene_pruned || return
  if [[ ! -f $archive ]]; then
    note scene "none packed" 0
    return
  fi
  [[ -f $build/scene ]] || step unpack 60 cmake -E chdir "$build" cmake -E tar xf "$archive" || return
  wanted_step scene 240 "$bench" scene "$build/scene" --out "$out/scene.json"
  wanted_step scene_pruned 240 "$bench" scene "$build/scene" --out "$out/scene_pruned.json" \
    --prune-to "$prune_to"
}

# sanitize NAME TOOL LIMIT_S PROGRAM FILTER [OPTION...]. Small cases: the tools slow a program down
# a hundredfold.
sanitize() {
  local name=$1 tool=$2 limit=$3 program=$4 filter=$5
  shift 5
  wanted_step "$name" "$limit" compute-sanitizer --tool "$tool" --error-exitcode 9 "$@" "$program" \
    --gtest_filter="$filter"
}

sanitize_all() {
  local tool
  local small='RasterizerParity.*:LossParity.OnConstant*:OptimizerParity.*:DeviceSort.*:StepParity.*:*Room*'
  if ! $dry && ! command -v compute-sanitizer >/dev/null; then
    note sanitizer "not found" 0
    return
  fi
  sanitize memcheck memcheck 100 "$tests" "$small" --leak-check full
  sanitize initcheck initcheck 100 "$tests" "$small"
  sanitize racecheck racecheck 100 "$tests" "$small"
  for tool in memcheck initcheck; do
    sanitize "$tool-player" "$tool" 60 "$player" \
      'PosingParity.*:PlayerParity.DrawsOneGaussianAndNone'
    sanitize "$tool-training" "$tool" 60 "$training" \
      'DensityParity.*:MaskParity.ASoft*:TrainingParity.TheRegulariserOfScales'
    sanitize "$tool-avatar" "$tool" 60 "$avatar" 'AvatarTrainingParity.RefinesTheTrack'
  done
}

finish() {
  local i failed=0
  for i in "${!names[@]}"; do
    printf '%-18s %-14s %4s s\n' "${names[$i]}" "${results[$i]}" "${seconds[$i]}"
    [[ ${results[$i]} == passed || ${results[$i]} == "none packed" ]] || failed=1
  done
  exit $failed
}

check_tools
mkdir -p "$out" "$build"
: >"$out/log.txt"
configure=(cmake --preset gpu-tests -S "$root" -B "$build" "-DCOSPLAT_CARRIED=$carried"
  "-DCMAKE_CUDA_ARCHITECTURES=$(architecture)")
if $dry; then
  # Configuring needs no GPU, and finds what is missing.
  (cd "$root" && "${configure[@]}") >/dev/null || exit 1
fi
cd "$root" || exit 1
begun_before=false
[[ -f $build/begun ]] && begun_before=true
step configure 60 "${configure[@]}" || finish
step build 240 cmake --build "$build" --parallel "$(nproc)" || finish
touch "$build/begun"
wanted_step parity 60 "$tests"
wanted_step player 60 "$player"
wanted_step repeats 60 "$tests" --gtest_repeat=10 --gtest_break_on_failure \
  --gtest_filter='*SameBits*:*LeavesNoTrace*:StepParity.*'
wanted_step training 60 "$training"
wanted_step avatar 60 "$avatar"
wanted_step bench 150 "$bench" --out "$out/bench.json" --image "$out/image.ppm"
if $begun_before; then
  sanitize_all
  train_scenes
else
  train_scenes
  sanitize_all
fi
finish
