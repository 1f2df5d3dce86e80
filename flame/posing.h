// FLAME's vertices posed by somebody else than FlamePoser: what of the subject and of a frame is
// left when shape and joints are done.
//
// FlamePoser::Arrays (once) and FlamePoser::Prepare (each frame, some hundred numbers) -> the
// kernels of flame/kernels/pose.h, on a device (avatar/play/rig_poser.h) -> posed vertices.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "flame/math/kinematics.h"
#include "flame/model.h"

namespace cosplat {

// Borrowed from a poser and its model.
template <class T>
struct PosingArrays {
  size_t vertex_count = 0;
  size_t expression_count = 0;               // E
  const T* shaped = nullptr;                 // [V, 3] metres: template, shape, static offset
  const T* expression_directions = nullptr;  // [E, V, 3]
  const T* pose_directions = nullptr;        // [kFlamePoseFeatures, V, 3]
  const T* weights = nullptr;                // [V, kFlameJoints]
};

template <class T>
struct DirectionTerm {
  int32_t direction;
  T coefficient;
};

// A frame after its joints.
template <class T>
struct FlameRig {
  // Coefficients that are not zero: the expression's, then those of the pose's corrections, each
  // with the number of its direction among its kind.
  std::vector<DirectionTerm<T>> terms;
  size_t expression_terms = 0;
  flame_math::JointTransforms<T, kFlameJoints> transforms{};
  std::array<T, 3> translation{};  // metres, after skinning
};

// How far out a frame can put a vertex, so that what leaves float's range is known before it is
// posed: FlamePoser's limits on parameters bound them, but not a model's numbers.
class PosingReach {
 public:
  explicit PosingReach(const PosingArrays<float>& arrays);
  // Throws Error where a coordinate, or a sum that leads to it, might not be finite.
  void Check(const FlameRig<float>& rig) const;

 private:
  double shaped_, weights_;                // the largest number; the largest sum of a row
  std::vector<double> expression_, pose_;  // the largest number of each direction
};

}  // namespace cosplat
