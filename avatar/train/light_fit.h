// The light of the world (avatar/math/light.h) in training: what all frames have in common of how a
// surface's colour changes as it turns.
//
// light(), mean() -> Bind -> ... -> BindBackward -> gradient() -> Advance (Adam);
// Settle -> AvatarModel.
#pragma once

#include <vector>

#include "avatar/surface/binding.h"

namespace cosplat {

class LightFit {
 public:
  LightFit() = default;
  // mean: [V, kLightTerms], of the terms at the vertices over the training frames. rate: Adam's
  // learning rate at the first step, which falls to zero over the run. Starts in host memory.
  LightFit(std::vector<float> mean, float rate, int iterations);

  bool empty() const { return mean_on_host_.empty(); }
  void WorkIn(Stream& stream);
  View<const float> light() const { return {value(), empty() ? 0 : kLightNumbers}; }
  View<const float> mean() const { return mean_.view(); }
  // Where BindBackward puts the coefficients' derivative; null without a light.
  Buffer<float>* gradient() { return empty() ? nullptr : &gradient_; }
  // One Adam step by gradient(). If *overflowed is not 0, nothing changes.
  void Advance(const uint32_t* overflowed);

  // [1], or none without a light; in host memory.
  std::vector<LightState> States() const;
  void SetStates(const std::vector<LightState>& states);
  // Sets the avatar's light, and its colours so that they need no mean.
  void Settle(AvatarModel& avatar) const;
  size_t allocated_bytes() const { return AllocatedBytes(state_, mean_, gradient_); }
  static constexpr size_t kBytesPerGaussian = 6 * sizeof(float);  // lit colours, derivatives

 private:
  const float* value() const { return empty() ? nullptr : state_.data()->value; }

  Stream* stream_ = &HostStream();
  std::vector<float> mean_on_host_;
  float rate_ = 0;
  int iterations_ = 0;
  Buffer<LightState> state_;  // [1]
  Buffer<float> mean_, gradient_;
};

// The mean of the light's terms at each vertex, [V, kLightTerms], over the poses that were added.
class LightMean {
 public:
  explicit LightMean(size_t vertices) : sum_(vertices * size_t(math::kLightTerms), 0.0) {}
  void Add(const Surface& posed);
  std::vector<float> Mean() const;

 private:
  std::vector<double> sum_;
  size_t count_ = 0;
};

}  // namespace cosplat
