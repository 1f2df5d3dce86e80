#include "splat/train/ranks/all_gaussians.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "splat/device/for_each.h"
#include "splat/device/gather.h"

namespace cosplat {
namespace {

// What density control needs, or all attributes.
RowArrays RowsOf(Gaussians& gaussians, DensityStatistics& statistics, bool bands) {
  RowArrays rows;
  for (int a = 0; a < kAttributeCount; ++a)
    if (a != kColorRest || bands)
      rows.Add({gaussians.values[a].data(), size_t(gaussians.width(a))});
  if (!gaussians.smoothing.empty()) rows.Add({gaussians.smoothing.data(), 1});
  DensityStatistics::ForEachArray(
      [&](const std::string&, size_t width, Buffer<float>& array) {
        rows.Add({array.data(), width});
      },
      statistics);
  return rows;
}

void Refill(DensityStatistics& statistics, size_t n, Stream& stream) {
  DensityStatistics::ForEachArray(
      [&](const std::string&, size_t width, Buffer<float>& array) {
        array.Refill(n * width, stream);
      },
      statistics);
}

}  // namespace

void AllGaussians::Assemble(Extent extent,
                            Gaussians& own,
                            DensityStatistics& own_statistics,
                            size_t count) {
  if (extent_ >= extent) return;
  const bool whole = extent == Extent::kWhole;
  Gaussians layout;
  layout.degree = whole ? own.degree : 0;
  layout.basis = own.basis;
  gaussians_.RefillLike(layout, stream_, count);
  gaussians_.antialiased = own.antialiased;
  gaussians_.smoothing.Refill(shards_.AnyHas(own.smoothing) ? count : 0, stream_);
  Refill(statistics_, count, stream_);
  const RowArrays rows = RowsOf(gaussians_, statistics_, whole);
  shards_.Assemble(RowsOf(own, own_statistics, whole), rows, count, stream_);
  assembled_ += GroupCount(count) * rows.numbers();
  gaussians_.degrees.Refill(0, stream_);
  if (shards_.AnyHas(own.degrees)) {
    Buffer<uint8_t> degrees(own.degrees.Downloaded(stream_));
    degrees = shards_.Assembled(degrees, {0, count}, ForWhom::kAllRanks);
    gaussians_.degrees.Upload(degrees, stream_);
    stream_.Wait();
  }
  extent_ = extent;
}

void AllGaussians::ShareOut(Gaussians& own, DensityStatistics& own_statistics) {
  const RowShare& share = shards_.share();
  const size_t count = gaussians_.size(), n = share.CountOf(count);
  for (int a = 0; a < kAttributeCount; ++a)
    if (a != kColorRest) own.values[a].Refill(n * size_t(own.width(a)), stream_);
  own.smoothing.Refill(gaussians_.smoothing.empty() ? 0 : n, stream_);
  Refill(own_statistics, n, stream_);
  shards_.TakeOwn(
      RowsOf(gaussians_, statistics_, false), RowsOf(own, own_statistics, false), count, stream_);
  own.degrees.Refill(gaussians_.degrees.empty() ? 0 : n, stream_);
  if (!own.degrees.empty()) {
    std::vector<uint32_t> rows(n);
    for (size_t place = 0; place < n; ++place) rows[place] = uint32_t(share.RowAt(place));
    Buffer<uint32_t> source;
    source.Upload(rows, stream_);
    ForEach(n,
            stream_,
            GatherRow<uint8_t>{
                std::as_const(gaussians_.degrees).view(), source, 1, n, own.degrees.view()});
    stream_.Wait();
  }
}

void AllGaussians::ForgetBands() {
  gaussians_.degree = 0;
  gaussians_.values[kColorRest] = {};
  extent_ = std::min(extent_, Extent::kGeometry);
}

void AllGaussians::Release() {
  gaussians_ = {};
  statistics_ = {};
  extent_ = Extent::kOwn;
}

}  // namespace cosplat
