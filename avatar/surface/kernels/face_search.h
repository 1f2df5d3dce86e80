// The state of a best-first search over the mesh: a queue of faces still to be expanded, nearest
// first, and the set of faces seen. Of fixed size (12 kB), so that it can be preallocated on a
// device.
#pragma once

#include <cstddef>
#include <cstdint>

#include "splat/math/namespace.h"

namespace cosplat::math {

struct FaceAtDistance {
  double distance2;
  int32_t face;
  // Ties are broken by face index.
  COSPLAT_HD bool IsBefore(const FaceAtDistance& other) const {
    return distance2 != other.distance2 ? distance2 < other.distance2 : face < other.face;
  }
};

class FaceSearch {
 public:
  // Enough, because a split moves a Gaussian by a few of its own widths: a few triangles on FLAME.
  static constexpr int kMaxFaces = 512;

  COSPLAT_HD void Start() {
    open_count_ = seen_count_ = 0;
    for (int32_t& slot : seen_) slot = kFree;
  }

  // Marks `face` as seen. Returns false if it was seen before or the set is full.
  COSPLAT_HD bool See(int32_t face) {
    if (seen_count_ == kMaxFaces) return false;
    // Knuth's multiplicative hash with linear probing; at most half of the slots are used.
    uint32_t slot = uint32_t(face) * 2654435769u >> (32 - kSlotBits);
    for (; seen_[slot] != kFree; slot = (slot + 1) % kSlots)
      if (seen_[slot] == face) return false;
    seen_[slot] = face;
    ++seen_count_;
    return true;
  }
  COSPLAT_HD bool IsFull() const { return seen_count_ == kMaxFaces; }

  COSPLAT_HD bool IsEmpty() const { return open_count_ == 0; }
  // Only for faces for which See returned true, so that each is pushed once.
  COSPLAT_HD void Push(const FaceAtDistance& entry) {
    int at = open_count_++;
    for (; at > 0 && entry.IsBefore(open_[(at - 1) / 2]); at = (at - 1) / 2)
      open_[at] = open_[(at - 1) / 2];
    open_[at] = entry;
  }
  COSPLAT_HD FaceAtDistance PopNearest() {
    const FaceAtDistance nearest = open_[0], last = open_[--open_count_];
    int at = 0;
    for (int child = 1; child < open_count_; child = 2 * at + 1) {
      if (child + 1 < open_count_ && open_[child + 1].IsBefore(open_[child])) ++child;
      if (!open_[child].IsBefore(last)) break;
      open_[at] = open_[child];
      at = child;
    }
    open_[at] = last;
    return nearest;
  }

 private:
  static constexpr int kSlotBits = 10;
  static constexpr uint32_t kSlots = 1u << kSlotBits;
  static constexpr int32_t kFree = -1;

  FaceAtDistance open_[kMaxFaces];  // a binary heap
  int32_t seen_[kSlots];            // a hash table
  int open_count_, seen_count_;
};

}  // namespace cosplat::math
