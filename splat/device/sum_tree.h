// Runs the tree of splat/device/sum.h. A device back end must have SumBlocks<Values> and
// SumBlocks<View<const SumType<Values>>>.
#pragma once

#include "splat/device/for_each.h"
#include "splat/device/sum.h"

namespace cosplat {

// The last sums of the tree, at most kSumBlock of them, in memory that `scratch` owns: what uses
// the total adds these by SumOfBlock(sums, 0).
template <class Values>
View<const SumType<Values>> SumInTree(const Values& values,
                                      Buffer<SumType<Values>>& scratch,
                                      Stream& stream) {
  using Sum = SumType<Values>;
  size_t count = SumBlockCount(values.size()), total = count;
  for (size_t n = count; n > kSumBlock; total += n) n = SumBlockCount(n);
  scratch.Refill(total, stream);
  View<Sum> sums(scratch.data(), count);
  ForEach(count, stream, SumBlocks<Values>{values, sums});
  while (sums.count > kSumBlock) {
    const View<Sum> above(sums.end(), SumBlockCount(sums.count));
    ForEach(above.count, stream, SumBlocks<View<const Sum>>{sums, above});
    sums = above;
  }
  return sums;
}

}  // namespace cosplat
