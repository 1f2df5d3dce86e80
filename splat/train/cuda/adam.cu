#include <cmath>

#include "splat/device/cuda/launch.cuh"
#include "splat/math/adam.h"
#include "splat/train/cuda/adam.h"

namespace cosplat::cuda {
namespace {

constexpr uint32_t kNotNow = 0xffffffffu;

// Which groups this step works on, and how late each is.
struct FindBehind {
  DeviceView<const float> radii;  // empty: all groups
  uint32_t before, after;         // steps
  DeviceView<uint32_t> updated, behind;
  const uint32_t* overflowed;
  __device__ void operator()(size_t g) const {
    const bool now = !(overflowed && *overflowed != 0) && (radii.count == 0 || IsDrawn(g));
    behind[g] = now ? before - updated[g] : kNotNow;
    if (now) updated[g] = after;
  }
  __device__ bool IsDrawn(size_t g) const {
    const size_t end = math::Min((g + 1) * kGaussianGroup, radii.count);
    for (size_t i = g * kGaussianGroup; i < end; ++i)
      if (radii[i] > 0) return true;
    return false;
  }
};

// One attribute, and the constants of its update.
struct AttributeArrays {
  math::AdamStep step;
  size_t numbers = 0;
  int width = 1;
  const float* gradient = nullptr;
  float *value = nullptr, *m = nullptr, *v = nullptr;
  const float* rate_scale = nullptr;
};

// Number i of every attribute that has so many.
struct UpdateNumbers {
  AttributeArrays attributes[kAttributeCount];
  DeviceView<const uint32_t> behind;
  uint32_t* ignored;

  __device__ void operator()(size_t i) const {
#pragma unroll
    for (int a = 0; a < kAttributeCount; ++a)
      if (i < attributes[a].numbers) Update(attributes[a], i);
  }
  __device__ void Update(const AttributeArrays& a, size_t i) const {
    const uint32_t late = behind[i / a.width / kGaussianGroup];
    if (late == kNotNow) return;
    const float scale = a.rate_scale ? a.rate_scale[i] : 1.0f;
    float value = a.value[i], m = a.m[i], v = a.v[i];
    if (late > 0)
      math::AdamCatchUp(a.step, math::AdamTailOf(a.step, int(late)), value, m, v, scale);
    if (a.gradient) {
      const bool usable = math::IsUsableGradient(a.gradient[i]);
      if (!usable) atomicAdd(ignored, 1u);
      math::AdamUpdate(a.step, usable ? a.gradient[i] : 0.0f, value, m, v, scale);
    }
    a.value[i] = value;
    a.m[i] = m;
    a.v[i] = v;
  }
};

}  // namespace

void Adam::Start(const DeviceGaussians& values, cudaStream_t stream) {
  m.ResizeLike(values);
  v.ResizeLike(values);
  m.FillWithZeros(stream);
  v.FillWithZeros(stream);
  updated.Refill(AdamGroupCount(values.size()));
  updated.FillWithZeros(stream);
  ignored_.Refill(1);
  ignored_.FillWithZeros(stream);
  step = 0;
}

void Adam::Update(const AdamSettings& settings,
                  const DeviceGaussians* gradients,
                  const float* position_rate_scale,
                  DeviceGaussians& values,
                  cudaStream_t stream) {
  UpdateNumbers body{{}, std::as_const(behind_).view(), ignored_.data()};
  size_t most = 0;
  for (int a = 0; a < kAttributeCount; ++a) {
    AttributeArrays& array = body.attributes[a];
    array.step = StepOf(settings, a, step);
    array.numbers = values.values[a].size();
    array.width = std::max(values.width(a), 1);
    array.gradient = gradients ? gradients->values[a].data() : nullptr;
    array.value = values.values[a].data();
    array.m = m.values[a].data();
    array.v = v.values[a].data();
    array.rate_scale = a == kPosition ? position_rate_scale : nullptr;
    most = std::max(most, array.numbers);
  }
  ForEach(most, stream, body);
}

void Adam::Step(const AdamSettings& settings,
                const DeviceGaussians& gradients,
                DeviceView<const float> radii,
                const float* position_rate_scale,
                DeviceGaussians& values,
                cudaStream_t stream) {
  behind_.Refill(updated.size());
  ForEach(updated.size(),
          stream,
          FindBehind{radii, step, step + 1, updated.view(), behind_.view(), overflowed});
  ++step;
  Update(settings, &gradients, position_rate_scale, values, stream);
}

void Adam::CatchUpAll(const AdamSettings& settings,
                      const float* position_rate_scale,
                      DeviceGaussians& values,
                      cudaStream_t stream) {
  behind_.Refill(updated.size());
  ForEach(
      updated.size(), stream, FindBehind{{}, step, step, updated.view(), behind_.view(), nullptr});
  Update(settings, nullptr, position_rate_scale, values, stream);
}

}  // namespace cosplat::cuda
