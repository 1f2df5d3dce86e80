#!/usr/bin/env bash
# tests/gpu/carry.sh [--scene FOLDER] [--every-test N] [FOLDER]: gathers what the lean build needs
# beside the sources, from this machine's packages (libhwy-dev, libeigen3-dev, libgtest-dev,
# libnanoflann-dev), into build/gpu-carried: about 10 MB. Take it along to the machine with the GPU;
# tests/gpu/run.sh finds it there.
#   --scene FOLDER   a scene for `train-scene`, too, packed by build/cpu's cosplat_pack_scene
#   --every-test N   of its test views every N-th: 2
set -euo pipefail

root=$(readlink -f "$(dirname "${BASH_SOURCE[0]}")/../..")
to=$root/build/gpu-carried
scene='' every_test=2
while [[ $# -gt 0 ]]; do
  case $1 in
    --scene | --every-test)
      [[ $# -ge 2 ]] || { echo "carry.sh: $1 needs a value" >&2; exit 2; }
      if [[ $1 == --scene ]]; then scene=$2; else every_test=$2; fi
      shift 2
      ;;
    -*) echo "carry.sh: there is no '$1'" >&2; exit 2 ;;
    *) to=$1; shift ;;
  esac
done
pack=$root/build/cpu/tests/cosplat_pack_scene
highway=/usr/include/hwy
nanoflann=/usr/include/nanoflann.hpp
eigen=/usr/include/eigen3/Eigen
googletest=/usr/src/googletest/googletest

for from in "$highway/highway.h" "$nanoflann" "$eigen/Core" "$googletest/src/gtest-all.cc"; do
  [[ -f $from ]] || { echo "carry.sh: there is no $from" >&2; exit 2; }
done
[[ -z $scene ]] || command -v xz >/dev/null || { echo "carry.sh: there is no xz" >&2; exit 2; }
[[ -z $scene || -x $pack ]] ||
  { echo "carry.sh: there is no $pack: cmake --build --preset cpu" >&2; exit 2; }
rm -rf "$to"
mkdir -p "$to/include/eigen3" "$to/googletest"
cp -r "$highway" "$to/include/hwy"
cp "$nanoflann" "$to/include/"
cp -r "$eigen" "$to/include/eigen3/"
cp -r "$googletest/src" "$googletest/include" "$to/googletest/"
if [[ -n $scene ]]; then
  "$pack" "$scene" "$to/scene" --every-test "$every_test"
  # What is left of an image after prediction has no alignment. A tar archive, since CMake, which
  # the other machine has, unpacks those.
  tar -C "$to" --use-compress-program='xz --lzma2=preset=9,pb=0,lc=4' -cf "$to/scene.tar.xz" scene
  rm "$to/scene"
fi
echo "$to: $(du -sh "$to" | cut -f 1)"
