#!/usr/bin/env bash
# tests/gpu/carry.sh [FOLDER]: gathers what the lean build needs beside the sources, from this
# machine's packages (libhwy-dev, libeigen3-dev, libgtest-dev), into build/gpu-carried: about 7 MB.
# Take it along to the machine with the card; tests/gpu/run.sh finds it there.
set -euo pipefail

root=$(readlink -f "$(dirname "${BASH_SOURCE[0]}")/../..")
to=${1:-$root/build/gpu-carried}
highway=/usr/include/hwy
eigen=/usr/include/eigen3/Eigen
googletest=/usr/src/googletest/googletest

for from in "$highway/highway.h" "$eigen/Core" "$googletest/src/gtest-all.cc"; do
  [[ -f $from ]] || { echo "carry.sh: there is no $from" >&2; exit 2; }
done
rm -rf "$to"
mkdir -p "$to/include/eigen3/Eigen/src" "$to/googletest"
cp -r "$highway" "$to/include/hwy"
cp "$eigen/Core" "$to/include/eigen3/Eigen/"
cp -r "$eigen/src/Core" "$eigen/src/plugins" "$to/include/eigen3/Eigen/src/"
cp -r "$googletest/src" "$googletest/include" "$to/googletest/"
echo "$to: $(du -sh "$to" | cut -f 1)"
