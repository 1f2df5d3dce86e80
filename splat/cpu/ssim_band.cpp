#include "splat/cpu/ssim_band.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/cpu/ssim_band.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "splat/math/ssim.h"

COSPLAT_MATH_BEGIN

constexpr int kTaps = 2 * kSsimRadius + 1;
constexpr float kSsimSigma = 1.5f;

struct Window {
  float w[kTaps];
  Window() {
    float sum = 0;
    for (int k = 0; k < kTaps; ++k)
      sum += w[k] =
          std::exp(-float((k - kSsimRadius) * (k - kSsimRadius)) / (2 * kSsimSigma * kSsimSigma));
    for (float& v : w) v /= sum;
  }
};

// out[i] = sum_k w[k] padded[i + k]: plain loops, vectorised by the compiler for this target.
void ConvolveRow(const Window& window,
                 const float* __restrict padded,
                 int n,
                 float* __restrict out) {
  for (int i = 0; i < n; ++i) {
    float sum = 0;
    for (int k = 0; k < kTaps; ++k) sum += window.w[k] * padded[i + k];
    out[i] = sum;
  }
}

// The same down a column of rows that are `stride` apart.
void ConvolveColumn(const Window& window,
                    const float* __restrict rows,
                    size_t stride,
                    int n,
                    float* __restrict out) {
  for (int i = 0; i < n; ++i) {
    float sum = 0;
    for (int k = 0; k < kTaps; ++k) sum += window.w[k] * rows[i + k * stride];
    out[i] = sum;
  }
}

// Horizontally convolved rows [row_begin - R, row_end + R) of `planes` quantities; make_row fills
// the padded rows of one image row. Rows beyond the image are zero.
template <int kPlanes, class MakeRow>
void ConvolveRows(const SsimBand& band,
                  const Window& window,
                  const MakeRow& make_row,
                  float* padded,
                  float* out) {
  const int w = band.width;
  const size_t padded_width = w + 2 * kSsimRadius;
  std::fill(padded, padded + kPlanes * padded_width, 0.0f);
  float* row_out = out;
  for (int y = band.row_begin - kSsimRadius; y < band.row_end + kSsimRadius; ++y) {
    if (y < 0 || y >= band.height) {
      std::fill(row_out, row_out + size_t(kPlanes) * w, 0.0f);
    } else {
      make_row(y, padded + kSsimRadius, padded_width);
      for (int p = 0; p < kPlanes; ++p)
        ConvolveRow(window, padded + p * padded_width, w, row_out + size_t(p) * w);
    }
    row_out += size_t(kPlanes) * w;
  }
}

struct MomentRows {
  const SsimBand& band;
  void operator()(int row, float* __restrict out, size_t stride) const {
    const float* __restrict x = band.x + size_t(row) * band.width;
    const float* __restrict y = band.y + size_t(row) * band.width;
    for (int i = 0; i < band.width; ++i) {
      out[i] = x[i];
      out[stride + i] = y[i];
      out[2 * stride + i] = x[i] * x[i];
      out[3 * stride + i] = y[i] * y[i];
      out[4 * stride + i] = x[i] * y[i];
    }
  }
};

struct PartialRows {
  const SsimBand& band;
  void operator()(int row, float* __restrict out, size_t stride) const {
    const size_t from = size_t(row) * band.width;
    for (int i = 0; i < band.width; ++i) {
      out[i] = band.partial_x[from + i];
      out[stride + i] = band.partial_xx[from + i];
      out[2 * stride + i] = band.partial_xy[from + i];
    }
  }
};

double ForwardBand(const SsimBand& band, float* scratch) {
  const Window window;
  const int w = band.width;
  float* columns = scratch;
  float* padded = columns + 5 * size_t(w);
  float* rows = padded + 5 * size_t(w + 2 * kSsimRadius);
  ConvolveRows<5>(band, window, MomentRows{band}, padded, rows);
  double sum = 0;
  for (int y = band.row_begin; y < band.row_end; ++y) {
    const float* first = rows + size_t(y - band.row_begin) * 5 * w;
    for (int p = 0; p < 5; ++p)
      ConvolveColumn(window, first + size_t(p) * w, 5 * size_t(w), w, columns + size_t(p) * w);
    float* __restrict ssim = padded;
    for (int i = 0; i < w; ++i) {
      const SsimMoments<float> m{
          columns[i], columns[w + i], columns[2 * w + i], columns[3 * w + i], columns[4 * w + i]};
      ssim[i] = Ssim(m);
    }
    for (int i = 0; i < w; ++i) sum += ssim[i];
    if (!band.partial_x) continue;
    const size_t to = size_t(y) * w;
    for (int i = 0; i < w; ++i) {
      const SsimMoments<float> m{
          columns[i], columns[w + i], columns[2 * w + i], columns[3 * w + i], columns[4 * w + i]};
      const SsimPartials<float> d = SsimVjp(m);
      band.partial_x[to + i] = d.x;
      band.partial_xx[to + i] = d.xx;
      band.partial_xy[to + i] = d.xy;
    }
  }
  return sum;
}

// The window is symmetric, so the derivative of the windowed means is the same convolution.
void BackwardBand(const SsimBand& band, float factor, float* scratch, float* d_x) {
  const Window window;
  const int w = band.width;
  float* columns = scratch;
  float* padded = columns + 5 * size_t(w);
  float* rows = padded + 5 * size_t(w + 2 * kSsimRadius);
  ConvolveRows<3>(band, window, PartialRows{band}, padded, rows);
  for (int y = band.row_begin; y < band.row_end; ++y) {
    const float* first = rows + size_t(y - band.row_begin) * 3 * w;
    for (int p = 0; p < 3; ++p)
      ConvolveColumn(window, first + size_t(p) * w, 3 * size_t(w), w, columns + size_t(p) * w);
    const size_t at = size_t(y) * w;
    for (int i = 0; i < w; ++i)
      d_x[at + i] += factor * (columns[i] + 2 * band.x[at + i] * columns[w + i] +
                               band.y[at + i] * columns[2 * w + i]);
  }
}

size_t ScratchSize(int width, int rows) {
  return 5 * (size_t(width) + (width + 2 * kSsimRadius) + size_t(rows + 2 * kSsimRadius) * width);
}

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(ForwardBand);
HWY_EXPORT(BackwardBand);
}  // namespace math

size_t SsimScratch(int width, int rows) { return math::HWY_NAMESPACE::ScratchSize(width, rows); }
double SsimForward(const SsimBand& band, float* scratch) {
  using namespace math;
  return HWY_DYNAMIC_DISPATCH(ForwardBand)(band, scratch);
}
void SsimBackward(const SsimBand& band, float factor, float* scratch, float* d_x) {
  using namespace math;
  HWY_DYNAMIC_DISPATCH(BackwardBand)(band, factor, scratch, d_x);
}

}  // namespace cosplat
#endif
