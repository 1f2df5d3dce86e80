// Which rank has which rows of a per-Gaussian array that is divided between ranks, and several such
// arrays together.
//
// The ranks' shares are blocks of neighbouring rows in turn: a view sees one region, and neighbours
// in the arrays are neighbours in space, so that every rank has its part of what a view moves. A
// rank keeps its own rows one after another.
#pragma once

#include <cstddef>
#include <cstdint>

#include "splat/gaussians.h"
#include "splat/math/namespace.h"
#include "splat/render/kernels/world_gaussians.h"

namespace cosplat {

// As many Gaussians as Adam updates in one run of its inner loop; whole groups (kGaussianGroup).
constexpr size_t kRowsPerBlock = 512;

struct RowShare {
  uint32_t rank = 0, ranks = 1;

  COSPLAT_HD size_t OwnerOf(size_t row) const { return row / kRowsPerBlock % ranks; }
  COSPLAT_HD bool Owns(size_t row) const { return OwnerOf(row) == rank; }
  // Where its owner keeps a row.
  COSPLAT_HD size_t PlaceOf(size_t row) const {
    return row / kRowsPerBlock / ranks * kRowsPerBlock + row % kRowsPerBlock;
  }
  // Own rows among the first `rows`.
  COSPLAT_HD size_t CountOf(size_t rows) const {
    const size_t blocks = rows / kRowsPerBlock, rest = rows % kRowsPerBlock;
    return (blocks / ranks + (rank < blocks % ranks ? 1 : 0)) * kRowsPerBlock +
           (rank == blocks % ranks ? rest : 0);
  }
};

// An array with `width` numbers per Gaussian.
struct RowArray {
  float* data = nullptr;
  size_t width = 0;
};

// What is sent of a Gaussian: at most its attributes, the gradient of its centre and its radius.
struct RowArrays {
  static constexpr size_t kMax = kAttributeCount + 2;
  RowArray array[kMax];
  size_t count = 0;

  void Add(RowArray more) { array[count++] = more; }
  // Numbers of a group.
  size_t numbers() const {
    size_t sum = 0;
    for (size_t a = 0; a < count; ++a) sum += kGaussianGroup * array[a].width;
    return sum;
  }
};

}  // namespace cosplat
