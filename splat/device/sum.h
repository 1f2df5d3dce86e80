// Sums in a tree that depends on nothing but the number of values, so that they have the same bits
// for any number of threads, on the host as on a device: values -> sums of blocks of them -> sums
// of blocks of these -> ... (splat/device/sum_tree.h runs it).
#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

#include "splat/device/buffer.h"

namespace cosplat {

// Values of a block, which one call adds in their order. On a device a call waits for one load
// after the other, so that a tree of small blocks is faster, and three levels suffice for two
// million.
constexpr size_t kSumBlock = 128;

constexpr size_t SumBlockCount(size_t values) { return (values + kSumBlock - 1) / kSumBlock; }

// What Values gives for an index: a number, or a struct with += whose T() is zero.
template <class Values>
using SumType = std::remove_cvref_t<decltype(std::declval<const Values&>()[0])>;

// values: anything with size() and [i].
template <class Values>
COSPLAT_HD SumType<Values> SumOfBlock(const Values& values, size_t block) {
  const size_t begin = block * kSumBlock, rest = values.size() - begin;
  const size_t end = begin + (rest < kSumBlock ? rest : kSumBlock);
  SumType<Values> sum{};
  for (size_t i = begin; i < end; ++i) sum += values[i];
  return sum;
}

// One call per block.
template <class Values>
struct SumBlocks {
  Values values;
  View<SumType<Values>> sums;
  COSPLAT_HD void operator()(size_t b) const { sums[b] = SumOfBlock(values, b); }
};

}  // namespace cosplat
