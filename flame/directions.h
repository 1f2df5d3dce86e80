// FLAME's direction arrays as matrices, and loops over strips of vertices, for the blend-shape sums
// in flame/pose.cpp.
#pragma once

#include <tbb/parallel_for.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <type_traits>
#include <vector>

#include "flame/math/skinning.h"

namespace cosplat::internal {

template <class T>
using VectorX = Eigen::Matrix<T, Eigen::Dynamic, 1>;
template <class T>
using MatrixX = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>;  // column-major

// Vertices per task: some tens of microseconds with FLAME's 136 directions, with sums that fit in
// the first-level cache.
constexpr Eigen::Index kStrip = 256;

// body(first vertex, number of vertices), with the same strips for any number of threads.
template <class Body>
void ForStrips(Eigen::Index vertices, const Body& body) {
  tbb::parallel_for(Eigen::Index(0), (vertices + kStrip - 1) / kStrip, [&](Eigen::Index strip) {
    body(strip * kStrip, std::min(kStrip, vertices - strip * kStrip));
  });
}

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

  // y += rows [begin, begin + n) of matrix * x, skipping zero coefficients, which are the majority
  // in a neutral or partly posed frame.
  void AddProduct(const T* x, Eigen::Index count, Eigen::Index begin, Eigen::Index n, T* y) const {
    std::array<const T*, 4> d;
    std::array<T, 4> c;
    size_t held = 0;
    for (Eigen::Index k = 0; k < count; ++k) {
      if (x[k] == T(0)) continue;
      d[held] = data_ + k * rows_ + begin;
      c[held++] = x[k];
      if (held < 4) continue;
      AddFour(c, d, n, y);
      held = 0;
    }
    for (size_t t = 0; t < held; ++t)
      for (Eigen::Index i = 0; i < n; ++i) y[i] = flame_math::AddDirection(y[i], c[t], d[t][i]);
  }

  // matrix^T * d.
  VectorX<T> TransposeTimes(const VectorX<T>& d) const {
    constexpr Eigen::Index kColumns = 8;
    VectorX<T> out(columns_);
    tbb::parallel_for(Eigen::Index(0), (columns_ + kColumns - 1) / kColumns, [&](Eigen::Index i) {
      const Eigen::Index n = std::min(kColumns, columns_ - i * kColumns);
      out.segment(i * kColumns, n).noalias() = matrix().middleCols(i * kColumns, n).transpose() * d;
    });
    return out;
  }

 private:
  // A separate loop over plain arrays, so that compilers vectorise it.
  static void AddFour(const std::array<T, 4>& c,
                      const std::array<const T*, 4>& d,
                      Eigen::Index n,
                      T* __restrict y) {
    const T *const d0 = d[0], *const d1 = d[1], *const d2 = d[2], *const d3 = d[3];
    const T four[4] = {c[0], c[1], c[2], c[3]};
    for (Eigen::Index i = 0; i < n; ++i)
      y[i] = flame_math::AddFourDirections(y[i], four, d0[i], d1[i], d2[i], d3[i]);
  }

  MatrixX<T> copy_;
  const T* data_ = nullptr;
  Eigen::Index rows_ = 0;
  Eigen::Index columns_ = 0;
};

}  // namespace cosplat::internal
