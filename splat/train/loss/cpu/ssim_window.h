// The SSIM window on packs, along rows and down columns (splat/train/loss/cpu/ssim_band.cpp).
// Re-included once per Highway target.
//
// Rows are processed in groups of as many rows as the window's radius: a window over a group's rows
// spans that group and its two neighbours, so that only three groups have to be kept.
#if defined(COSPLAT_SPLAT_CPU_SSIM_WINDOW_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_CPU_SSIM_WINDOW_H_
#undef COSPLAT_SPLAT_CPU_SSIM_WINDOW_H_
#else
#define COSPLAT_SPLAT_CPU_SSIM_WINDOW_H_
#endif

#include "splat/math/ssim.h"
#include "splat/render/cpu/pack.h"

COSPLAT_MATH_BEGIN

constexpr int kTaps = 2 * kSsimRadius + 1;
constexpr int kGroup = kSsimRadius;  // rows
constexpr int kRingRows = 3 * kGroup;
constexpr size_t kLineFloats = 16;  // a 64-byte cache line; every pack lies within one
static_assert(kSsimRadius == 5 && kLineFloats % kLanes == 0);

struct Window {
  Pack w[kSsimRadius + 1];
  Window() {
    float weights[kSsimRadius + 1];
    SsimWindow(weights);
    for (int k = 0; k <= kSsimRadius; ++k) w[k] = Pack(weights[k]);
  }
};

// Loads the packs at row - 5, ..., row + 5; row is aligned. Five are loaded and the others are
// assembled by shifts within blocks of 16 bytes, since a load that straddles two cache lines costs
// as much as two.
HWY_INLINE void LoadTaps(const float* row, Pack* taps) {
  const Lanes d;
#if HWY_TARGET == HWY_SCALAR
  for (int k = 0; k < kTaps; ++k) taps[k] = Pack(hn::LoadU(d, row + k - kSsimRadius));
#else
  const auto a = hn::LoadU(d, row - 8), b = hn::LoadU(d, row - 4), c = hn::Load(d, row);
  const auto e = hn::LoadU(d, row + 4), f = hn::LoadU(d, row + 8);
  taps[0] = Pack(hn::CombineShiftRightLanes<3>(d, b, a));
  taps[1] = Pack(b);
  taps[2] = Pack(hn::CombineShiftRightLanes<1>(d, c, b));
  taps[3] = Pack(hn::CombineShiftRightLanes<2>(d, c, b));
  taps[4] = Pack(hn::CombineShiftRightLanes<3>(d, c, b));
  taps[5] = Pack(c);
  taps[6] = Pack(hn::CombineShiftRightLanes<1>(d, e, c));
  taps[7] = Pack(hn::CombineShiftRightLanes<2>(d, e, c));
  taps[8] = Pack(hn::CombineShiftRightLanes<3>(d, e, c));
  taps[9] = Pack(e);
  taps[10] = Pack(hn::CombineShiftRightLanes<1>(d, f, e));
#endif
}

// The windowed sum around taps[kSsimRadius].
HWY_INLINE Pack Weigh(const Window& window, const Pack* taps) {
  Pack sum = window.w[0] * taps[kSsimRadius];
#pragma GCC unroll 16
  for (int k = 1; k <= kSsimRadius; ++k)
    sum += window.w[k] * (taps[kSsimRadius - k] + taps[kSsimRadius + k]);
  return sum;
}
HWY_INLINE Pack WeighSquares(const Window& window, const Pack* taps) {
  Pack sum = window.w[0] * (taps[kSsimRadius] * taps[kSsimRadius]);
#pragma GCC unroll 16
  for (int k = 1; k <= kSsimRadius; ++k) {
    const Pack left = taps[kSsimRadius - k], right = taps[kSsimRadius + k];
    sum += window.w[k] * (left * left + right * right);
  }
  return sum;
}

// Ring buffer of three groups of rows with kPlanes quantities each. The layout keeps what one
// window down a column needs together and at constant offsets:
// [pack of columns][group][row][plane][lane].
template <int kPlanes>
class RowRing {
 public:
  static constexpr size_t kRowFloats = kPlanes * kLanes;
  static constexpr size_t kPackFloats = kRingRows * kRowFloats;
  // Independent of the instruction set.
  static size_t Size(int width) {
    return (size_t(width) + kLineFloats - 1) / kLineFloats * kLineFloats * kRingRows * kPlanes;
  }

  explicit RowRing(float* data) : data_(data) {}
  // Row j of a group, at the first pack of columns. Groups are numbered from -2.
  float* Row(int group, int j) const {
    return data_ + size_t((group + 3) % 3 * kGroup + j) * kRowFloats;
  }
  void ClearRow(int group, int j, int width) const {
    float* row = Row(group, j);
    for (int i = 0; i < width; i += int(kLanes), row += kPackFloats)
      for (size_t k = 0; k < kRowFloats; ++k) row[k] = 0;
  }

 private:
  float* data_;
};

// Applies the window down the columns, for each row of a group and each plane, one pack of columns
// at a time.
template <int kPlanes>
class ColumnWindow {
 public:
  ColumnWindow(const Window& window, const RowRing<kPlanes>& ring, int group)
      : window_(window),
        above_(ring.Row(group - 1, 0)),
        middle_(ring.Row(group, 0)),
        below_(ring.Row(group + 1, 0)) {}

  HWY_INLINE void Next(Pack (*out)[kGroup]) {
#pragma GCC unroll 16
    for (int p = 0; p < kPlanes; ++p) Column(p * kLanes, out[p]);
    at_ += RowRing<kPlanes>::kPackFloats;
  }

 private:
  HWY_INLINE void Column(size_t plane, Pack* out) const {
    constexpr size_t kRow = RowRing<kPlanes>::kRowFloats;
    Pack rows[kRingRows];
#pragma GCC unroll 16
    for (int j = 0; j < kGroup; ++j) {
      rows[j] = LoadPack(above_ + at_ + plane + j * kRow);
      rows[kGroup + j] = LoadPack(middle_ + at_ + plane + j * kRow);
      rows[2 * kGroup + j] = LoadPack(below_ + at_ + plane + j * kRow);
    }
#pragma GCC unroll 16
    for (int j = 0; j < kGroup; ++j) out[j] = Weigh(window_, rows + j);
  }

  const Window window_;
  const float *above_, *middle_, *below_;
  size_t at_ = 0;
};

COSPLAT_MATH_END
#endif
