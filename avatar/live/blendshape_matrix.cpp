#include "avatar/live/blendshape_matrix.h"

#include <algorithm>
#include <cmath>

#include "avatar/live/guard.h"
#include "splat/base/error.h"
#include "splat/base/npz.h"

namespace cosplat {
namespace {

constexpr size_t kFirstJoint = 2;  // the jaw in FlameParams::pose; the eyes follow

// columns: -1 for any.
std::vector<float> ReadRows(const Npz& npz, const std::string& name, long columns) {
  const NpyArray& array = npz.Get(name, {long(kArkitBlendshapes), columns});
  const size_t width = array.shape[1];
  if (width == 0 || width > kMaxExpressions)
    throw Error(npz.path(), name, "has " + std::to_string(width) + " columns");
  for (size_t column = 0; column < width; ++column) {
    double most = 0;
    for (size_t row = 0; row < kArkitBlendshapes; ++row)
      most += std::abs(array.values[row * width + column]);
    if (!(most <= kMaxParameter))
      throw Error(npz.path(),
                  name,
                  "absolute values of column " + std::to_string(column) + " add up to " +
                      std::to_string(most) + ", at most " + std::to_string(int(kMaxParameter)) +
                      " is allowed");
  }
  return {array.values.begin(), array.values.end()};
}

// out[c] = sum over r of weights[r] * rows[r, c].
void Multiply(const BlendshapeWeights& weights,
              const std::vector<float>& rows,
              size_t width,
              float* out) {
  std::fill_n(out, width, 0.0f);
  for (size_t row = 0; row < weights.size(); ++row)
    for (size_t c = 0; c < width; ++c) out[c] += weights[row] * rows[row * width + c];
}

}  // namespace

BlendshapeMatrix BlendshapeMatrix::Read(const std::string& path) {
  const Npz npz = Npz::Read(path);
  BlendshapeMatrix matrix;
  matrix.expression_ = ReadRows(npz, "expression", -1);
  matrix.expression_count_ = matrix.expression_.size() / kArkitBlendshapes;
  const char* const names[] = {"jaw", "left_eye", "right_eye"};
  for (size_t j = 0; j < matrix.joints_.size(); ++j)
    if (npz.Has(names[j])) matrix.joints_[j] = ReadRows(npz, names[j], 3);
  return matrix;
}

void BlendshapeMatrix::Apply(const BlendshapeWeights& weights, FlameParams& params) const {
  params.expression.resize(expression_count_);
  Multiply(weights, expression_, expression_count_, params.expression.data());
  for (size_t j = 0; j < joints_.size(); ++j)
    if (!joints_[j].empty()) Multiply(weights, joints_[j], 3, params.pose[kFirstJoint + j].data());
}

}  // namespace cosplat
