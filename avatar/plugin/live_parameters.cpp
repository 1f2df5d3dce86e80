#include "avatar/plugin/live_parameters.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "avatar/live/face_blend.h"
#include "splat/base/text.h"

namespace cosplat::plugin {
namespace {

static_assert(COSPLAT_JOINT_COUNT == kFlameJoints);

void CheckNumber(float value, const char* field, size_t index) {
  const auto name = [&] { return std::string(field) + "[" + std::to_string(index) + "]"; };
  if (!std::isfinite(value))
    throw BadFrame(
        Verdict::kNotFinite, COSPLAT_ERROR_NOT_FINITE, name(), Format("{} is not finite", value));
  if (std::abs(value) > COSPLAT_LARGEST_PARAMETER)
    throw BadFrame(Verdict::kOutOfRange,
                   COSPLAT_ERROR_ARGUMENT,
                   name(),
                   std::to_string(value) + " is out of range: at most " +
                       std::to_string(COSPLAT_LARGEST_PARAMETER) + " in magnitude");
}

void CheckNumbers(const float* values, size_t count, const char* field) {
  if (!values && count > 0)
    throw BadFrame(Verdict::kWrongSize, COSPLAT_ERROR_ARGUMENT, field, "is NULL");
  for (size_t i = 0; i < count; ++i) CheckNumber(values[i], field, i);
}

}  // namespace

LiveParameters::LiveParameters(size_t expression_count, const FlameParams& rest) : rest_(rest) {
  rest_.expression.assign(expression_count, 0.0f);
  Reset();
}

void LiveParameters::Reset() {
  current_ = rest_;
  time_ns_ = kNoTime;
}

void LiveParameters::Keep(const FlameParams& params, int64_t time_ns) {
  CopyFace(params, current_);
  time_ns_ = time_ns;
}

void LiveParameters::CheckTime(int64_t time_ns) const {
  if (time_ns < time_ns_)
    throw BadFrame(
        Verdict::kLate,
        COSPLAT_ERROR_LATE,
        "time_ns",
        Format("{} is earlier than the time of the current parameters ({})", time_ns, time_ns_));
}

void LiveParameters::Set(const cosplat_parameters& given) {
  if (given.expression_count > kMaxExpressions)
    throw BadFrame(Verdict::kWrongSize,
                   COSPLAT_ERROR_ARGUMENT,
                   "parameters.expression_count",
                   Format("{} is more than {}", given.expression_count, kMaxExpressions));
  CheckNumbers(given.expression, given.expression_count, "parameters.expression");
  CheckNumbers(given.joints[0], 3 * kFlameJoints, "parameters.joints");
  CheckNumbers(given.translation, 3, "parameters.translation");
  CheckTime(given.time_ns);
  const size_t count = std::min<size_t>(given.expression_count, current_.expression.size());
  // memmove, because they may be our own (Get).
  if (count > 0) std::memmove(current_.expression.data(), given.expression, count * sizeof(float));
  std::fill(current_.expression.begin() + ptrdiff_t(count), current_.expression.end(), 0.0f);
  for (int j = 0; j < kFlameJoints; ++j)
    std::copy_n(given.joints[j], 3, current_.pose[size_t(j)].begin());
  std::copy_n(given.translation, 3, current_.translation.begin());
  time_ns_ = given.time_ns;
}

void LiveParameters::SetExpression(uint32_t expression, float value, int64_t time_ns) {
  if (expression >= current_.expression.size())
    throw CodedError(COSPLAT_ERROR_NOT_FOUND,
                     "expression",
                     Format("{} of {}", expression, current_.expression.size()));
  CheckNumber(value, "expression", expression);
  CheckTime(time_ns);
  current_.expression[expression] = value;
  time_ns_ = time_ns;
}

void LiveParameters::SetJoint(uint32_t joint, const float* axis_angle, int64_t time_ns) {
  if (joint >= kFlameJoints)
    throw CodedError(COSPLAT_ERROR_NOT_FOUND, "joint", Format("{} of {}", joint, kFlameJoints));
  CheckNumbers(axis_angle, 3, "axis_angle");
  CheckTime(time_ns);
  std::copy_n(axis_angle, 3, current_.pose[joint].begin());
  time_ns_ = time_ns;
}

void LiveParameters::SetTranslation(const float* translation, int64_t time_ns) {
  CheckNumbers(translation, 3, "translation");
  CheckTime(time_ns);
  std::copy_n(translation, 3, current_.translation.begin());
  time_ns_ = time_ns;
}

cosplat_parameters LiveParameters::Get() const {
  cosplat_parameters out{};
  out.expression_count = uint32_t(current_.expression.size());
  out.expression = current_.expression.data();
  out.time_ns = time_ns_;
  for (int j = 0; j < kFlameJoints; ++j)
    std::copy_n(current_.pose[size_t(j)].begin(), 3, out.joints[j]);
  std::copy_n(current_.translation.begin(), 3, out.translation);
  return out;
}

}  // namespace cosplat::plugin
