#include "avatar/train/light_fit.h"

#include <algorithm>
#include <utility>

#include "splat/basis_constants.h"
#include "splat/device/for_each.h"

namespace cosplat {

LightFit::LightFit(std::vector<float> mean, float rate, int iterations)
    : mean_on_host_(std::move(mean)), rate_(rate), iterations_(iterations) {
  SetStates({LightState{}});
}

std::vector<LightState> LightFit::States() const { return state_.Downloaded(*stream_); }

void LightFit::SetStates(const std::vector<LightState>& states) {
  state_.Upload(states, *stream_);
  mean_.Upload(mean_on_host_, *stream_);
  stream_->Wait();
}

void LightFit::WorkIn(Stream& stream) {
  const std::vector<LightState> states = States();
  stream_ = &stream;
  SetStates(states);
}

void LightFit::Advance(const uint32_t* overflowed) {
  ForEach(1,
          *stream_,
          AdvanceLight{std::as_const(gradient_).view(),
                       rate_,
                       uint32_t(iterations_),
                       state_.data(),
                       overflowed});
}

void LightFit::Settle(AvatarModel& avatar) const {
  if (empty()) return;
  Light& light = avatar.light.emplace();
  std::copy_n(States()[0].value, kLightNumbers, light.begin());
  Gaussians& g = avatar.gaussians;
  const float black = -0.5f / BasisConstants(g.basis)[0];
  ParallelFor(g.size(), [&](size_t i) {
    const float* offset = g.at(kPosition, i);
    const float u = avatar.embedding.barycentric[i][0] + offset[0];
    const float v = avatar.embedding.barycentric[i][1] + offset[1];
    const float weights[3] = {u, v, 1 - u - v};
    math::LightTerms<float> mean{};
    for (size_t c = 0; c < 3; ++c) {
      const auto vertex = size_t(avatar.mesh.faces[size_t(avatar.embedding.triangle[i])][c]);
      for (size_t k = 0; k < size_t(math::kLightTerms); ++k)
        mean.y[k] += weights[c] * mean_on_host_[size_t(math::kLightTerms) * vertex + k];
    }
    const math::Vec3<float> log_light = -math::LogLight(mean, light.data());
    float* dc = g.at(kColorDc, i);
    const math::Vec3<float> own = math::Lit({dc[0], dc[1], dc[2]}, log_light, black);
    dc[0] = own.x;
    dc[1] = own.y;
    dc[2] = own.z;
    // A correction's colour is added before the light multiplies it.
    const float gains[3] = {std::exp(log_light.x), std::exp(log_light.y), std::exp(log_light.z)};
    for (int k = 0; k < g.corrections; ++k)
      for (int c = 0; c < 3; ++c)
        g.at(kCorrection, i)[k * kCorrectionNumbers + kCorrectionNumbers - 3 + c] *= gains[c];
  });
}

void LightMean::Add(const Surface& posed) {
  const float* vertices = posed.Arrays().vertices;
  constexpr auto kTerms = size_t(math::kLightTerms);
  ParallelFor(sum_.size() / kTerms, [&](size_t v) {
    const math::SurfaceVertex<float> at =
        math::SurfaceVertexOf(vertices + kSurfaceVertexFloats * v);
    const auto terms = math::LightTermsOf(at.normal);
    for (size_t k = 0; k < kTerms; ++k) sum_[kTerms * v + k] += double(terms.y[k]);
  });
  ++count_;
}

std::vector<float> LightMean::Mean() const {
  std::vector<float> mean;
  for (const double sum : sum_) mean.push_back(float(sum / double(count_)));
  return mean;
}

}  // namespace cosplat
