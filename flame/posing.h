// Input for posing FLAME's vertices outside of FlamePoser: the data of a subject and of a frame
// that remain after shape and joints have been evaluated.
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

// Pointers into a poser and its model, which must outlive them.
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

// A frame after posing its joints.
template <class T>
struct FlameRig {
  // The non-zero coefficients: those of the expression, then those of the pose corrections, each
  // with its direction's index within the respective array.
  std::vector<DirectionTerm<T>> terms;
  size_t expression_terms = 0;
  flame_math::JointTransforms<T, kFlameJoints> transforms{};
  std::array<T, 3> translation{};  // metres, after skinning
};

// An upper bound on a frame's vertex coordinates, to detect float overflow before posing.
// FlamePoser's limits bound the parameters, but not the numbers of a model.
class PosingReach {
 public:
  explicit PosingReach(const PosingArrays<float>& arrays);
  // Throws Error if a coordinate, or a sum that leads to it, might not be finite.
  void Check(const FlameRig<float>& rig) const;

 private:
  double shaped_, weights_;                // largest magnitude; largest row sum of magnitudes
  std::vector<double> expression_, pose_;  // largest magnitude in each direction
};

}  // namespace cosplat
