#!/usr/bin/env bash
# tests/gpu/run_test.sh BUILD: tests/gpu/run.sh's own rules, shown by dry runs without a GPU: order,
# --only, a step that fails, one that hangs, and a summary that is there at every moment.
set -euo pipefail

run=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/run.sh
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
build=$1

die() {
  echo "run_test.sh: $*" >&2
  exit 1
}
# dry NAME ARGS...: exit status in $status, the steps of the summary in $steps.
dry() {
  local name=$1
  shift
  status=0
  "$run" --dry-run --build "$build" --out "$work/$name" "$@" >"$work/$name.log" 2>&1 || status=$?
  [[ -f $work/$name/summary.json ]] || die "no summary: $(cat "$work/$name.log")"
  steps=$(steps_of "$work/$name")
}
steps_of() { sed -n 's/.*"name": "\([^"]*\)", "result": "\([^"]*\)".*/\1=\2/p' "$1/summary.json"; }
place() { grep -n "^$1=" <<<"$steps" | cut -d : -f 1; }
expect() { grep -qx "$1" <<<"$steps" || die "no '$1' in: $steps"; }

# What a carried folder holds, from the system's packages. From nothing each time: CMake remembers
# what an earlier call found.
rm -rf "$build"
mkdir -p "$work/carried"
ln -s /usr/include /usr/src "$work/carried"
: >"$work/carried/scene.tar.xz"

dry first --carried "$work/carried"
[[ $status -eq 0 ]] || die "a dry run fails: $(cat "$work/first.log")"
for name in configure build parity player repeats training avatar bench unpack scene scene_pruned \
  memcheck initcheck racecheck memcheck-player memcheck-training memcheck-avatar \
  initcheck-player initcheck-training initcheck-avatar; do
  expect "$name=passed"
done
[[ $(place scene) -lt $(place memcheck) ]] || die "the first call should train before the sanitizers"

dry second --carried "$work/carried"
[[ $(place scene) -gt $(place initcheck-avatar) ]] || die "the second call should train at the end"

dry only --only bench,memcheck-avatar
[[ $steps == $'configure=passed\nbuild=passed\nbench=passed\nmemcheck-avatar=passed' ]] ||
  die "--only ran $steps"

dry fails --fail bench
[[ $status -eq 1 ]] || die "a step that fails should be told by the exit status"
expect 'bench=failed (1)'
expect 'initcheck-avatar=passed' # those after it run all the same

dry no_build --fail build
[[ $status -eq 1 && $(wc -l <<<"$steps") -eq 2 ]] || die "nothing runs that was not built: $steps"

begin=$SECONDS
dry hangs --only player,parity --hang parity --minutes 1
[[ $status -eq 1 ]] || die "a step that hangs should be told by the exit status"
expect 'parity=over 5 s'
expect 'player=passed'
[[ $((SECONDS - begin)) -le 60 ]] || die "it did not end within its minutes"

"$run" --dry-run --build "$build" --out "$work/killed" --hang bench >/dev/null 2>&1 &
for _ in $(seq 100); do
  sleep 0.2
  grep -qs '"avatar"' "$work/killed/summary.json" && break
done
kill -9 $!
wait 2>/dev/null || true
pkill -9 -f "$work/killed" || true
steps=$(steps_of "$work/killed")
expect 'avatar=passed'
if grep -q '^bench=' <<<"$steps"; then die "bench cannot have ended"; fi

for bad in '--only nothing' '--minutes x' '--fail bench' '--surprise'; do
  status=0
  # shellcheck disable=SC2086
  if [[ $bad == --fail* ]]; then
    "$run" $bad >/dev/null 2>&1 || status=$?
  else
    "$run" --dry-run $bad >/dev/null 2>&1 || status=$?
  fi
  [[ $status -eq 2 ]] || die "'$bad' should be refused"
done
echo "run.sh keeps its rules"
