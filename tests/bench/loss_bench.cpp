// The photometric loss with its gradient: L1 and SSIM against an RGB image, for each
// instruction set, on one thread and on two.
//   cosplat_bench_loss      prints ns per pixel (three channels)
#include <hwy/targets.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "splat/base/rng.h"
#include "splat/train/loss/loss.h"

namespace cosplat {
namespace {

struct Images {
  Buffer<float> rendered;
  Image8 target;

  Images(int width, int height) : rendered(3 * size_t(width) * height), target(width, height, 3) {
    Rng rng{1};
    for (float& v : rendered) v = rng.Uniform();
    for (uint8_t& b : target.data) b = uint8_t(256 * rng.Uniform());
  }
};

// The fastest of many runs, so that a busy machine spoils little.
double NsPerPixel(const Images& images, int threads) {
  tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  PhotometricLoss loss;
  Buffer<float> d_rendered;
  constexpr double kSeconds = 0.5;
  double best = 1e30, total = 0;
  while (total < kSeconds) {
    const auto start = std::chrono::steady_clock::now();
    loss.Evaluate({}, images.rendered, images.target, {0, 0, 0}, d_rendered);
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    best = std::min(best, time.count());
    total += time.count();
  }
  return 1e9 * best / double(images.target.pixels());
}

void Run() {
  std::printf("ns per pixel       size  1 thread  2 threads   ratio\n");
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    // Fox at -r 8, an avatar's video, full HD.
    for (const auto& [width, height] : {std::pair{133, 237}, {512, 512}, {1920, 1080}}) {
      const Images images(width, height);
      const double one = NsPerPixel(images, 1), two = NsPerPixel(images, 2);
      std::printf("%-10s    %4dx%-4d  %8.2f  %9.2f  %6.2f\n",
                  hwy::TargetName(target),
                  width,
                  height,
                  one,
                  two,
                  one / two);
    }
  }
  hwy::SetSupportedTargetsForTest(0);
}

}  // namespace
}  // namespace cosplat

int main() { cosplat::Run(); }
