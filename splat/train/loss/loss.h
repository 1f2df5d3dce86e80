// Photometric loss between a rendered image and its target, with its gradient.
//   value = l1 * mean|x - y| + dssim * (1 - SSIM(x, y)) + mse * mean (x - y)^2
// 3DGS: 0.8, 0.2, 0 (Kerbl et al. 2023, eq. 7). SplattingAvatar: 1, 0, 10.
// Target images stay bytes; the loss composites them over the background as it reads them, by rows.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "splat/base/image.h"
#include "splat/device/buffer.h"

namespace cosplat {

struct LossWeights {
  float l1 = 0.8f;
  float dssim = 0.2f;
  float mse = 0.0f;
};

// A target image's bytes, in a stream's memory.
struct TargetView {
  int width = 0, height = 0, channels = 0;
  const uint8_t* bytes = nullptr;  // [height, width, channels]
  const uint8_t* ignored =
      nullptr;  // [height, width] not 0 where it is to be ignored; null: nowhere
};

// The loss of a training step, in the memory where the images are; each back end implements the
// SSIM window.
class StepLoss {
 public:
  virtual ~StepLoss() = default;
  // rendered: [3, height, width]. target: same size; grey, RGB or straight-alpha RGBA, composited
  // over the background. Writes d_rendered, shaped like rendered, and the loss to value().
  virtual void Evaluate(const LossWeights& weights,
                        View<const float> rendered,
                        const TargetView& target,
                        const std::array<float, 3>& background,
                        Buffer<float>& d_rendered,
                        Stream& stream) = 0;
  // [1] in the stream's memory.
  virtual const double* value() const = 0;
};

class PhotometricLoss : public StepLoss {
 public:
  void Evaluate(const LossWeights& weights,
                View<const float> rendered,
                const TargetView& target,
                const std::array<float, 3>& background,
                Buffer<float>& d_rendered,
                Stream& stream) override;
  const double* value() const override { return &value_; }
  // The same for a target image in host memory; returns the loss.
  double Evaluate(const LossWeights& weights,
                  View<const float> rendered,
                  const Image8& target,
                  const std::array<float, 3>& background,
                  Buffer<float>& d_rendered);

 private:
  std::vector<double> sums_;  // per job: pointwise terms, SSIM
  double value_ = 0;
};

// Mean SSIM over pixels and channels. Arguments as above.
double MeanSsim(View<const float> rendered,
                const Image8& target,
                const std::array<float, 3>& background);

// Composites the target over the background -> planar [3, height, width] in [0, 1].
void CompositeTarget(const Image8& image,
                     const std::array<float, 3>& background,
                     Buffer<float>& planar);

// 10 log10(1 / mean squared difference); 100 for equal images. a and b must have the same shape.
double Psnr(View<const float> a, View<const float> b);
double PsnrOf(double mean_squared_difference);

namespace cuda {

// The loss of a training step on a CUDA device: rendered image, bytes of the target image -> SSIM
// partials -> dL/d(rendered), in two passes with 16x16 pixels per block; sums are computed in a
// fixed order.
std::unique_ptr<StepLoss> MakeCudaLoss();

}  // namespace cuda

}  // namespace cosplat
