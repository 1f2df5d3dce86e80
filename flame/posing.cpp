#include "flame/posing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "splat/base/error.h"

namespace cosplat {
namespace {

double Largest(const float* x, size_t count) {
  float largest = 0;
  for (size_t i = 0; i < count; ++i) largest = std::max(largest, std::abs(x[i]));
  return largest;
}

std::vector<double> LargestOfEach(const float* directions, size_t count, size_t rows) {
  std::vector<double> largest;
  for (size_t k = 0; k < count; ++k) largest.push_back(Largest(directions + k * rows, rows));
  return largest;
}

}  // namespace

PosingReach::PosingReach(const PosingArrays<float>& arrays)
    : shaped_(Largest(arrays.shaped, 3 * arrays.vertex_count)),
      weights_(0),
      expression_(LargestOfEach(
          arrays.expression_directions, arrays.expression_count, 3 * arrays.vertex_count)),
      pose_(LargestOfEach(arrays.pose_directions, kFlamePoseFeatures, 3 * arrays.vertex_count)) {
  for (size_t v = 0; v < arrays.vertex_count; ++v) {
    double sum = 0;
    for (size_t j = 0; j < kFlameJoints; ++j)
      sum += std::abs(double(arrays.weights[kFlameJoints * v + j]));
    weights_ = std::max(weights_, sum);
  }
}

void PosingReach::Check(const FlameRig<float>& rig) const {
  double unskinned = shaped_, rotation = 0, translation = 0;
  for (size_t t = 0; t < rig.terms.size(); ++t) {
    const std::vector<double>& largest = t < rig.expression_terms ? expression_ : pose_;
    unskinned += std::abs(double(rig.terms[t].coefficient)) * largest[rig.terms[t].direction];
  }
  // Unlike std::max, keeps a NaN, whatever follows it.
  const auto enlarge = [](double& largest, float x) {
    if (!std::isnan(largest) && !(std::abs(x) <= largest)) largest = std::abs(x);
  };
  for (size_t j = 0; j < kFlameJoints; ++j) {
    for (const float x : rig.transforms.rotation[j].m) enlarge(rotation, x);
    for (int i = 0; i < 3; ++i) enlarge(translation, rig.transforms.translation[j][i]);
  }
  double reach = weights_ * (3 * rotation * unskinned + translation);
  for (const float x : rig.translation) reach += std::abs(x);
  if (reach <= std::numeric_limits<float>::max()) return;
  std::ostringstream problem;
  problem << "could be " << reach << " metres from the origin, which overflows float";
  throw Error("surface", "vertices", problem.str());
}

}  // namespace cosplat
