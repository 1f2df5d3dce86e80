// Which rank has which rows of a per-Gaussian array that is divided between ranks, and several such
// arrays together.
//
// The ranks' shares are blocks of neighbouring rows in turn: a view sees one region, and neighbours
// in the arrays are neighbours in space, so that every rank has its part of what a view moves. A
// rank keeps its own rows one after another.
#pragma once

#include <cstddef>
#include <cstdint>

#include "splat/device/buffer.h"
#include "splat/gaussians.h"
#include "splat/math/namespace.h"
#include "splat/render/kernels/world_gaussians.h"

namespace cosplat {

// Whole groups (kGaussianGroup); few enough that ranks have equal parts of what a view shows, and
// so many that Adam's inner loop has long runs.
constexpr size_t kRowsPerBlock = 512;

struct RowShare {
  uint32_t rank = 0, ranks = 1;

  COSPLAT_HD size_t OwnerOf(size_t row) const { return row / kRowsPerBlock % ranks; }
  COSPLAT_HD bool Owns(size_t row) const { return OwnerOf(row) == rank; }
  // Where its owner keeps a row.
  COSPLAT_HD size_t PlaceOf(size_t row) const {
    return row / kRowsPerBlock / ranks * kRowsPerBlock + row % kRowsPerBlock;
  }
  // The row that its owner keeps there.
  COSPLAT_HD size_t RowAt(size_t place) const {
    return (place / kRowsPerBlock * ranks + rank) * kRowsPerBlock + place % kRowsPerBlock;
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

// What is sent of a Gaussian: at most its attributes, its smoothing and three statistics.
struct RowArrays {
  static constexpr size_t kMax = kAttributeCount + 4;
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

// Where groups are: in an array of so many rows, from the row of group `first` on; the last of all
// may be smaller. Without a list, group k is the kth.
struct GroupPlaces {
  RowArrays arrays;
  size_t rows = 0;
  View<const uint32_t> list = {};
  size_t first = 0;

  COSPLAT_HD size_t At(size_t k) const { return (list.count == 0 ? k : list[k]) - first; }
};

}  // namespace cosplat
