// The derivative of the bust's pose, and an Adam step on it, in training
// (avatar/train/bust_track.h). Formulas: avatar/math/bust.h.
#pragma once

#include "avatar/model/avatar_model.h"
#include "avatar/surface/kernels/arrays.h"
#include "splat/device/buffer.h"
#include "splat/math/adam.h"

namespace cosplat {

// The bust's pose at one instant.
struct BustState {
  BustPose pose;
  math::AdamMoments<kBustOutputs> adam;  // of a turn that follows the pose's, and of the shift
};

// Sums dL/d(turn, shift) over a block of Gaussians, in order; those on the head count nothing.
struct SumBust {
  static constexpr size_t kBlock = 256;
  View<const int32_t> triangle;  // [N]
  int32_t first_face;            // of the bust
  math::Vec3<float> pivot;
  const BustPose* pose;
  PosedArrays<const float> posed, d_posed;
  View<double> sums;  // [blocks, 6]
  COSPLAT_HD void operator()(size_t b) const {
    const size_t last = math::Min((b + 1) * kBlock, triangle.count);
    math::Vec3<double> w{0, 0, 0}, shift{0, 0, 0};
    for (size_t i = b * kBlock; i < last; ++i) {
      if (triangle[i] < first_face) continue;
      math::Vec3<float> d_w{0, 0, 0}, d_shift{0, 0, 0};
      const float *p = posed.position + 3 * i, *d = d_posed.position + 3 * i;
      math::MoveWithBustVjp(*pose, pivot, {p[0], p[1], p[2]}, {d[0], d[1], d[2]}, d_w, d_shift);
      AddTurn(posed.rotation + 4 * i, d_posed.rotation + 4 * i, d_w);
      if (d_posed.frame) AddTurn(posed.frame + 4 * i, d_posed.frame + 4 * i, d_w);
      w += {d_w.x, d_w.y, d_w.z};
      shift += {d_shift.x, d_shift.y, d_shift.z};
    }
    const double sum[kBustOutputs] = {w.x, w.y, w.z, shift.x, shift.y, shift.z};
    for (size_t k = 0; k < kBustOutputs; ++k) sums[kBustOutputs * b + k] = sum[k];
  }
  COSPLAT_HD static void AddTurn(const float* q, const float* d, math::Vec3<float>& d_w) {
    math::TurnWithBustVjp(math::Quat<float>{q[0], q[1], q[2], q[3]}, {d[0], d[1], d[2], d[3]}, d_w);
  }
};

// Runs as a single call. A change is spread over the neighbouring instants, by a Gaussian window,
// since shoulders move slowly: each instant then gains from the images of the others.
struct AdvanceBust {
  View<const double> sums;
  float turn_rate, shift_rate;
  float decay;   // of both rates, per step of this instant
  float spread;  // instants: the window's standard deviation
  size_t instant;
  View<BustState> states;      // in the order of time
  const uint32_t* overflowed;  // or null
  COSPLAT_HD void operator()(size_t) const {
    if (overflowed && *overflowed != 0) return;
    BustState& state = states[instant];
    ++state.adam.step;
    const float share = std::pow(decay, float(state.adam.step));
    float change[kBustOutputs] = {};
    for (size_t k = 0; k < kBustOutputs; ++k) {
      const float rate = share * (k < 3 ? turn_rate : shift_rate);
      state.adam.Update(math::AdamStepAt(rate, state.adam.step), k, Sum(k), change[k]);
    }
    const math::Vec3<float> turn{change[0], change[1], change[2]};
    const math::Vec3<float> shift{change[3], change[4], change[5]};
    const int reach = int(3 * spread);
    for (int k = -reach; k <= reach; ++k) {
      const int64_t at = int64_t(instant) + k;
      if (at < 0 || at >= int64_t(states.count)) continue;
      const float weight = k == 0 ? 1.0f : std::exp(-0.5f * float(k * k) / (spread * spread));
      BustPose& pose = states[size_t(at)].pose;
      pose.turn = math::TurnedBy(turn * weight, pose.turn);
      pose.shift += shift * weight;
    }
  }
  COSPLAT_HD float Sum(size_t k) const {
    double sum = 0;
    for (size_t b = 0; kBustOutputs * b < sums.count; ++b) sum += sums[kBustOutputs * b + k];
    return float(sum);
  }
};

}  // namespace cosplat
