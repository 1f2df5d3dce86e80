#!/usr/bin/env bash
# Fuzzes the readers of what comes from outside under clang's address and undefined-behaviour
# sanitizers, and prints how many inputs each has read and what was found. tests/fuzz/run.sh --help
set -euo pipefail
root=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../..

usage() {
  cat <<'TEXT'
tests/fuzz/run.sh [--minutes N] [--jobs N] [--out DIR] [READER...]
  --minutes N  in all, shared by the readers; 5 (at least a second each)
  --jobs N     readers at the same time; as many as there are cores
  --out DIR    DIR/READER/ keeps the inputs that reach new code, so that the next run goes on from
               them; DIR/counts.txt the inputs read so far; DIR/found/ what was found. build/fuzz/out
READER: of those that tests/fuzz/*_readers.cpp list; all of them
Ends with 1 if anything was found: an error of a sanitizer, an exception other than Error, a number
that is not finite, more than 4 GB of memory, more than ten seconds for an input of 20 kB.
TEXT
}

minutes=5 jobs=$(nproc) out=$root/build/fuzz/out readers=()
while [[ $# -gt 0 ]]; do
  case $1 in
    --minutes) minutes=$2; shift 2 ;;
    --jobs) jobs=$2; shift 2 ;;
    --out) out=$2; shift 2 ;;
    -h | --help) usage; exit 0 ;;
    -*) usage >&2; exit 2 ;;
    *) readers+=("$1"); shift ;;
  esac
done

fuzzer=$root/build/fuzz/tests/fuzz/cosplat_fuzz_reader
[[ -f $root/build/fuzz/CMakeCache.txt ]] || (cd "$root" && cmake --preset fuzz) >&2
(cd "$root" && cmake --build --preset fuzz) >&2
mkdir -p "$out/seeds" "$out/found"
COSPLAT_SEEDS=$out/seeds "$fuzzer"
if [[ ${#readers[@]} -eq 0 ]]; then
  for dictionary in "$out"/seeds/*.dict; do readers+=("$(basename "$dictionary" .dict)"); done
fi
[[ $jobs -le ${#readers[@]} ]] || jobs=${#readers[@]}
seconds=$((minutes * 60 * jobs / ${#readers[@]}))
[[ $seconds -gt 0 ]] || seconds=1

# Inputs are written to memory.
if [[ -d /dev/shm ]]; then export TMPDIR=/dev/shm; fi
export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
# Short stacks of allocations and no weighing of inputs by how rare what they reach is: a third more
# inputs per second.
export ASAN_OPTIONS=malloc_context_size=2:quarantine_size_mb=4

# fuzz READER: fails if anything was found.
fuzz() {
  local reader=$1 log=$out/$1.log result=ok count
  mkdir -p "$out/$reader"
  COSPLAT_READER=$reader "$fuzzer" "$out/$reader" "$out/seeds/$reader" \
    -dict="$out/seeds/$reader.dict" -artifact_prefix="$out/found/$reader-" -max_len=20000 \
    -max_total_time="$seconds" -entropic=0 -timeout=10 -rss_limit_mb=4000 -malloc_limit_mb=2000 \
    -print_final_stats=1 -print_funcs=0 -verbosity=0 >"$log" 2>&1 || result="FOUND, see $log"
  count=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  echo "$reader ${count:-0}" >>"$out/counts.txt"
  awk -v reader="$reader" -v now="${count:-0}" -v result="$result" '$1 == reader { sum += $2 }
    END { printf "%-20s %10d inputs, %11d in all  %s\n", reader, now, sum, result }' "$out/counts.txt"
  [[ $result == ok ]]
}
export -f fuzz
export fuzzer out seconds
printf '%s\0' "${readers[@]}" | xargs -0 -n 1 -P "$jobs" bash -c 'fuzz "$1" || exit 1' fuzz || exit 1
