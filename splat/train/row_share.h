// Which rank has which rows of a per-Gaussian array that is divided between ranks.
//
// The ranks' shares are blocks of neighbouring rows in turn: a view sees one region, and neighbours
// in the arrays are neighbours in space, so that every rank has its part of what a view moves. A
// rank keeps its own rows one after another.
#pragma once

#include <cstddef>
#include <cstdint>

#include "splat/math/namespace.h"

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

}  // namespace cosplat
