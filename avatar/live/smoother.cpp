#include "avatar/live/smoother.h"

#include <cmath>

#include "avatar/live/face_blend.h"

namespace cosplat {
namespace {

// The unit of each channel's speed: a typical motion.
constexpr float kCoefficient = 1, kTurn = 0.1f, kShift = 0.02f;  // -, rad, m

// Low-pass filters the speed v, whose new sample is step / per; returns the filtered magnitude.
float StepSpeed(float gain, const std::array<float, 3>& step, float per, std::array<float, 3>& v) {
  for (size_t k = 0; k < 3; ++k) v[k] += gain * (step[k] / per - v[k]);
  return std::hypot(v[0], v[1], v[2]);
}

}  // namespace

FaceSmoother::FaceSmoother(size_t expression_count) : expression_speed_(expression_count) {
  sample_.expression.resize(expression_count);
  value_.expression.resize(expression_count);
}

void FaceSmoother::Start(const FlameParams& face) {
  started_ = true;
  CopyFace(face, sample_);
  CopyFace(face, value_);
  expression_speed_.assign(expression_speed_.size(), 0.0f);
  turn_speed_ = {};
  translation_speed_ = {};
}

void FaceSmoother::StepExpression(const math::OneEuro& filter, float dt, const FlameParams& face) {
  const float speed_gain = math::LowPassGain(filter.speed_cutoff, dt);
  for (size_t i = 0; i < expression_speed_.size(); ++i) {
    float& speed = expression_speed_[i];
    const float step = face.expression[i] - sample_.expression[i];
    speed += speed_gain * (step / (kCoefficient * dt) - speed);
    value_.expression[i] +=
        math::OneEuroGain(filter, speed, dt) * (face.expression[i] - value_.expression[i]);
  }
}

void FaceSmoother::StepJoint(const math::OneEuro& filter,
                             float dt,
                             const FlameParams& face,
                             size_t joint) {
  const auto from = math::QuatOfAxisAngle(sample_.pose[joint]);
  const auto to = math::QuatOfAxisAngle(face.pose[joint]);
  const auto step = math::AxisAngleOf(math::ShorterWay(math::Multiply(to, math::Conjugate(from))));
  const float speed_gain = math::LowPassGain(filter.speed_cutoff, dt);
  const float speed = StepSpeed(speed_gain, step, kTurn * dt, turn_speed_[joint]);
  value_.pose[joint] = math::AxisAngleOf(math::ShorterWay(math::Between(
      math::QuatOfAxisAngle(value_.pose[joint]), to, math::OneEuroGain(filter, speed, dt))));
}

void FaceSmoother::StepTranslation(const math::OneEuro& filter, float dt, const FlameParams& face) {
  Vector step;
  for (size_t k = 0; k < 3; ++k) step[k] = face.translation[k] - sample_.translation[k];
  const float speed_gain = math::LowPassGain(filter.speed_cutoff, dt);
  const float speed = StepSpeed(speed_gain, step, kShift * dt, translation_speed_);
  const float gain = math::OneEuroGain(filter, speed, dt);
  for (size_t k = 0; k < 3; ++k)
    value_.translation[k] += gain * (face.translation[k] - value_.translation[k]);
}

void FaceSmoother::Smooth(const math::OneEuro& filter, float dt, FlameParams& face) {
  if (!started_) return Start(face);
  if (dt > 0) {
    StepExpression(filter, dt, face);
    for (size_t j = 0; j < kFlameJoints; ++j) StepJoint(filter, dt, face, j);
    StepTranslation(filter, dt, face);
    CopyFace(face, sample_);
  }
  CopyFace(value_, face);
}

}  // namespace cosplat
