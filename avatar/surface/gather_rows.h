// Gathers rows of arrays into SIMD packs, one arbitrary row per lane (for consecutive rows see
// splat/render/cpu/pack_rows.h), and runs kernels on packs. Re-included per Highway target.
#if defined(COSPLAT_AVATAR_GATHER_ROWS_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_AVATAR_GATHER_ROWS_H_
#undef COSPLAT_AVATAR_GATHER_ROWS_H_
#else
#define COSPLAT_AVATAR_GATHER_ROWS_H_
#endif

#include <algorithm>

#include "avatar/surface/kernels/gather.h"
#include "splat/render/cpu/pack_rows.h"

COSPLAT_MATH_BEGIN

template <>
inline constexpr size_t kLaneCount<Pack> = kLanes;

HWY_INLINE Pack FromLanes(const PerLane<float, Pack>& lanes) { return LoadPack(lanes.lane); }
HWY_INLINE void ToLanes(const Pack& x, PerLane<float, Pack>& lanes) { StorePack(x, lanes.lane); }

#if HWY_TARGET != HWY_SCALAR
// Like LoadBlocks, for the rows rows[0], rows[4], ...
template <class D>
HWY_INLINE hn::Vec<D> GatherBlocks(D d, const float* array, size_t width, const int32_t* rows) {
  if constexpr (hn::MaxLanes(D()) == 4) {
    return hn::LoadU(d, array + width * size_t(rows[0]));
  } else {
    const hn::Half<D> half;
    return hn::Combine(d,
                       GatherBlocks(half, array, width, rows + hn::MaxLanes(half)),
                       GatherBlocks(half, array, width, rows));
  }
}
#endif

// The overload of avatar/surface/kernels/gather.h for packs.
template <int kUsed>
HWY_INLINE void GatherRows(const float* array,
                           size_t width,
                           const LaneRows<Pack>& rows,
                           Pack* out) {
#if HWY_TARGET != HWY_SCALAR
  for (int k = 0; k < kUsed; k += 4) {
    const int from = FourFrom<kUsed>(k);
    for (int r = 0; r < 4; ++r)
      out[from + r] = Pack(GatherBlocks(Lanes(), array + from, width, rows.lane + r));
    Transpose4x4(Lanes(), out[from].v, out[from + 1].v, out[from + 2].v, out[from + 3].v);
  }
#else
  for (int k = 0; k < kUsed; ++k) out[k] = Pack(array[width * size_t(rows[0]) + k]);
#endif
}

// Runs a kernel on the rows [begin, end). The kernel is passed by value, so that its stores cannot
// alias its own pointers, which then stay in registers (saves a fifth of the time of binding).
template <class Kernel>
HWY_INLINE void RunRange(const Kernel kernel, size_t begin, size_t end) {
  for (size_t i = begin; i < end; i += kLanes)
    Run<Pack>(kernel, Rows{i, std::min(kLanes, end - i)});
}

COSPLAT_MATH_END
#endif
