#!/usr/bin/env bash
# tests/sanitizers.sh address|thread [CTEST OPTIONS...]
# Builds everything under the address and undefined-behaviour sanitizers, or the thread sanitizer, in
# build/asan or build/tsan, and runs the test suite. What the thread sanitizer must see into is built
# with it: oneTBB, from Debian's source, in build/tsan-tbb. Takes hours on two cores; `-R REGEX` runs a
# part. docs/fuzzing.md says what was found.
set -euo pipefail
cd "$(dirname "$0")/.."
usage() { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 2; }
[[ $# -gt 0 ]] || usage
kind=$1
shift

# oneTBB of the version that is installed, instrumented, in $1.
build_tbb() {
  local work=$1 parts
  [[ ! -e $work/done ]] || return 0
  rm -rf "$work"
  mkdir -p "$work/parts" "$work/lists/partial"
  # Debian's source packages, without a change to the machine's own list of packages.
  parts=(-o Dir::Etc::sourcelist=/dev/null -o Dir::Etc::sourceparts="$work/parts"
         -o Dir::State::lists="$work/lists")
  sed 's/^Types: deb$/Types: deb-src/' /etc/apt/sources.list.d/debian.sources > "$work/parts/debian.sources"
  apt-get "${parts[@]}" -qq update
  (cd "$work" && apt-get "${parts[@]}" -qq source --download-only onetbb)
  mkdir "$work/source"
  tar -xf "$work"/onetbb_*.orig.tar.xz -C "$work/source" --strip-components=1
  cmake -S "$work/source" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    -DCMAKE_INSTALL_PREFIX="$work/installed" -DTBB_TEST=OFF -DTBB_STRICT=OFF -DTBB_SANITIZE=thread
  cmake --build "$work/build"
  cmake --install "$work/build"
  touch "$work/done"
}

case $kind in
  address)
    cmake --preset asan
    cmake --build build/asan
    export ASAN_OPTIONS=strict_string_checks=1 UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
    ctest --test-dir build/asan --output-on-failure --timeout 3000 "$@"
    ;;
  thread)
    tbb=$PWD/build/tsan-tbb
    build_tbb "$tbb"
    cmake --preset tsan -DTBB_DIR="$tbb/installed/lib/cmake/TBB"
    cmake --build build/tsan
    # OpenCV loads the system's oneTBB otherwise, beside ours.
    export LD_LIBRARY_PATH=$tbb/installed/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
    export TSAN_OPTIONS=halt_on_error=1:second_deadlock_stack=1:suppressions=$PWD/tests/tsan.supp
    # GStreamer and OBS hand frames over by queues of GLib's and their own, which it does not see.
    ctest --test-dir build/tsan --output-on-failure --timeout 3000 -E '^(gstreamer|obs)$' "$@"
    ;;
  *) usage ;;
esac
