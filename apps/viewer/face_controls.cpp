#include "apps/viewer/face_controls.h"

#include <algorithm>

#include "avatar/live/soft_range.h"
#include "avatar/math/turn.h"

namespace cosplat::viewer {
namespace {

constexpr float kBeyond = 0.25f;        // share of its training range by which a slider extends it
constexpr float kMinBeyond = 0.5f;      // at least this much
constexpr int kRandomExpressions = 12;  // at most this many at once; more would cancel out
constexpr float kRandomShare = 0.3f;    // share of the joints' ranges

// Axes of FLAME's joints: x to the subject's left, y up, z out of the face. Radians, with
// anatomically plausible ranges.
struct JointSlider {
  const char* name;
  size_t joint, axis;
  float min, max;
};
constexpr JointSlider kJointSliders[] = {{"Head nod", 0, 0, -0.7f, 0.7f},
                                         {"Head turn", 0, 1, -1.2f, 1.2f},
                                         {"Head tilt", 0, 2, -0.6f, 0.6f},
                                         {"Neck nod", 1, 0, -0.6f, 0.6f},
                                         {"Neck turn", 1, 1, -0.9f, 0.9f},
                                         {"Neck tilt", 1, 2, -0.5f, 0.5f},
                                         {"Jaw open", 2, 0, -0.05f, 0.6f},
                                         {"Jaw side", 2, 1, -0.15f, 0.15f},
                                         {"Left eye down", 3, 0, -0.5f, 0.5f},
                                         {"Left eye turn", 3, 1, -0.7f, 0.7f},
                                         {"Right eye down", 4, 0, -0.5f, 0.5f},
                                         {"Right eye turn", 4, 1, -0.7f, 0.7f}};

float Within(const Slider& slider, float value) {
  return std::clamp(value, slider.min, slider.max);
}

}  // namespace

FaceControls::FaceControls(int expression_count,
                           const FlameParams& rest,
                           const std::optional<TrainedRange>& trained)
    : rest_(rest) {
  rest_.expression.clear();
  for (size_t i = 0; i < size_t(expression_count); ++i) {
    std::array<float, 2> usual{-SoftRange::kUsualExpression, SoftRange::kUsualExpression};
    if (trained && i < trained->expression_least.size())
      usual = {trained->expression_least[i], trained->expression_most[i]};
    const float beyond = trained ? std::max(kMinBeyond, kBeyond * (usual[1] - usual[0])) : 0;
    usual_.push_back(usual);
    expressions_.push_back({"Expression " + std::to_string(i + 1),
                            std::min(usual[0], 0.0f) - beyond,
                            std::max(usual[1], 0.0f) + beyond,
                            0});
  }
  for (const JointSlider& joint : kJointSliders)
    joints_.push_back({joint.name, joint.min, joint.max, 0});
}

void FaceControls::SetNeutral() {
  for (auto* sliders : {&expressions_, &joints_})
    for (Slider& slider : *sliders) slider.value = 0;
}

void FaceControls::SetRandom(Rng& rng) {
  SetNeutral();
  for (int i = 0; i < kRandomExpressions && !expressions_.empty(); ++i) {
    const size_t which = rng.Below(expressions_.size());
    const auto [min, max] = usual_[which];
    // The mean of two values favours the middle over the ends.
    const float place = (rng.Uniform() + rng.Uniform()) / 2;
    expressions_[which].value = min + place * (max - min);
  }
  for (Slider& joint : joints_)
    joint.value = kRandomShare * (joint.min + rng.Uniform() * (joint.max - joint.min));
}

void FaceControls::SetFace(const FlameParams& face) {
  for (size_t i = 0; i < expressions_.size(); ++i)
    expressions_[i].value =
        i < face.expression.size() ? Within(expressions_[i], face.expression[i]) : 0;
  FlameParams turned = face;
  turned.pose[0] = math::AxisAngleOf(math::ShorterWay(math::Multiply(
      math::Conjugate(math::QuatOfAxisAngle(rest_.pose[0])), math::QuatOfAxisAngle(face.pose[0]))));
  for (size_t i = 0; i < joints_.size(); ++i)
    joints_[i].value =
        Within(joints_[i], turned.pose[kJointSliders[i].joint][kJointSliders[i].axis]);
}

FlameParams FaceControls::Face() const {
  FlameParams face = rest_;
  face.pose[0] = {};
  for (const Slider& slider : expressions_) face.expression.push_back(slider.value);
  for (size_t i = 0; i < joints_.size(); ++i)
    face.pose[kJointSliders[i].joint][kJointSliders[i].axis] = joints_[i].value;
  const bool turned = face.pose[0] != math::AxisAngle{};
  face.pose[0] =
      !turned ? rest_.pose[0]
              : math::AxisAngleOf(math::ShorterWay(math::Multiply(
                    math::QuatOfAxisAngle(rest_.pose[0]), math::QuatOfAxisAngle(face.pose[0]))));
  return face;
}

}  // namespace cosplat::viewer
