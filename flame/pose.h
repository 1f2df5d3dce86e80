// FLAME's forward pass and its derivative.
//
// FlameParams -> posed vertices -> (avatar binding, rendering) -> d_vertices -> d_params.
// v_s = T + S beta + E psi (+ offsets); J = regressor * v_s (after expression); R_j = Rodrigues;
// v_p = v_s + posedirs * vec(R_1..4 - I); linear blend skinning with G * T(-J); then + translation.
// The root turns about J_0, not the origin. Source: Li et al. 2017, eq. 2-5, as in the released
// code.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "flame/model.h"
#include "flame/posing.h"

namespace cosplat {

// Poses a model of one subject: the shape-dependent part is computed once.
// T: float for use, double for derivative tests.
template <class T>
class FlamePoser {
 public:
  // `shape` and `static_offset` ([V,3] or empty) are the subject's. Keeps a reference to `model`.
  FlamePoser(const FlameModel& model,
             const std::vector<float>& shape,
             const std::vector<float>& static_offset = {});
  ~FlamePoser();
  FlamePoser(FlamePoser&&) noexcept;

  // Subset of FlameParams that changes per frame, in T.
  struct Frame {
    std::vector<T> expression;
    std::array<std::array<T, 3>, kFlameJoints> pose{};
    std::array<T, 3> translation{};
  };
  static Frame FrameOf(const FlameParams& params);

  // What one caller keeps between frames: memory, and the two blend-shape sums of the last frame,
  // which are not computed again where its expression or its joints' rotations are the same. Does
  // not change the results. Not to be shared between posers or threads.
  class Cache {
   private:
    friend class FlamePoser;
    std::vector<T> expression, features;    // that the sums are of; both empty: of none yet
    std::vector<T> expressed, corrections;  // [V, 3] with expression; added by pose directions
  };

  // vertices: [V, 3], metres. Throws Error when a parameter is not finite or there are more
  // expression coefficients than the model has and one of the excess ones is not zero; nothing is
  // written then. Same bits for any number of threads.
  void Forward(const Frame& frame, std::vector<T>& vertices, Cache& cache) const;
  void Forward(const Frame& frame, std::vector<T>& vertices) const {
    Cache cache;
    Forward(frame, vertices, cache);
  }

  // d_vertices [V, 3] = dL/d(vertices) at `frame` -> gradients with respect to the frame. Cheaper
  // with the cache of the Forward before.
  Frame Backward(const Frame& frame, std::span<const T> d_vertices, Cache& cache) const;
  Frame Backward(const Frame& frame, std::span<const T> d_vertices) const {
    Cache cache;
    return Backward(frame, d_vertices, cache);
  }

  // For whoever poses the vertices in Forward's place: `out` is the frame after its joints. Throws
  // Error as Forward does; `out` is not written then.
  void Prepare(const Frame& frame, FlameRig<T>& out) const;
  PosingArrays<T> Arrays() const;

  const FlameModel& model() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosplat
