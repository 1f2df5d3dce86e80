#!/usr/bin/env bash
# Builds Ceres for the web build from the source of this system's distribution, into DIR/source and
# DIR/build; a few minutes, once. Of its parts only those that need no other library.
#
#   cmake/web/ceres.sh DIR
set -euo pipefail
mkdir -p "$1"
dir=$(readlink -f "$1")
[[ -f $dir/build/lib/libceres.a ]] && exit 0

# The distribution's own addresses, but of sources. apt checks what it loads as it checks packages;
# nothing of the system is changed.
mkdir -p "$dir/apt/lists/partial" "$dir/apt/archives/partial"
{
  cat /etc/apt/sources.list /etc/apt/sources.list.d/*.list 2>/dev/null | sed -n 's/^deb /deb-src /p'
} >"$dir/apt/sources.list" || true
sources=$dir/apt/sources.list
for file in /etc/apt/sources.list.d/*.sources; do
  if [[ -f $file ]]; then
    sed 's/^Types:.*/Types: deb-src/' "$file" >"$dir/apt/$(basename "$file")"
    sources=$dir/apt/$(basename "$file")
  fi
done
apt=(-q -o "Dir::Etc::sourcelist=$sources" -o Dir::Etc::sourceparts=- -o "Dir::State::lists=$dir/apt/lists"
  -o "Dir::Cache=$dir/apt" -o APT::Sandbox::User=)
apt-get "${apt[@]}" update
(cd "$dir/apt" && apt-get "${apt[@]}" source --tar-only --download-only ceres-solver)
rm -rf "$dir/source" "$dir/build"
mkdir "$dir/source"
tar -C "$dir/source" --strip-components=1 -xf "$dir"/apt/ceres-solver_*.orig.tar.*

# MAX_LOG_LEVEL -2: it says nothing but errors.
cmake -S "$dir/source" -B "$dir/build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_TOOLCHAIN_FILE=/usr/share/emscripten/cmake/Modules/Platform/Emscripten.cmake \
  -DCMAKE_FIND_ROOT_PATH_MODE_PACKAGE=BOTH -DEigen3_DIR=/usr/share/eigen3/cmake \
  -DCMAKE_CXX_FLAGS="-msimd128 -pthread -fwasm-exceptions -w -DMAX_LOG_LEVEL=-2" \
  ${CMAKE_CXX_COMPILER_LAUNCHER:+-DCMAKE_CXX_COMPILER_LAUNCHER=$CMAKE_CXX_COMPILER_LAUNCHER} \
  -DMINIGLOG=ON -DGFLAGS=OFF -DSUITESPARSE=OFF -DLAPACK=OFF -DEIGENSPARSE=OFF -DEIGENMETIS=OFF \
  -DUSE_CUDA=OFF -DCUDA=OFF -DCXSPARSE=OFF -DSCHUR_SPECIALIZATIONS=OFF -DBUILD_TESTING=OFF \
  -DBUILD_EXAMPLES=OFF -DBUILD_BENCHMARKS=OFF -DPROVIDE_UNINSTALL_TARGET=OFF
cmake --build "$dir/build"
