#include "splat/train/loss/loss.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "splat/math/photometric.h"
#include "splat/math/ssim.h"
#include "splat/train/loss/cpu/ssim_band.h"

namespace cosplat {
namespace {

// Fixed, so that sums do not depend on the number of threads. A band also processes up to ten rows
// of each neighbour, so much smaller bands would cost more; an image of 1080 rows makes 27 jobs.
constexpr int kBandRows = 120;
constexpr int kRowsTogether = math::kSsimRadius;  // a group of splat/train/loss/cpu/ssim_window.h

struct Bands {
  int count, rows;  // rows of each but the last
};
Bands BandsOf(int height) {
  const int wanted = std::max(1, (height + kBandRows / 2) / kBandRows);
  const int groups = (height + wanted * kRowsTogether - 1) / (wanted * kRowsTogether);
  const int rows = groups * kRowsTogether;
  return {(height + rows - 1) / rows, rows};
}

// Rendered and target image of each channel, for all rows.
using Channels = std::array<SsimBand, 3>;

size_t PixelsOf(const TargetView& target) { return size_t(target.width) * target.height; }
TargetView ViewOf(const Image8& image) {
  return {image.width, image.height, image.channels, image.data.data()};
}

Channels ChannelsOf(const float* rendered,
                    const TargetView& target,
                    const std::array<float, 3>& background) {
  Channels channels;
  const int n = target.channels;
  for (int c = 0; c < 3; ++c) {
    channels[c].width = target.width;
    channels[c].height = target.height;
    channels[c].x = rendered + c * PixelsOf(target);
    channels[c].target = target.bytes + (n == 1 ? 0 : c);
    channels[c].alpha = n == 4 ? target.bytes + 3 : nullptr;
    channels[c].target_channels = n;
    channels[c].background = background[c];
  }
  return channels;
}

// Calls f(band, channel, job, scratch) for every channel and band, in parallel.
template <class F>
void ForBands(const Channels& channels, const F& f) {
  const Bands bands = BandsOf(channels[0].height);
  tbb::parallel_for(0, 3 * bands.count, [&](int job) {
    thread_local Buffer<float> scratch;
    scratch.resize(std::max(scratch.size(), SsimScratch(channels[0].width)));
    const int channel = job % 3;  // the channels of a band read the same bytes
    SsimBand band = channels[channel];
    band.row_begin = job / 3 * bands.rows;
    band.row_end = std::min(band.row_begin + bands.rows, band.height);
    f(band, channel, job, scratch.data());
  });
}

}  // namespace

double PhotometricLoss::Evaluate(const LossWeights& weights,
                                 View<const float> rendered,
                                 const Image8& target,
                                 const std::array<float, 3>& background,
                                 Buffer<float>& d_rendered) {
  Evaluate(weights, rendered, ViewOf(target), background, d_rendered, HostStream());
  return value_;
}

void PhotometricLoss::Evaluate(const LossWeights& weights,
                               View<const float> rendered,
                               const TargetView& target,
                               const std::array<float, 3>& background,
                               Buffer<float>& d_rendered,
                               Stream&) {
  const Channels channels = ChannelsOf(rendered.data, target, background);
  const size_t plane = PixelsOf(target);
  const float inv = 1.0f / float(3 * plane);
  d_rendered.resize(3 * plane);
  const int jobs = 3 * BandsOf(target.height).count;
  sums_.resize(2 * jobs);
  const ValueWeights per_value{weights.l1 * inv, weights.mse * inv, weights.dssim * inv};
  ForBands(channels, [&](const SsimBand& band, int channel, int job, float* scratch) {
    const LossSums of_band =
        EvaluateBand(band, per_value, scratch, d_rendered.data() + channel * plane);
    sums_[2 * job] = of_band.pointwise;
    sums_[2 * job + 1] = of_band.ssim;
  });
  double pointwise = 0, ssim = 0;
  for (int job = 0; job < jobs; ++job) {
    pointwise += sums_[2 * job];
    ssim += sums_[2 * job + 1];
  }
  value_ = pointwise + (weights.dssim != 0 ? weights.dssim * (1 - ssim / double(3 * plane)) : 0);
}

double MeanSsim(View<const float> rendered,
                const Image8& target,
                const std::array<float, 3>& background) {
  const Channels channels = ChannelsOf(rendered.data, ViewOf(target), background);
  std::vector<double> sums(3 * BandsOf(target.height).count);
  ForBands(channels, [&](const SsimBand& band, int, int job, float* scratch) {
    sums[job] = SsimOfBand(band, scratch);
  });
  double total = 0;
  for (const double s : sums) total += s;
  return total / double(3 * target.pixels());
}

void CompositeTarget(const Image8& image,
                     const std::array<float, 3>& background,
                     Buffer<float>& planar) {
  const size_t plane = image.pixels();
  planar.resize(3 * plane);
  const int n = image.channels;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, plane, 16384), [&](const auto& range) {
    for (size_t i = range.begin(); i < range.end(); ++i) {
      const uint8_t* p = image.data.data() + i * n;
      for (int c = 0; c < 3; ++c) {
        const uint8_t value = p[n == 1 ? 0 : c];
        planar[c * plane + i] =
            n == 4 ? math::Over(value, p[3], background[c]) : math::FromByte(value);
      }
    }
  });
}

double Psnr(View<const float> a, View<const float> b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += double(a[i] - b[i]) * (a[i] - b[i]);
  return PsnrOf(sum / double(a.size()));
}

double PsnrOf(double mean_squared_difference) {
  return mean_squared_difference > 1e-10 ? -10 * std::log10(mean_squared_difference) : 100.0;
}

}  // namespace cosplat
