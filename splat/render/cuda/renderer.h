// The differentiable renderer on the device: what splat/render/rasterizer.h says, with every array
// there.
//
// One stream; nothing waits but Forward, once, for the number of instances, and it does not where
// it was told how many to expect (TileLists::Expect, of the tape's). Gaussians, gradients and
// pictures are pointers to the device's memory.
#pragma once

#include "splat/basis.h"
#include "splat/device/cuda/stream.h"
#include "splat/render/cuda/blend_backward.h"
#include "splat/render/cuda/tape.h"

namespace cosplat::cuda {

class Renderer {
 public:
  explicit Renderer(SumOrder order);

  // As Rasterizer::Forward (the exponential is the device's own, whatever settings.exp_degree
  // says). `keep`: for Backward or Contributions, which takes 128 bytes per instance.
  void Forward(const WorldGaussians& gaussians,
               Basis basis,
               const Camera& camera,
               const RenderSettings& settings,
               bool keep,
               DeviceImage& image,
               Tape& tape);
  // As Rasterizer::Backward. d_color: [3, height, width].
  void Backward(const WorldGaussians& gaussians,
                const DeviceImage& image,
                const float* d_color,
                Tape& tape,
                const WorldGradients& gradients);
  // As Rasterizer::Contributions.
  void Contributions(const DeviceImage& image, Tape& tape, DeviceBuffer<Contribution>& sums);

  const Stream& stream() const { return stream_; }
  // Between the stages of the last Forward and Backward, in their order: project, sort, blend; and
  // blend back, project back. For whoever has waited for the stream.
  enum Mark { kStart, kProjected, kSorted, kBlended, kBackStart, kBlendedBack, kBack, kMarks };
  float MillisecondsBetween(Mark from, Mark to) const {
    return marks_[to].MillisecondsSince(marks_[from]);
  }

 private:
  SumOrder order_;
  Stream stream_;
  Event marks_[kMarks];
  DeviceBuffer<float> basis_constants_;  // [bases, kMaxCoefficients]
};

}  // namespace cosplat::cuda
