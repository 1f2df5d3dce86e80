#include "flame/pose.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>

#include "flame/check_parameters.h"
#include "flame/directions.h"
#include "flame/math/kinematics.h"
#include "flame/math/rodrigues.h"
#include "flame/math/skinning.h"
#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

using flame_math::JointTransforms;
using internal::CheckCoefficients;
using internal::CheckParameters;
using internal::Directions;
using internal::ForStrips;
using internal::kStrip;
using internal::MatrixX;
using internal::VectorX;
using math::Mat3;
using math::Vec3;

// Stores the input `x` of a sum; returns whether it has changed. Compares bits, since results must
// be bit-identical to those without a cache.
template <class T>
bool Remember(const T* x, size_t count, std::vector<T>& last) {
  if (last.size() == count && std::equal(x, x + count, last.begin(), [](const T& a, const T& b) {
        return std::memcmp(&a, &b, sizeof(T)) == 0;
      }))
    return false;
  last.assign(x, x + count);
  return true;
}

}  // namespace

template <class T>
struct FlamePoser<T>::Impl {
  using Transforms = JointTransforms<T, kFlameJoints>;
  using Rotations = std::array<Mat3<T>, kFlameJoints>;
  using Joints = std::array<Vec3<T>, kFlameJoints>;

  // Everything between the parameters and skinning.
  struct Rig {
    size_t expression_count;                          // minimum of the model's and the frame's
    std::array<T, kFlamePoseFeatures> pose_features;  // vec(R_1..4 - I)
    Rotations local;
    Joints joints;
    Transforms transforms;
  };

  Impl(const FlameModel& m, const std::vector<float>& shape, const std::vector<float>& offset);
  Rig RigOf(const Parameters& parameters) const;
  // Updates the cache strip by strip, calling use(first vertex, number) after each strip.
  template <class Use>
  void Blend(const Parameters& parameters, const Rig& rig, Cache& cache, const Use& use) const;
  Transforms SkinVjp(const Rig& rig, const Cache& cache, VectorX<T>& d_vertices) const;

  // The vertex before skinning.
  static Vec3<T> Unskinned(const Cache& cache, Eigen::Index v) {
    Vec3<T> p;
    for (int i = 0; i < 3; ++i) p[i] = cache.expressed[3 * v + i] + cache.corrections[3 * v + i];
    return p;
  }

  const FlameModel& model;
  Directions<T> expression_directions;  // [3V, E]
  Directions<T> pose_directions;        // [3V, 36]
  VectorX<T> shaped;                    // [3V] template + S beta + offset
  VectorX<T> rest_joints;               // [15] regressor * shaped
  MatrixX<T> joint_directions;          // [15, E] regressor * expression directions
  std::vector<T> weights;               // [V, 5]
};

template <class T>
FlamePoser<T>::Impl::Impl(const FlameModel& m,
                          const std::vector<float>& shape,
                          const std::vector<float>& offset)
    : model((Validate(m), m)),
      expression_directions(m.expression_directions, 3 * m.vertex_count, m.expression_count),
      pose_directions(m.pose_directions, 3 * m.vertex_count, kFlamePoseFeatures),
      weights(m.skinning_weights.begin(), m.skinning_weights.end()) {
  const Eigen::Index rows = 3 * Eigen::Index(m.vertex_count);
  const size_t count = CheckCoefficients(m, "shape", shape, m.shape_count);
  shaped = Eigen::Map<const VectorX<float>>(m.template_vertices.data(), rows).cast<T>();
  for (size_t k = 0; k < count; ++k)
    shaped +=
        T(shape[k]) *
        Eigen::Map<const VectorX<float>>(m.shape_directions.data() + k * rows, rows).cast<T>();
  if (!offset.empty()) {
    if (Eigen::Index(offset.size()) != rows)
      throw Error(
          m.name, "static_offset", Format("has {} numbers, expected {}", offset.size(), rows));
    CheckParameters(m, "static_offset", offset);
    shaped += Eigen::Map<const VectorX<float>>(offset.data(), rows).cast<T>();
  }
  // [3, V] * [V, 5]: the regressor's rows are contiguous, so its map is [V, 5] column-major.
  const auto regressor =
      Eigen::Map<const MatrixX<float>>(m.joint_regressor.data(), m.vertex_count, kFlameJoints);
  const MatrixX<T> regressor_t = regressor.cast<T>();
  const auto regress = [&](const T* v) -> VectorX<T> {
    const MatrixX<T> joints = Eigen::Map<const MatrixX<T>>(v, 3, m.vertex_count) * regressor_t;
    return joints.reshaped();
  };
  rest_joints = regress(shaped.data());
  joint_directions.resize(3 * kFlameJoints, m.expression_count);
  for (int k = 0; k < m.expression_count; ++k)
    joint_directions.col(k) = regress(expression_directions.matrix().col(k).data());
}

template <class T>
typename FlamePoser<T>::Impl::Rig FlamePoser<T>::Impl::RigOf(const Parameters& parameters) const {
  const size_t count =
      CheckCoefficients(model, "expression", parameters.expression, model.expression_count);
  CheckParameters(model, "translation", parameters.translation);
  Rig rig;
  rig.expression_count = count;
  Eigen::Matrix<T, 3 * kFlameJoints, 1> joints = rest_joints;
  joints.noalias() += joint_directions.leftCols(count) *
                      Eigen::Map<const VectorX<T>>(parameters.expression.data(), count);
  for (int j = 0; j < kFlameJoints; ++j) {
    CheckParameters(model, "pose", parameters.pose[j]);
    rig.joints[j] = {joints[3 * j], joints[3 * j + 1], joints[3 * j + 2]};
    rig.local[j] = flame_math::Rodrigues(math::ToVec3(parameters.pose[j]));
    for (int i = 0; j > 0 && i < 9; ++i)
      rig.pose_features[9 * (j - 1) + i] = rig.local[j].m[i] - (i % 4 == 0 ? T(1) : T(0));
  }
  rig.transforms = flame_math::PoseJoints(rig.local, rig.joints, model.parents);
  return rig;
}

template <class T>
template <class Use>
void FlamePoser<T>::Impl::Blend(const Parameters& parameters,
                                const Rig& rig,
                                Cache& cache,
                                const Use& use) const {
  const bool first = cache.expressed.empty();
  cache.expressed.resize(shaped.size());
  cache.corrections.resize(shaped.size());
  const T* const expression = parameters.expression.data();
  const bool express = Remember(expression, rig.expression_count, cache.expression) || first;
  const bool correct =
      Remember(rig.pose_features.data(), rig.pose_features.size(), cache.features) || first;
  ForStrips(model.vertex_count, [&](Eigen::Index v, Eigen::Index count) {
    const Eigen::Index begin = 3 * v, n = 3 * count;
    if (express) {
      T* const sum = cache.expressed.data() + begin;
      std::copy_n(shaped.data() + begin, n, sum);
      expression_directions.AddProduct(expression, rig.expression_count, begin, n, sum);
    }
    if (correct) {
      T* const sum = cache.corrections.data() + begin;
      std::fill_n(sum, n, T(0));
      pose_directions.AddProduct(rig.pose_features.data(), kFlamePoseFeatures, begin, n, sum);
    }
    use(v, count);
  });
}

// Converts d_vertices from after skinning to before it, in place; returns dL/d(transforms), summed
// per strip and then over the strips in order.
template <class T>
typename FlamePoser<T>::Impl::Transforms FlamePoser<T>::Impl::SkinVjp(
    const Rig& rig, const Cache& cache, VectorX<T>& d_vertices) const {
  std::vector<Transforms> partial((model.vertex_count + kStrip - 1) / kStrip, Transforms{});
  ForStrips(model.vertex_count, [&](Eigen::Index begin, Eigen::Index count) {
    for (Eigen::Index v = begin; v < begin + count; ++v) {
      T* const d = d_vertices.data() + 3 * v;
      const Vec3<T> d_in = flame_math::SkinPointVjp(rig.transforms,
                                                    &weights[kFlameJoints * v],
                                                    Unskinned(cache, v),
                                                    math::ToVec3(d),
                                                    partial[begin / kStrip]);
      std::copy_n(&d_in.x, 3, d);
    }
  });
  Transforms sum{};
  for (const Transforms& p : partial)
    for (int j = 0; j < kFlameJoints; ++j) {
      for (int i = 0; i < 9; ++i) sum.rotation[j].m[i] += p.rotation[j].m[i];
      sum.translation[j] += p.translation[j];
    }
  return sum;
}

template <class T>
FlamePoser<T>::FlamePoser(const FlameModel& model,
                          const std::vector<float>& shape,
                          const std::vector<float>& static_offset)
    : impl_(std::make_unique<Impl>(model, shape, static_offset)) {}
template <class T>
FlamePoser<T>::~FlamePoser() = default;
template <class T>
FlamePoser<T>::FlamePoser(FlamePoser&&) noexcept = default;

template <class T>
const FlameModel& FlamePoser<T>::model() const {
  return impl_->model;
}

template <class T>
typename FlamePoser<T>::Parameters FlamePoser<T>::ParametersOf(const FlameParams& params) {
  Parameters parameters;
  parameters.expression.assign(params.expression.begin(), params.expression.end());
  for (int j = 0; j < kFlameJoints; ++j)
    for (int i = 0; i < 3; ++i) parameters.pose[j][i] = params.pose[j][i];
  for (int i = 0; i < 3; ++i) parameters.translation[i] = params.translation[i];
  return parameters;
}

template <class T>
void FlamePoser<T>::Forward(const Parameters& parameters,
                            std::vector<T>& vertices,
                            Cache& cache) const {
  const Impl& m = *impl_;
  const auto rig = m.RigOf(parameters);
  vertices.resize(m.shaped.size());
  m.Blend(parameters, rig, cache, [&](Eigen::Index begin, Eigen::Index count) {
    for (Eigen::Index v = begin; v < begin + count; ++v) {
      const Vec3<T> p =
          math::ToVec3(parameters.translation) + flame_math::SkinPoint(rig.transforms,
                                                                       &m.weights[kFlameJoints * v],
                                                                       Impl::Unskinned(cache, v));
      std::copy_n(&p.x, 3, &vertices[3 * v]);
    }
  });
}

template <class T>
void FlamePoser<T>::Prepare(const Parameters& parameters, FlameRig<T>& out) const {
  const auto rig = impl_->RigOf(parameters);
  out.terms.clear();
  const auto add_terms = [&](const T* coefficients, size_t count) {
    for (size_t k = 0; k < count; ++k)
      if (coefficients[k] != T(0)) out.terms.push_back({int32_t(k), coefficients[k]});
    return out.terms.size();
  };
  out.expression_terms = add_terms(parameters.expression.data(), rig.expression_count);
  add_terms(rig.pose_features.data(), kFlamePoseFeatures);
  out.transforms = rig.transforms;
  out.translation = parameters.translation;
}

template <class T>
PosingArrays<T> FlamePoser<T>::Arrays() const {
  const Impl& m = *impl_;
  return {size_t(m.model.vertex_count),
          size_t(m.model.expression_count),
          m.shaped.data(),
          m.expression_directions.matrix().data(),
          m.pose_directions.matrix().data(),
          m.weights.data()};
}

template <class T>
typename FlamePoser<T>::Parameters FlamePoser<T>::Backward(const Parameters& parameters,
                                                           std::span<const T> d_vertices,
                                                           Cache& cache) const {
  const Impl& m = *impl_;
  const size_t size = m.shaped.size();
  if (d_vertices.size() != size)
    throw Error(
        m.model.name, "d_vertices", Format("has {} numbers, expected {}", d_vertices.size(), size));
  const auto rig = m.RigOf(parameters);
  m.Blend(parameters, rig, cache, [](Eigen::Index, Eigen::Index) {});
  VectorX<T> d_v = Eigen::Map<const VectorX<T>>(d_vertices.data(), size);
  const auto d_transforms = m.SkinVjp(rig, cache, d_v);

  typename Impl::Rotations d_local{};
  typename Impl::Joints d_joints{};
  flame_math::PoseJointsVjp(
      rig.local, rig.joints, m.model.parents, rig.transforms, d_transforms, d_local, d_joints);
  const VectorX<T> d_features = m.pose_directions.TransposeTimes(d_v);
  const VectorX<T> d_expression =
      m.expression_directions.TransposeTimes(d_v) +
      m.joint_directions.transpose() *
          Eigen::Map<const VectorX<T>>(&d_joints[0].x, 3 * kFlameJoints);

  Parameters d;
  for (int j = 0; j < kFlameJoints; ++j) {
    for (int i = 0; j > 0 && i < 9; ++i) d_local[j].m[i] += d_features[9 * (j - 1) + i];
    const Vec3<T> d_pose = flame_math::RodriguesVjp(math::ToVec3(parameters.pose[j]), d_local[j]);
    d.pose[j] = {d_pose.x, d_pose.y, d_pose.z};
  }
  // Coefficients beyond the model's have no effect, hence a zero gradient; sized like the input.
  d.expression.assign(parameters.expression.size(), T(0));
  for (Eigen::Index k = 0; k < Eigen::Index(rig.expression_count); ++k)
    d.expression[k] = d_expression[k];
  for (size_t i = 0; i < size; ++i) d.translation[i % 3] += d_vertices[i];
  return d;
}

math::Vec3<float> HeadForward(const FlameParams& params) {
  const Mat3<float> turn = flame_math::Rodrigues(math::ToVec3(params.pose[0])) *
                           flame_math::Rodrigues(math::ToVec3(params.pose[1]));
  return {turn(0, 2), turn(1, 2), turn(2, 2)};
}

double DegreesTurned(const FlameParams& params, const Camera& camera) {
  const float facing = -math::Dot(math::ToVec3(&camera.rotation[6]), HeadForward(params));
  return std::acos(std::clamp(double(facing), -1.0, 1.0)) * 180 / std::numbers::pi;
}

template class FlamePoser<float>;
template class FlamePoser<double>;

}  // namespace cosplat
