// What lies between a rendered image and the photograph that it is compared with: the photograph's
// exposure (math/exposure.h), and pixels to ignore.
#pragma once

#include "splat/device/buffer.h"
#include "splat/device/sum.h"
#include "splat/math/adam.h"
#include "splat/math/exposure.h"
#include "splat/math/photometric.h"
#include "splat/train/loss/loss.h"

namespace cosplat {

// One call per pixel: the rendered image as the photograph would show it. Ignored pixels get the
// target's values, so that no loss, windowed or not, sees a difference there.
struct PhotographForward {
  View<const float> rendered;  // [3, pixels]
  const float* exposure;       // [12]; null: the identity
  TargetView target;
  float background[3];
  View<float> shown;  // [3, pixels]
  COSPLAT_HD void operator()(size_t i) const {
    const size_t plane = rendered.count / 3;
    math::Vec3<float> color{rendered[i], rendered[plane + i], rendered[2 * plane + i]};
    if (target.ignored && target.ignored[i]) {
      color = {Target(i, 0), Target(i, 1), Target(i, 2)};
    } else if (exposure) {
      color = math::Exposed(exposure, color);
    }
    shown[i] = color.x;
    shown[plane + i] = color.y;
    shown[2 * plane + i] = color.z;
  }
  COSPLAT_HD float Target(size_t i, int channel) const {
    const uint8_t* p = target.bytes + i * size_t(target.channels);
    const uint8_t value = p[target.channels == 1 ? 0 : channel];
    return target.channels == 4 ? math::Over(value, p[3], background[channel])
                                : math::FromByte(value);
  }
};

// Gradient of the loss with respect to an exposure, or a part of it.
struct ExposureSum {
  double d[math::kExposureNumbers] = {};
  COSPLAT_HD ExposureSum& operator+=(const ExposureSum& other) {
    for (int k = 0; k < math::kExposureNumbers; ++k) d[k] += other.d[k];
    return *this;
  }
};

// Its derivative, one call per block of pixels: `d` is that of what is shown and becomes that of
// the rendered image. sums: of the block.
struct PhotographBackward {
  static constexpr size_t kBlock = 256;
  View<const float> rendered;  // [3, pixels]
  const float* exposure;       // [12]; null: the identity
  const uint8_t* ignored;      // [pixels] or null
  View<float> d;               // [3, pixels]
  View<ExposureSum> sums;      // [blocks]; empty if `exposure` is null
  COSPLAT_HD void operator()(size_t b) const {
    const size_t plane = rendered.count / 3;
    const size_t last = (b + 1) * kBlock < plane ? (b + 1) * kBlock : plane;
    float d_exposure[math::kExposureNumbers] = {};
    for (size_t i = b * kBlock; i < last; ++i) {
      math::Vec3<float> d_color{0, 0, 0};
      if (!ignored || !ignored[i]) d_color = {d[i], d[plane + i], d[2 * plane + i]};
      if (exposure)
        d_color = math::ExposedVjp(exposure,
                                   {rendered[i], rendered[plane + i], rendered[2 * plane + i]},
                                   d_color,
                                   d_exposure);
      d[i] = d_color.x;
      d[plane + i] = d_color.y;
      d[2 * plane + i] = d_color.z;
    }
    if (!exposure) return;
    for (int k = 0; k < math::kExposureNumbers; ++k) sums[b].d[k] = double(d_exposure[k]);
  }
};

// Runs as a single call.
struct AddUpExposure {
  View<const ExposureSum> sums;  // of SumInTree
  View<float> gradient;          // [12]
  COSPLAT_HD void operator()(size_t) const {
    const ExposureSum sum = SumOfBlock(sums, 0);
    for (int k = 0; k < math::kExposureNumbers; ++k) gradient[size_t(k)] = float(sum.d[k]);
  }
};

// Numbers of all frames' exposures, [frames, 12].
struct ExposureArrays {
  View<float> value, m, v;
  View<uint32_t> updates;  // of each number so far
};

// One call per number of a frame's exposure: a step of Adam. Changes nothing if *overflowed is not
// 0, since the step will be repeated.
struct StepExposure {
  ExposureArrays all;
  size_t frame;
  float rate;
  View<const float> gradient;  // [12]
  const uint32_t* overflowed;
  View<float> moved;  // [12]
  COSPLAT_HD void operator()(size_t k) const {
    const size_t i = frame * math::kExposureNumbers + k;
    const float before = all.value[i];
    if (*overflowed == 0 && math::IsUsableGradient(gradient[k])) {
      const math::AdamStep step = math::AdamStepAt(rate, ++all.updates[i]);
      math::AdamUpdate(step, gradient[k], all.value[i], all.m[i], all.v[i]);
    }
    moved[k] = all.value[i] - before;
  }
};

// One call per number of all frames: shares out what one frame was moved by, so that the mean over
// the frames stays the identity. Scene and exposures are determined up to an affine function only.
struct CenterExposures {
  View<const float> moved;  // [12]
  View<float> value;        // [frames, 12]
  COSPLAT_HD void operator()(size_t i) const {
    const float frames = float(value.count / math::kExposureNumbers);
    value[i] -= moved[i % math::kExposureNumbers] / frames;
  }
};

}  // namespace cosplat
