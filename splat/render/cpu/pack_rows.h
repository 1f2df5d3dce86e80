// Loads rows of arrays into SIMD packs and stores them back (splat/math/rows.h). Lane l of out[k]
// is element k of row l: a transposition, done in registers by 4x4 blocks.
#if defined(COSPLAT_SPLAT_CPU_PACK_ROWS_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_CPU_PACK_ROWS_H_
#undef COSPLAT_SPLAT_CPU_PACK_ROWS_H_
#else
#define COSPLAT_SPLAT_CPU_PACK_ROWS_H_
#endif

#include "splat/math/rows.h"
#include "splat/render/cpu/pack.h"

COSPLAT_MATH_BEGIN

#if HWY_TARGET != HWY_SCALAR
// Loads and stores four floats per 128-bit block; blocks are `stride` floats apart in memory.
template <class D>
HWY_INLINE hn::Vec<D> LoadBlocks(D d, const float* from, size_t stride) {
  if constexpr (hn::MaxLanes(D()) == 4) {
    return hn::LoadU(d, from);
  } else {
    const hn::Half<D> half;
    const float* upper = from + hn::MaxLanes(half) / 4 * stride;
    return hn::Combine(d, LoadBlocks(half, upper, stride), LoadBlocks(half, from, stride));
  }
}
template <class D>
HWY_INLINE void StoreBlocks(D d, hn::Vec<D> v, float* to, size_t stride) {
  if constexpr (hn::MaxLanes(D()) == 4) {
    hn::StoreU(v, d, to);
  } else {
    const hn::Half<D> half;
    StoreBlocks(half, hn::LowerHalf(half, v), to, stride);
    StoreBlocks(half, hn::UpperHalf(half, v), to + hn::MaxLanes(half) / 4 * stride, stride);
  }
}

// First element of the group of four that starts at element k; a partial last group is moved back
// to overlap the one before.
template <int kUsed>
constexpr int FourFrom(int k) {
  return k + 4 <= kUsed ? k : kUsed - 4;
}

// Exactly one row per lane; kUsed >= 4.
template <int kUsed>
HWY_INLINE void LoadByFours(const float* first, size_t width, Pack* out) {
  for (int k = 0; k < kUsed; k += 4) {
    const int from = FourFrom<kUsed>(k);
    for (int r = 0; r < 4; ++r)
      out[from + r] = Pack(LoadBlocks(Lanes(), first + r * width + from, 4 * width));
    Transpose4x4(Lanes(), out[from].v, out[from + 1].v, out[from + 2].v, out[from + 3].v);
  }
}
template <int kUsed>
HWY_INLINE void StoreByFours(const Pack* in, float* first, size_t width) {
  for (int k = 0; k < kUsed; k += 4) {
    const int from = FourFrom<kUsed>(k);
    Pack four[4] = {in[from], in[from + 1], in[from + 2], in[from + 3]};
    Transpose4x4(Lanes(), four[0].v, four[1].v, four[2].v, four[3].v);
    for (int r = 0; r < 4; ++r)
      StoreBlocks(Lanes(), four[r].v, first + r * width + from, 4 * width);
  }
}
#endif

template <int kUsed>
HWY_INLINE void LoadRows(const float* array, size_t width, const Rows& rows, Pack* out) {
  const float* first = array + width * rows.first;
#if HWY_TARGET != HWY_SCALAR
  if (rows.count == kLanes) {
    if constexpr (kUsed >= 4) return LoadByFours<kUsed>(first, width, out);
    if constexpr (kUsed == 3)
      if (width == 3) return hn::LoadInterleaved3(Lanes(), first, out[0].v, out[1].v, out[2].v);
  }
#endif
  alignas(64) float lane[kUsed][kLanes];
  for (size_t l = 0; l < kLanes; ++l)
    for (int k = 0; k < kUsed; ++k) lane[k][l] = first[width * (l < rows.count ? l : 0) + k];
  for (int k = 0; k < kUsed; ++k) out[k] = LoadPack(lane[k]);
}

template <int kUsed>
HWY_INLINE void StoreRows(const Pack* in, float* array, size_t width, const Rows& rows) {
  float* first = array + width * rows.first;
#if HWY_TARGET != HWY_SCALAR
  if (rows.count == kLanes) {
    if constexpr (kUsed >= 4) return StoreByFours<kUsed>(in, first, width);
    if constexpr (kUsed == 3)
      if (width == 3) return hn::StoreInterleaved3(in[0].v, in[1].v, in[2].v, Lanes(), first);
  }
#endif
  alignas(64) float lane[kUsed][kLanes];
  for (int k = 0; k < kUsed; ++k) StorePack(in[k], lane[k]);
  for (size_t l = 0; l < rows.count; ++l)
    for (int k = 0; k < kUsed; ++k) first[width * l + k] = lane[k][l];
}

COSPLAT_MATH_END
#endif
