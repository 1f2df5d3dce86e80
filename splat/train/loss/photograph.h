// Training on real photographs: the exposure and white balance of each, which the scene is not to
// learn, and pixels that are to be ignored.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/device/buffer.h"
#include "splat/math/exposure.h"
#include "splat/train/loss/kernels/photograph.h"
#include "splat/train/loss/loss.h"

namespace cosplat {

using Exposure = std::array<float, math::kExposureNumbers>;  // [3, 4] as in math/exposure.h
constexpr Exposure kIdentityExposure{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

// The exposures of all training frames, and Adam's moments; part of a training's state. Their mean
// over the frames is the identity: the scene has the colours of a mean photograph.
struct ExposureState {
  Buffer<float> value, m, v;  // [frames, 12]
  Buffer<uint32_t> updates;   // [frames, 12] steps of Adam so far

  ExposureState() = default;
  // Identities, on the host.
  explicit ExposureState(size_t frames);
  // As in splat/device/arrays.h.
  template <class Visit, class... Of>
  static void ForEachArray(const Visit& visit, Of&... of) {
    visit("value", size_t(1), of.value...);
    visit("m", size_t(1), of.m...);
    visit("v", size_t(1), of.v...);
    visit("updates", size_t(1), of.updates...);
  }

  // The state of these frames, in host memory as what follows.
  ExposureState Of(const std::vector<uint32_t>& frames) const;
  // Sets each frame to the mean of what the trainings that had it have found, by frames[part]; a
  // part may have found nothing. A frame of no training stays.
  void SetToMeans(const std::vector<std::vector<uint32_t>>& frames,
                  const std::vector<ExposureState>& found);
};

// Between a rendered image and its target, in a stream's memory.
class PhotographModel {
 public:
  // The rendered image ([3, height, width]) as the photograph would show it. exposure: [12] in the
  // stream's memory, or null for the identity. Valid until the next call.
  const Buffer<float>& Forward(View<const float> rendered,
                               const float* exposure,
                               const TargetView& target,
                               const std::array<float, 3>& background,
                               Stream& stream);
  // Turns the gradient of what Forward returned, of the same arguments, into that of the rendered
  // image, in place; and finds gradient() if there is an exposure.
  void Backward(View<const float> rendered,
                const float* exposure,
                const TargetView& target,
                Buffer<float>& d_shown,
                Stream& stream);
  // [12] of the loss with respect to the exposure.
  const Buffer<float>& gradient() const { return gradient_; }
  // One step of Adam on a frame's exposure, unless *overflowed is not 0. gradient: [12].
  void Update(size_t frame,
              float rate,
              View<const float> gradient,
              const uint32_t* overflowed,
              ExposureState& exposures,
              Stream& stream);
  size_t allocated_bytes() const { return AllocatedBytes(shown_, sums_, tree_, gradient_, moved_); }

 private:
  Buffer<float> shown_;
  Buffer<ExposureSum> sums_, tree_;
  Buffer<float> gradient_, moved_;  // [12]
};

// The exposure that brings a rendered image closest to its photograph in the squared error, over
// the pixels with `use`. Both [3, pixels]. Where these do not determine it, the nearest to the
// identity.
Exposure FitExposure(View<const float> rendered, View<const float> target, View<const uint8_t> use);

// In place. image: [3, pixels].
void ApplyExposure(const Exposure& exposure, View<float> image);

}  // namespace cosplat
