// What running the formulas of splat/math/blend.h on SIMD packs gives over running them on floats.
//   cosplat_bench_blend      prints ns per pixel and splat, and the ratio to scalar code
#include <cstdio>
#include <string>

#include "apps/study/bench/dense_tile.h"
#include "apps/study/bench/machine.h"

int main() {
  using namespace cosplat;
  constexpr int kBatches = 15;
  const BlendTimes scalar = MeasureScalarBlend(kBatches);
  const auto print = [&](const std::string& name, const BlendTimes& times) {
    std::printf("%-22s %11.3f %7.1f %9.3f %7.1f  %.4f\n",
                name.c_str(),
                times.forward_ns,
                scalar.forward_ns / times.forward_ns,
                times.backward_ns,
                scalar.backward_ns / times.backward_ns,
                times.checksum);
  };
  std::printf("ns per pixel and splat     forward   ratio  backward   ratio  checksum\n");
  print("float", scalar);
  for (const SimdTarget& target : SimdTargets()) {
    const OnlySimdTarget only(target);
    print("packs, " + target.name, MeasureBlend(kBatches));
  }
}
