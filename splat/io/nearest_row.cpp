#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>

#include "splat/io/kmeans.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/io/nearest_row.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "splat/math/namespace.h"

#ifndef COSPLAT_SPLAT_CPU_NEAREST_ROW_CPP_
#define COSPLAT_SPLAT_CPU_NEAREST_ROW_CPP_
namespace cosplat {

// Rows per task: the rows, their best candidates so far and a panel fit in the L1 cache together.
constexpr size_t kTaskRows = 96;
// Rows and candidate vectors held in registers at once: 12 sums, 2 candidates.
constexpr size_t kRowsAtOnce = 6;
constexpr size_t kVectorsAtOnce = 2;

// The candidates c, interleaved in groups of `lanes`: first |c|^2 / 2 of each, then component k of
// each. Padded to kVectorsAtOnce with candidates at infinite distance.
struct Panels {
  size_t lanes, width, vectors;
  Buffer<float> values;  // [vectors, 1 + width, lanes]
};

struct TaskRows {
  const float* rows;  // [count, panels.width]
  size_t count;       // at most kTaskRows
  NearestRow* nearest;
};

}  // namespace cosplat
#endif

COSPLAT_MATH_BEGIN

namespace hn = hwy::HWY_NAMESPACE;
using FullLanes = hn::CappedTag<float, 16>;
using FullVector = hn::Vec<FullLanes>;

size_t PanelLanes() { return hn::Lanes(FullLanes()); }

// Per row and lane, the smallest |c|^2 / 2 - x c and the index of its vector.
struct BestOfLanes {
  alignas(64) float score[kTaskRows][hn::MaxLanes(FullLanes())];
  alignas(64) float vector[kTaskRows][hn::MaxLanes(FullLanes())];
};

// Updates the best of rows row, row + 1, ... with kVectorsAtOnce candidate vectors from `first` on.
HWY_INLINE void TryVectors(
    const TaskRows& task, const Panels& panels, size_t first, size_t row, BestOfLanes& best) {
  const FullLanes d;
  const size_t lanes = panels.lanes, stride = (1 + panels.width) * lanes;
  const float* c0 = panels.values.data() + first * stride;
  const float* c1 = c0 + stride;
  const float* x[kRowsAtOnce];
  FullVector s0[kRowsAtOnce], s1[kRowsAtOnce];
  for (size_t r = 0; r < kRowsAtOnce; ++r) {
    x[r] = task.rows + std::min(row + r, task.count - 1) * panels.width;
    s0[r] = hn::Load(d, c0);
    s1[r] = hn::Load(d, c1);
  }
  for (size_t k = 0; k < panels.width; ++k) {
    const auto v0 = hn::Load(d, c0 + (k + 1) * lanes), v1 = hn::Load(d, c1 + (k + 1) * lanes);
    for (size_t r = 0; r < kRowsAtOnce; ++r) {
      const auto value = hn::Set(d, x[r][k]);
      s0[r] = hn::NegMulAdd(value, v0, s0[r]);
      s1[r] = hn::NegMulAdd(value, v1, s1[r]);
    }
  }
  for (size_t r = 0; r < kRowsAtOnce && row + r < task.count; ++r) {
    float *score = best.score[row + r], *vector = best.vector[row + r];
    const auto less = hn::Lt(s1[r], s0[r]);
    const auto s = hn::IfThenElse(less, s1[r], s0[r]);
    const auto v = hn::IfThenElse(less, hn::Set(d, float(first + 1)), hn::Set(d, float(first)));
    const auto old = hn::Load(d, score);
    const auto better = hn::Lt(s, old);
    hn::Store(hn::IfThenElse(better, s, old), d, score);
    hn::Store(hn::IfThenElse(better, v, hn::Load(d, vector)), d, vector);
  }
}

void NearestOfTask(const TaskRows& task, const Panels& panels) {
  BestOfLanes best;
  for (size_t r = 0; r < task.count; ++r)
    for (size_t l = 0; l < panels.lanes; ++l)
      best.score[r][l] = std::numeric_limits<float>::infinity(), best.vector[r][l] = 0;
  for (size_t v = 0; v < panels.vectors; v += kVectorsAtOnce)
    for (size_t r = 0; r < task.count; r += kRowsAtOnce) TryVectors(task, panels, v, r, best);
  for (size_t r = 0; r < task.count; ++r) {
    float min = std::numeric_limits<float>::infinity(), norm2 = 0;
    NearestRow& nearest = task.nearest[r];
    nearest.index = 0;
    for (size_t l = 0; l < panels.lanes; ++l) {
      const uint32_t index = uint32_t(best.vector[r][l]) * uint32_t(panels.lanes) + uint32_t(l);
      const float score = best.score[r][l];
      if (score > min || (score == min && index > nearest.index)) continue;
      min = score;
      nearest.index = index;
    }
    for (size_t k = 0; k < panels.width; ++k) {
      const float x = task.rows[r * panels.width + k];
      norm2 += x * x;
    }
    nearest.distance2 = std::max(0.0f, norm2 + 2 * min);
  }
}

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(PanelLanes);
HWY_EXPORT(NearestOfTask);
}  // namespace math

namespace {

Panels MakePanels(View<const float> of, size_t width) {
  const size_t lanes = HWY_DYNAMIC_DISPATCH(math::PanelLanes)(), count = of.size() / width;
  const size_t vectors = (count + lanes - 1) / lanes;
  const size_t padded = (vectors + kVectorsAtOnce - 1) / kVectorsAtOnce * kVectorsAtOnce;
  Panels panels{lanes, width, padded, Buffer<float>(padded * (1 + width) * lanes, 0.0f)};
  for (size_t i = 0; i < padded * lanes; ++i) {
    float* out = panels.values.data() + i / lanes * (1 + width) * lanes + i % lanes;
    if (i >= count) {
      *out = std::numeric_limits<float>::infinity();
      continue;
    }
    float norm2 = 0;
    for (size_t k = 0; k < width; ++k) {
      const float c = of[i * width + k];
      norm2 += c * c;
      out[(k + 1) * lanes] = c;
    }
    *out = 0.5f * norm2;
  }
  return panels;
}

}  // namespace

void FindNearestRows(View<const float> rows,
                     View<const float> of,
                     size_t width,
                     View<NearestRow> nearest) {
  const Panels panels = MakePanels(of, width);
  const size_t count = nearest.size(), tasks = (count + kTaskRows - 1) / kTaskRows;
  tbb::parallel_for(size_t(0), tasks, [&](size_t t) {
    const size_t begin = t * kTaskRows;
    const TaskRows task{
        rows.data + begin * width, std::min(kTaskRows, count - begin), nearest.data + begin};
    HWY_DYNAMIC_DISPATCH(math::NearestOfTask)(task, panels);
  });
}

}  // namespace cosplat
#endif
