#include "splat/train/loss/cpu/ssim_band.h"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/train/loss/cpu/ssim_band.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "splat/math/photometric.h"
#include "splat/train/loss/cpu/ssim_window.h"

COSPLAT_MATH_BEGIN

constexpr int kMoments = 4, kPartials = 3;
// Zero padding on both sides of a row; at least the window's radius.
constexpr size_t kMargin = kLineFloats;

// Sum and difference of a row of x and of the target image. Plain loops, which the compiler
// vectorises for this instruction set.
template <int kChannels>
void ReadRow(const SsimBand& band, size_t from, float* HWY_RESTRICT u, float* HWY_RESTRICT v) {
  const float* HWY_RESTRICT x = band.x + from;
  const uint8_t* HWY_RESTRICT y = band.target + from * kChannels;
  const int width = band.width;
  if constexpr (kChannels == 4) {
    const uint8_t* HWY_RESTRICT alpha = band.alpha + from * kChannels;
    const float background = band.background;
    for (int i = 0; i < width; ++i) u[i] = Over(y[4 * i], alpha[4 * i], background);
  } else {
    for (int i = 0; i < width; ++i) u[i] = FromByte(y[kChannels * i]);
  }
  // Not in the same loop: for equal values, x - y is zero only if y has been rounded before.
  for (int i = 0; i < width; ++i) {
    const float target = u[i];
    u[i] = x[i] + target;
    v[i] = x[i] - target;
  }
}

// Stores the first n lanes.
HWY_INLINE void StoreFirst(const Pack& a, float* p, int n) {
  if (n >= int(kLanes)) return hn::StoreU(a.v, Lanes(), p);
  alignas(64) float lanes[kLanes];
  StorePack(a, lanes);
  std::memcpy(p, lanes, n * sizeof(float));
}

// Three stages, each a group of rows behind the previous one. Enter reads rows and applies the
// window to their moments along the rows. Compare applies it down the columns, computes SSIM and
// its partial derivatives, and applies the window to these along the rows. Leave applies it down
// the columns and writes the gradient. Groups are counted from the band's first row; a band
// recomputes what it needs of its neighbours.
class BandLoop {
 public:
  static size_t Scratch(int width) {
    return kPaddedRows * StrideOf(width) + RowRing<kMoments>::Size(width) +
           RowRing<kPartials>::Size(width);
  }

  // d_x: null to compute only the value.
  BandLoop(const SsimBand& band, const ValueWeights& weights, float* scratch, float* d_x)
      : band_(band),
        weights_(weights),
        d_x_(d_x),
        stride_(StrideOf(band.width)),
        rows_(scratch),
        moments_(scratch + kPaddedRows * stride_),
        partials_(scratch + kPaddedRows * stride_ + RowRing<kMoments>::Size(band.width)) {
    for (size_t r = 0; r < kPaddedRows; ++r) {
      float* row = rows_ + r * stride_;
      std::fill(row, row + kMargin, 0.0f);
      std::fill(row + kMargin + band.width, row + stride_, 0.0f);
    }
  }

  LossSums Run() {
    const int lead = d_x_ ? 2 : 1, groups = GroupCount();
    for (int g = -lead; g < groups + lead; ++g) {
      Enter(g);
      if (g - 1 > -lead) Compare(g - 1);
      if (d_x_ && g >= 2) Leave<true>(g - 2);
    }
    return sums_;
  }

  LossSums RunWithoutSsim() {
    for (int g = 0; g < GroupCount(); ++g) {
      for (int j = 0; j < kGroup; ++j)
        if (InImage(RowAt(g, j))) Read(g, j);
      Leave<false>(g);
    }
    return sums_;
  }

 private:
  // Three groups each of u and v, and the partials of one group.
  static constexpr size_t kPaddedRows = 2 * kRingRows + kGroup * kPartials;
  // An odd number of cache lines, so that the rows of a column are in different sets of the cache.
  static size_t StrideOf(int width) {
    return kLineFloats * ((2 * kMargin + width + kLineFloats - 1) / kLineFloats | 1);
  }

  int GroupCount() const { return (band_.row_end - band_.row_begin + kGroup - 1) / kGroup; }
  int RowAt(int group, int j) const { return band_.row_begin + group * kGroup + j; }
  bool InImage(int row) const { return row >= 0 && row < band_.height; }
  float* PaddedRow(size_t r) const { return rows_ + r * stride_ + kMargin; }
  float* SumRow(int group, int j) const { return PaddedRow((group + 3) % 3 * kGroup + j); }
  float* DifferenceRow(int group, int j) const { return SumRow(group, j) + kRingRows * stride_; }
  float* PartialRow(int j, int plane) const {
    return PaddedRow(2 * kRingRows + j * kPartials + plane);
  }

  void Read(int group, int j) {
    const int n = band_.target_channels;
    const auto read = n == 1 ? ReadRow<1> : n == 3 ? ReadRow<3> : ReadRow<4>;
    read(band_, size_t(RowAt(group, j)) * band_.width, SumRow(group, j), DifferenceRow(group, j));
  }

  void Enter(int group) {
    for (int j = 0; j < kGroup; ++j) {
      if (!InImage(RowAt(group, j))) {
        moments_.ClearRow(group, j, band_.width);
        continue;
      }
      Read(group, j);
      MomentsAlong(SumRow(group, j), DifferenceRow(group, j), moments_.Row(group, j));
    }
  }

  void MomentsAlong(const float* HWY_RESTRICT u,
                    const float* HWY_RESTRICT v,
                    float* HWY_RESTRICT out) {
    const Window window = window_;
    for (int i = 0; i < band_.width; i += int(kLanes)) {
      Pack taps[kTaps];
      LoadTaps(u + i, taps);
      StorePack(Weigh(window, taps), out);
      StorePack(WeighSquares(window, taps), out + 2 * kLanes);
      LoadTaps(v + i, taps);
      StorePack(Weigh(window, taps), out + kLanes);
      StorePack(WeighSquares(window, taps), out + 3 * kLanes);
      out += RowRing<kMoments>::kPackFloats;
    }
  }

  void Compare(int group) {
    if (InImage(RowAt(group, 0)) || InImage(RowAt(group, kGroup - 1))) SumSsim(group);
    if (!d_x_) return;
    for (int j = 0; j < kGroup; ++j) {
      if (InImage(RowAt(group, j)))
        PartialsAlong(group, j);
      else
        partials_.ClearRow(group, j, band_.width);
    }
  }

  // Adds the SSIM of the band's rows to the sum and fills the partial rows.
  void SumSsim(int group) {
    ColumnWindow<kMoments> columns(window_, moments_, group);
    const Pack zero(0.0f);
    Pack sums[kGroup] = {zero, zero, zero, zero, zero};
    for (int i = 0; i < band_.width; i += int(kLanes)) {
      Pack m[kMoments][kGroup];
      columns.Next(m);
      const PackMask inside = Ramp(float(i)) < Pack(float(band_.width));
      for (int j = 0; j < kGroup; ++j) {
        const SsimMoments<Pack> moments{m[0][j], m[1][j], m[2][j], m[3][j]};
        sums[j] += Select(inside, Ssim(moments), zero);
        if (!d_x_) continue;
        const SsimPartials<Pack> d = SsimVjp(moments);
        float* out = PartialRow(j, 0) + i;
        StorePack(Select(inside, d.mean, zero), out);
        StorePack(Select(inside, d.uu, zero), out + stride_);
        StorePack(Select(inside, d.vv, zero), out + 2 * stride_);
      }
    }
    for (int j = 0; j < kGroup; ++j)
      if (RowAt(group, j) >= band_.row_begin && RowAt(group, j) < band_.row_end)
        sums_.ssim += Sum(sums[j]);
  }

  void PartialsAlong(int group, int j) {
    const Window window = window_;
    for (int p = 0; p < kPartials; ++p) {
      const float* HWY_RESTRICT row = PartialRow(j, p);
      float* HWY_RESTRICT out = partials_.Row(group, j) + p * kLanes;
      for (int i = 0; i < band_.width; i += int(kLanes)) {
        Pack taps[kTaps];
        LoadTaps(row + i, taps);
        StorePack(Weigh(window, taps), out);
        out += RowRing<kPartials>::kPackFloats;
      }
    }
  }

  // Writes the band's rows of the gradient. The window is symmetric, so the derivative of the
  // windowed means is the same window over the partials. Not inlined: the loop needs all registers.
  template <bool kWithSsim>
  HWY_NOINLINE void Leave(int group) {
    ColumnWindow<kPartials> columns(window_, partials_, group);
    const Pack zero(0.0f), factor(-weights_.dssim), two(2.0f);
    Pack sums[kGroup] = {zero, zero, zero, zero, zero};
    const int rows = std::min(kGroup, band_.row_end - RowAt(group, 0));
    const Pack l1(weights_.l1), mse(weights_.mse), two_mse(2 * weights_.mse);
    const float *u_row = SumRow(group, 0), *v_row = DifferenceRow(group, 0);
    float* d_x = d_x_ + size_t(RowAt(group, 0)) * band_.width;
    for (int i = 0; i < band_.width; i += int(kLanes)) {
      Pack c[kPartials][kGroup];
      if constexpr (kWithSsim) columns.Next(c);
      for (int j = 0; j < rows; ++j) {
        const Pack v = LoadPack(v_row + j * stride_ + i);
        sums[j] += Pointwise(l1, mse, v);
        Pack d = PointwiseVjp(l1, two_mse, v);
        if constexpr (kWithSsim) {
          const Pack u = LoadPack(u_row + j * stride_ + i);
          d += factor * (c[0][j] + two * (u * c[1][j] + v * c[2][j]));
        }
        StoreFirst(d, d_x + size_t(j) * band_.width + i, band_.width - i);
      }
    }
    for (int j = 0; j < rows; ++j) sums_.pointwise += Sum(sums[j]);
  }

  const SsimBand& band_;
  const ValueWeights weights_;
  float* const d_x_;
  const size_t stride_;
  const Window window_;
  float* const rows_;  // [kPaddedRows, stride]: u, v, partials
  const RowRing<kMoments> moments_;
  const RowRing<kPartials> partials_;
  LossSums sums_;
};

LossSums Evaluate(const SsimBand& band, const ValueWeights& weights, float* scratch, float* d_x) {
  BandLoop loop(band, weights, scratch, d_x);
  return weights.dssim != 0 ? loop.Run() : loop.RunWithoutSsim();
}

double SumOfSsim(const SsimBand& band, float* scratch) {
  return BandLoop(band, {0, 0, 1}, scratch, nullptr).Run().ssim;
}

size_t ScratchSize(int width) { return BandLoop::Scratch(width); }

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(Evaluate);
HWY_EXPORT(SumOfSsim);
}  // namespace math

// Independent of the instruction set.
size_t SsimScratch(int width) { return math::HWY_NAMESPACE::ScratchSize(width); }

LossSums EvaluateBand(const SsimBand& band,
                      const ValueWeights& weights,
                      float* scratch,
                      float* d_x) {
  using namespace math;
  return HWY_DYNAMIC_DISPATCH(Evaluate)(band, weights, scratch, d_x);
}

double SsimOfBand(const SsimBand& band, float* scratch) {
  using namespace math;
  return HWY_DYNAMIC_DISPATCH(SumOfSsim)(band, scratch);
}

}  // namespace cosplat
#endif
