// FLAME's forward pass and its derivative.
//
// FlameParams -> posed vertices -> (avatar binding, rendering) -> d_vertices -> d_params.
// v_s = T + S beta + E psi (+ offsets); J = regressor * v_s (after expression); R_j = Rodrigues;
// v_p = v_s + posedirs * vec(R_1..4 - I); linear blend skinning with G * T(-J); then + translation.
// The root rotates about J_0, not the origin. Source: Li et al. 2017, eq. 2-5, as in the released
// code.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "flame/model.h"
#include "flame/posing.h"
#include "splat/base/camera.h"

namespace cosplat {

// Where the head looks, unit, in the world: FLAME's z turned by root and neck.
math::Vec3<float> HeadForward(const FlameParams& params);
// Degrees between that and the camera's axis. 0: a full face; 90: a profile.
double DegreesTurned(const FlameParams& params, const Camera& camera);

// Poses the model of one subject; the shape-dependent part is computed once.
// T: float for use, double for derivative tests.
template <class T>
class FlamePoser {
 public:
  // `shape` and `static_offset` ([V, 3] or empty) are the subject's. `model` must outlive it.
  FlamePoser(const FlameModel& model,
             const std::vector<float>& shape,
             const std::vector<float>& static_offset = {});
  ~FlamePoser();
  FlamePoser(FlamePoser&&) noexcept;

  // The subset of FlameParams that changes per frame, in T.
  struct Parameters {
    std::vector<T> expression;
    std::array<std::array<T, 3>, kFlameJoints> pose{};
    std::array<T, 3> translation{};
  };
  static Parameters ParametersOf(const FlameParams& params);

  // A caller's state between frames: memory, and the two blend-shape sums of the last frame, which
  // are reused while its expression or joint rotations are unchanged. Does not affect results. Not
  // to be shared between posers or threads.
  class Cache {
   private:
    friend class FlamePoser;
    std::vector<T> expression, features;    // inputs of the sums; both empty: not computed yet
    std::vector<T> expressed, corrections;  // [V, 3] with expression; sums of pose directions
  };

  // vertices: [V, 3], metres. Throws Error, without writing anything, if a parameter is not finite
  // or beyond 1e6, or an expression coefficient beyond those of the model is not zero.
  // Bit-identical for any number of threads.
  void Forward(const Parameters& parameters, std::vector<T>& vertices, Cache& cache) const;
  void Forward(const Parameters& parameters, std::vector<T>& vertices) const {
    Cache cache;
    Forward(parameters, vertices, cache);
  }

  // d_vertices [V, 3] = dL/d(vertices) at `parameters` -> gradients with respect to them. Cheaper
  // with the cache of the preceding Forward.
  Parameters Backward(const Parameters& parameters,
                      std::span<const T> d_vertices,
                      Cache& cache) const;
  Parameters Backward(const Parameters& parameters, std::span<const T> d_vertices) const {
    Cache cache;
    return Backward(parameters, d_vertices, cache);
  }

  // For code that poses the vertices itself, instead of Forward: `out` is the frame after posing
  // its joints. Throws Error as Forward does, without writing `out`.
  void Prepare(const Parameters& parameters, FlameRig<T>& out) const;
  PosingArrays<T> Arrays() const;

  const FlameModel& model() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosplat
