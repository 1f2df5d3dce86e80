#include "avatar/voice/mel_features.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <unsupported/Eigen/FFT>

namespace cosplat {
namespace {

// Those of make_voice_net.py.
constexpr size_t kTransform = 512, kBins = kTransform / 2 + 1;
constexpr double kLowest = 60, kHighest = 7600;  // Hz
constexpr double kFloor = 1e-8;                  // power
constexpr int kMeanFrames = 300, kFirstFrames = 30;
constexpr float kSpeechBelowPeak = 4, kPeakDecay = 0.005f, kFirstPeak = -2;  // nats
constexpr float kLeast = -8, kMost = 6, kScale = 3;

double Mel(double hertz) { return 1127 * std::log1p(hertz / 700); }

// [kMelBands, kBins]: triangles of equal width in mel, of height 1.
Eigen::MatrixXd MelFilters(double warp) {
  std::array<double, kMelBands + 2> edges;
  for (size_t i = 0; i < edges.size(); ++i) {
    const double mel =
        Mel(kLowest) + (Mel(kHighest) - Mel(kLowest)) * double(i) / double(kMelBands + 1);
    edges[i] = warp * 700 * std::expm1(mel / 1127);
  }
  Eigen::MatrixXd filters{Eigen::Index(kMelBands), Eigen::Index(kBins)};
  for (size_t band = 0; band < kMelBands; ++band)
    for (size_t bin = 0; bin < kBins; ++bin) {
      const double hertz = double(bin) * kSoundRate / double(kTransform);
      const double rise = (hertz - edges[band]) / (edges[band + 1] - edges[band]);
      const double fall = (edges[band + 2] - hertz) / (edges[band + 2] - edges[band + 1]);
      filters(Eigen::Index(band), Eigen::Index(bin)) = std::max(0.0, std::min(rise, fall));
    }
  return filters;
}

float MeanOf(const MelBands& bands) {
  return std::accumulate(bands.begin(), bands.end(), 0.0f) / float(kMelBands);
}

}  // namespace

struct MelFeatures::Spectrum {
  Eigen::MatrixXd filters;
  std::array<double, kSpeechWindow> hann;
  Eigen::FFT<double> fft;
  std::vector<double> samples = std::vector<double>(kTransform);
  std::vector<std::complex<double>> bins;
  Eigen::VectorXd power{Eigen::Index(kBins)};

  explicit Spectrum(double warp) : filters(MelFilters(warp)) {
    fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
    for (size_t i = 0; i < hann.size(); ++i)
      hann[i] = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (double(i) + 0.5) / kSpeechWindow);
  }

  MelBands LogPower(const float* window) {
    for (size_t i = 0; i < kSpeechWindow; ++i) samples[i] = hann[i] * double(window[i]);
    fft.fwd(bins, samples);
    for (size_t i = 0; i < kBins; ++i) power[Eigen::Index(i)] = std::norm(bins[i]);
    const Eigen::VectorXd bands = filters * power;
    MelBands log_power;
    for (size_t i = 0; i < kMelBands; ++i)
      log_power[i] = float(std::log(bands[Eigen::Index(i)] + kFloor));
    return log_power;
  }
};

MelFeatures::MelFeatures(const MelBands& mean, double warp)
    : spectrum_(std::make_unique<Spectrum>(warp)),
      mean_(mean),
      frames_in_mean_(kFirstFrames),
      peak_(kFirstPeak) {}
MelFeatures::~MelFeatures() = default;
MelFeatures::MelFeatures(MelFeatures&& other) noexcept = default;

SpeechFrame MelFeatures::Normalised(const MelBands& log_power) {
  const float level = MeanOf(log_power);
  peak_ = std::max(level, peak_ - kPeakDecay);
  if (level > peak_ - kSpeechBelowPeak) {
    frames_in_mean_ = std::min(frames_in_mean_ + 1, kMeanFrames);
    for (size_t i = 0; i < kMelBands; ++i)
      mean_[i] += (log_power[i] - mean_[i]) / float(frames_in_mean_);
  }
  SpeechFrame frame;
  for (size_t i = 0; i < kMelBands; ++i)
    frame.mel[i] = std::clamp(log_power[i] - mean_[i], kLeast, kMost) / kScale;
  frame.loudness = level - MeanOf(mean_);
  return frame;
}

void MelFeatures::Push(std::span<const float> samples, std::vector<SpeechFrame>& frames) {
  for (const float x : samples)
    pending_.push_back(std::isfinite(x) ? std::clamp(x, -1.0f, 1.0f) : 0.0f);
  size_t begin = 0;
  for (; begin + kSpeechWindow <= pending_.size(); begin += kSpeechHop)
    frames.push_back(Normalised(spectrum_->LogPower(&pending_[begin])));
  pending_.erase(pending_.begin(), pending_.begin() + std::ptrdiff_t(begin));
}

}  // namespace cosplat
