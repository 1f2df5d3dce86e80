#include "flame/pose.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>

#include "flame/math/kinematics.h"
#include "flame/math/rodrigues.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

using flame_math::JointTransforms;
using flame_math::Matrix3;
using flame_math::Vector3;

// Beyond this a parameter is no pose or coefficient but a fault of the tracker: squared angles and
// scaled directions would leave float's range and come back as NaN.
constexpr double kLargestParameter = 1e6;

template <class T>
using VectorX = Eigen::Matrix<T, Eigen::Dynamic, 1>;
template <class T>
using MatrixX = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>;  // column-major

// The model's direction arrays [K, V, 3] are column-major [3V, K] matrices. In float they are used
// in place; in double they are converted once.
template <class T>
class Directions {
 public:
  Directions(const std::vector<float>& values, Eigen::Index rows, Eigen::Index columns) {
    const Eigen::Map<const MatrixX<float>> source(values.data(), rows, columns);
    if constexpr (std::is_same_v<T, float>) {
      data_ = values.data();
    } else {
      copy_ = source.cast<T>();
      data_ = copy_.data();
    }
    rows_ = rows;
    columns_ = columns;
  }
  Eigen::Map<const MatrixX<T>> matrix() const { return {data_, rows_, columns_}; }

  // y += matrix * x, skipping zero coefficients (most of them, in a neutral or partly posed frame).
  void AddProduct(const VectorX<T>& x, Eigen::Map<VectorX<T>> y) const {
    constexpr Eigen::Index kRows = 2048;  // a strip of y that stays in the first-level cache
    const auto m = matrix();
    for (Eigen::Index row = 0; row < rows_; row += kRows) {
      const Eigen::Index n = std::min(kRows, rows_ - row);
      for (Eigen::Index k = 0; k < x.size(); ++k)
        if (x[k] != T(0)) y.segment(row, n) += x[k] * m.col(k).segment(row, n);
    }
  }

 private:
  MatrixX<T> copy_;
  const T* data_ = nullptr;
  Eigen::Index rows_ = 0;
  Eigen::Index columns_ = 0;
};

template <class Range>
void CheckParameters(const FlameModel& model, const char* name, const Range& values) {
  for (size_t i = 0; i < values.size(); ++i)
    if (!(std::abs(double(values[i])) <= kLargestParameter))
      throw Error(model.name,
                  name + ("[" + std::to_string(i) + "]"),
                  std::to_string(double(values[i])) + " is not a usable number");
}

// Number of coefficients that the model can use; the excess must be zero.
template <class T>
size_t CheckCoefficients(const FlameModel& model,
                         const char* name,
                         const std::vector<T>& values,
                         int available) {
  CheckParameters(model, name, values);
  for (size_t i = available; i < values.size(); ++i)
    if (values[i] != T(0))
      throw Error(model.name,
                  name + ("[" + std::to_string(i) + "]"),
                  "is " + std::to_string(double(values[i])) + ", but the model has only " +
                      std::to_string(available) + " directions");
  return std::min(values.size(), size_t(available));
}

}  // namespace

template <class T>
struct FlamePoser<T>::Impl {
  using Transforms = JointTransforms<T, kFlameJoints>;
  using Rotations = std::array<Matrix3<T>, kFlameJoints>;
  using Joints = std::array<Vector3<T>, kFlameJoints>;

  // Everything between the parameters and skinning.
  struct Rig {
    VectorX<T> expression;     // as many as the model has or the frame gives
    VectorX<T> pose_features;  // vec(R_1..4 - I)
    Rotations local;
    Joints joints;
    Transforms transforms;
  };

  Impl(const FlameModel& m, const std::vector<float>& shape, const std::vector<float>& offset);
  Rig RigOf(const Frame& frame) const;
  void UnskinnedVertices(const Rig& rig, T* vertices) const;
  void Skin(const Rig& rig, const std::array<T, 3>& translation, T* vertices) const;
  Transforms SkinVjp(const Rig& rig, const T* unskinned, T* d_vertices) const;

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
          m.name,
          "static_offset",
          "has " + std::to_string(offset.size()) + " numbers, expected " + std::to_string(rows));
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
typename FlamePoser<T>::Impl::Rig FlamePoser<T>::Impl::RigOf(const Frame& frame) const {
  const size_t count =
      CheckCoefficients(model, "expression", frame.expression, model.expression_count);
  CheckParameters(model, "translation", frame.translation);
  Rig rig;
  rig.expression = Eigen::Map<const VectorX<T>>(frame.expression.data(), count);
  VectorX<T> joints = rest_joints;
  joints.noalias() += joint_directions.leftCols(count) * rig.expression;
  rig.pose_features.resize(kFlamePoseFeatures);
  for (int j = 0; j < kFlameJoints; ++j) {
    CheckParameters(model, "pose", frame.pose[j]);
    rig.joints[j] = {joints[3 * j], joints[3 * j + 1], joints[3 * j + 2]};
    rig.local[j] = flame_math::Rodrigues(frame.pose[j]);
    for (int i = 0; j > 0 && i < 9; ++i)
      rig.pose_features[9 * (j - 1) + i] = rig.local[j][i] - (i % 4 == 0 ? T(1) : T(0));
  }
  rig.transforms = flame_math::PoseJoints(rig.local, rig.joints, model.parents);
  return rig;
}

template <class T>
void FlamePoser<T>::Impl::UnskinnedVertices(const Rig& rig, T* vertices) const {
  Eigen::Map<VectorX<T>> v(vertices, shaped.size());
  v = shaped;
  expression_directions.AddProduct(rig.expression, v);
  pose_directions.AddProduct(rig.pose_features, v);
}

template <class T>
void FlamePoser<T>::Impl::Skin(const Rig& rig,
                               const std::array<T, 3>& translation,
                               T* vertices) const {
  T joint[kFlameJoints][12];  // rotation, then translation
  for (int j = 0; j < kFlameJoints; ++j) {
    std::copy_n(rig.transforms.rotation[j].data(), 9, joint[j]);
    std::copy_n(rig.transforms.translation[j].data(), 3, joint[j] + 9);
  }
  for (int v = 0; v < model.vertex_count; ++v) {
    T m[12] = {};
    for (int j = 0; j < kFlameJoints; ++j)
      for (int i = 0; i < 12; ++i) m[i] += weights[kFlameJoints * v + j] * joint[j][i];
    T* p = vertices + 3 * v;
    const T x = p[0], y = p[1], z = p[2];
    for (int i = 0; i < 3; ++i)
      p[i] = m[3 * i] * x + m[3 * i + 1] * y + m[3 * i + 2] * z + m[9 + i] + translation[i];
  }
}

// Turns d_vertices from after skinning to before it, in place; returns dL/d(transforms).
template <class T>
typename FlamePoser<T>::Impl::Transforms FlamePoser<T>::Impl::SkinVjp(const Rig& rig,
                                                                      const T* unskinned,
                                                                      T* d_vertices) const {
  Transforms d{};
  for (int v = 0; v < model.vertex_count; ++v) {
    const T* w = &weights[kFlameJoints * v];
    const Vector3<T> p = {unskinned[3 * v], unskinned[3 * v + 1], unskinned[3 * v + 2]};
    const Vector3<T> d_out = {d_vertices[3 * v], d_vertices[3 * v + 1], d_vertices[3 * v + 2]};
    Matrix3<T> outer{};
    flame_math::AddOuter(outer, d_out, p);
    Matrix3<T> blended{};
    for (int j = 0; j < kFlameJoints; ++j) {
      for (int i = 0; i < 9; ++i) {
        blended[i] += w[j] * rig.transforms.rotation[j][i];
        d.rotation[j][i] += w[j] * outer[i];
      }
      for (int i = 0; i < 3; ++i) d.translation[j][i] += w[j] * d_out[i];
    }
    const Vector3<T> d_in = flame_math::TransposeTimes(blended, d_out);
    std::copy_n(d_in.data(), 3, d_vertices + 3 * v);
  }
  return d;
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
typename FlamePoser<T>::Frame FlamePoser<T>::FrameOf(const FlameParams& params) {
  Frame frame;
  frame.expression.assign(params.expression.begin(), params.expression.end());
  for (int j = 0; j < kFlameJoints; ++j)
    for (int i = 0; i < 3; ++i) frame.pose[j][i] = params.pose[j][i];
  for (int i = 0; i < 3; ++i) frame.translation[i] = params.translation[i];
  return frame;
}

template <class T>
void FlamePoser<T>::Forward(const Frame& frame, std::vector<T>& vertices) const {
  const auto rig = impl_->RigOf(frame);
  vertices.resize(impl_->shaped.size());
  impl_->UnskinnedVertices(rig, vertices.data());
  impl_->Skin(rig, frame.translation, vertices.data());
}

template <class T>
typename FlamePoser<T>::Frame FlamePoser<T>::Backward(const Frame& frame,
                                                      const std::vector<T>& d_vertices) const {
  const Impl& m = *impl_;
  const size_t size = m.shaped.size();
  if (d_vertices.size() != size)
    throw Error(
        m.model.name,
        "d_vertices",
        "has " + std::to_string(d_vertices.size()) + " numbers, expected " + std::to_string(size));
  const auto rig = m.RigOf(frame);
  std::vector<T> unskinned(size);
  m.UnskinnedVertices(rig, unskinned.data());
  std::vector<T> d_unskinned = d_vertices;
  const auto d_transforms = m.SkinVjp(rig, unskinned.data(), d_unskinned.data());

  typename Impl::Rotations d_local{};
  typename Impl::Joints d_joints{};
  flame_math::PoseJointsVjp(
      rig.local, rig.joints, m.model.parents, rig.transforms, d_transforms, d_local, d_joints);
  const Eigen::Map<const VectorX<T>> d_v(d_unskinned.data(), size);
  const VectorX<T> d_features = m.pose_directions.matrix().transpose() * d_v;
  const VectorX<T> d_expression =
      m.expression_directions.matrix().transpose() * d_v +
      m.joint_directions.transpose() *
          Eigen::Map<const VectorX<T>>(d_joints[0].data(), 3 * kFlameJoints);

  Frame d;
  for (int j = 0; j < kFlameJoints; ++j) {
    for (int i = 0; j > 0 && i < 9; ++i) d_local[j][i] += d_features[9 * (j - 1) + i];
    d.pose[j] = flame_math::RodriguesVjp(frame.pose[j], d_local[j]);
  }
  // Coefficients beyond the model's have no effect, hence a zero gradient; as many as were given.
  d.expression.assign(frame.expression.size(), T(0));
  for (Eigen::Index k = 0; k < rig.expression.size(); ++k) d.expression[k] = d_expression[k];
  for (size_t i = 0; i < size; ++i) d.translation[i % 3] += d_vertices[i];
  return d;
}

template class FlamePoser<float>;
template class FlamePoser<double>;

}  // namespace cosplat
