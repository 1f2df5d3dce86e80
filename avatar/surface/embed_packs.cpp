#include "avatar/surface/embed_packs.h"

#include <algorithm>
#include <cmath>

#include "avatar/surface/parallel_for.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "avatar/surface/embed_packs.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "avatar/surface/gather_rows.h"
#include "avatar/surface/kernels/embed.h"

COSPLAT_MATH_BEGIN

void EmbedRange(const EmbedJob& job, const PosedArrays<float>& out, size_t begin, size_t end) {
  RunRange(EmbedKernel{job, out}, begin, end);
}
void EmbedVjpRange(const EmbedJob& job,
                   const PosedArrays<const float>& d_posed,
                   const EmbedAdjoints& out,
                   size_t begin,
                   size_t end) {
  RunRange(EmbedVjpKernel{job, d_posed, out}, begin, end);
}

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(EmbedRange);
HWY_EXPORT(EmbedVjpRange);
}  // namespace math

namespace {
constexpr size_t kGrain = 512;  // a multiple of every pack's lanes
}  // namespace

void LaunchEmbed(const EmbedJob& job, const PosedArrays<float>& out) {
  using namespace math;
  ParallelForRanges(job.count, kGrain, [&](size_t begin, size_t end) {
    HWY_DYNAMIC_DISPATCH(EmbedRange)(job, out, begin, end);
  });
}

void LaunchEmbedVjp(const EmbedJob& job,
                    const PosedArrays<const float>& d_posed,
                    const EmbedAdjoints& out) {
  using namespace math;
  ParallelForRanges(job.count, kGrain, [&](size_t begin, size_t end) {
    HWY_DYNAMIC_DISPATCH(EmbedVjpRange)(job, d_posed, out, begin, end);
  });
}

}  // namespace cosplat
#endif
