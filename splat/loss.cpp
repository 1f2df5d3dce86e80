#include "splat/loss.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "splat/cpu/ssim_band.h"

namespace cosplat {
namespace {

// Fixed, so that sums do not depend on the number of threads.
constexpr int kBandRows = 32;

int BandCount(int height) { return (height + kBandRows - 1) / kBandRows; }

// Calls f(channel, band, scratch) for all of them, in parallel.
template <class F>
void ForBands(int width, int height, const F& f) {
  const int bands = BandCount(height);
  tbb::parallel_for(0, 3 * bands, [&](int job) {
    thread_local Buffer<float> scratch;
    scratch.resize(SsimScratch(width, kBandRows));
    f(job / bands, job % bands, scratch.data());
  });
}

SsimBand BandOf(int width, int height, int channel, int band, const float* x, const float* y) {
  SsimBand b;
  b.width = width;
  b.height = height;
  b.row_begin = band * kBandRows;
  b.row_end = std::min(b.row_begin + kBandRows, height);
  const size_t plane = size_t(width) * height;
  b.x = x + channel * plane;
  b.y = y + channel * plane;
  return b;
}

}  // namespace

void CompositeTarget(const Image8& image,
                     const std::array<float, 3>& background,
                     Buffer<float>& planar) {
  const size_t plane = image.pixels();
  planar.resize(3 * plane);
  const int n = image.channels;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, plane, 16384), [&](const auto& range) {
    for (size_t i = range.begin(); i < range.end(); ++i) {
      const uint8_t* p = image.data.data() + i * n;
      const float alpha = n == 4 ? p[3] / 255.0f : 1.0f;
      for (int c = 0; c < 3; ++c)
        planar[c * plane + i] = p[n == 1 ? 0 : c] / 255.0f * alpha + background[c] * (1 - alpha);
    }
  });
}

double PhotometricLoss::Evaluate(const LossWeights& weights,
                                 int width,
                                 int height,
                                 View<const float> rendered,
                                 View<const float> target,
                                 Buffer<float>& d_rendered) {
  const size_t plane = size_t(width) * height;
  const float inv = 1.0f / float(3 * plane);
  d_rendered.resize(3 * plane);
  const bool with_ssim = weights.dssim != 0;
  if (with_ssim)
    for (Buffer<float>* b : {&partial_x_, &partial_xx_, &partial_xy_}) b->resize(3 * plane);
  const auto band_of = [&](int channel, int band) {
    SsimBand b = BandOf(width, height, channel, band, rendered.data, target.data);
    if (!with_ssim) return b;
    b.partial_x = partial_x_.data() + channel * plane;
    b.partial_xx = partial_xx_.data() + channel * plane;
    b.partial_xy = partial_xy_.data() + channel * plane;
    return b;
  };
  const int bands = BandCount(height);
  std::vector<double> ssim(3 * bands), pointwise(3 * bands);
  if (with_ssim)
    ForBands(width, height, [&](int channel, int band, float* scratch) {
      ssim[channel * bands + band] = SsimForward(band_of(channel, band), scratch);
    });
  ForBands(width, height, [&](int channel, int band, float* scratch) {
    const SsimBand b = band_of(channel, band);
    float* d = d_rendered.data() + channel * plane;
    double sum = 0;
    for (size_t i = size_t(b.row_begin) * width; i < size_t(b.row_end) * width; ++i) {
      const float e = b.x[i] - b.y[i];
      sum += weights.l1 * std::fabs(e) + weights.mse * e * e;
      const float sign = e > 0 ? 1.0f : (e < 0 ? -1.0f : 0.0f);
      d[i] = inv * (weights.l1 * sign + 2 * weights.mse * e);
    }
    pointwise[channel * bands + band] = sum;
    if (with_ssim) SsimBackward(b, -weights.dssim * inv, scratch, d);
  });
  double total_ssim = 0, total = 0;
  for (const double s : ssim) total_ssim += s;
  for (const double p : pointwise) total += p;
  return total * inv + (with_ssim ? weights.dssim * (1 - total_ssim * inv) : 0);
}

double MeanSsim(int width, int height, View<const float> a, View<const float> b) {
  const int bands = BandCount(height);
  std::vector<double> sums(3 * bands);
  ForBands(width, height, [&](int channel, int band, float* scratch) {
    sums[channel * bands + band] =
        SsimForward(BandOf(width, height, channel, band, a.data, b.data), scratch);
  });
  double total = 0;
  for (const double s : sums) total += s;
  return total / (3.0 * width * height);
}

double Psnr(View<const float> a, View<const float> b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += double(a[i] - b[i]) * (a[i] - b[i]);
  const double mse = sum / double(a.size());
  return mse > 1e-10 ? -10 * std::log10(mse) : 100.0;
}

}  // namespace cosplat
