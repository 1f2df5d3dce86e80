#include "splat/media/hdr.h"

#include <algorithm>
#include <cmath>

namespace cosplat {
namespace {

constexpr double kWhite = 203;                 // cd/m2 of what is white in HDR; ITU-R BT.2408, 2.1
constexpr double kPeak = 1000;                 // cd/m2 that HLG's screen and most PQ video reach
constexpr int kEntries = 4096;                 // of tables by a square root
constexpr double kBrightest = 10000 / kWhite;  // PQ's largest number, in white's light

// ITU-R BT.2100-2, table 5: light of the scene of an HLG number, both 0 to 1.
double HlgScene(double e) {
  constexpr double a = 0.17883277, b = 1 - 4 * a;
  const double c = 0.5 - a * std::log(4 * a);
  return e <= 0.5 ? e * e / 3 : (std::exp((e - c) / a) + b) / 12;
}

// Table 4: cd/m2 of a PQ number, and back.
constexpr double kM1 = 2610 / 16384.0, kM2 = 128 * 2523 / 4096.0;
constexpr double kC1 = 3424 / 4096.0, kC2 = 32 * 2413 / 4096.0, kC3 = 32 * 2392 / 4096.0;
double PqLight(double e) {
  const double p = std::pow(e, 1 / kM2);
  return 10000 * std::pow(std::max(p - kC1, 0.0) / (kC2 - kC3 * p), 1 / kM1);
}
double PqNumber(double light) {
  const double y = std::pow(light / 10000, kM1);
  return std::pow((kC1 + kC2 * y) / (1 + kC3 * y), kM2);
}

// ITU-R BT.2390-11, 5.4.1: what a screen whose brightest is white shows of light up to kPeak, both
// in white's; unchanged up to a knee.
double Shown(double light) {
  const double peak = PqNumber(kPeak), most = PqNumber(kWhite) / peak, knee = 1.5 * most - 0.5;
  const double e = std::min(PqNumber(light * kWhite) / peak, 1.0);
  if (e <= knee) return light;
  const double t = (e - knee) / (1 - knee), t2 = t * t, t3 = t2 * t;
  const double p =
      (2 * t3 - 3 * t2 + 1) * knee + (t3 - 2 * t2 + t) * (1 - knee) + (-2 * t3 + 3 * t2) * most;
  return PqLight(p * peak) / kWhite;
}

double SrgbOf(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

}  // namespace

HdrToSdr::HdrToSdr(HdrTransfer transfer, bool wide_primaries)
    : transfer_(transfer),
      wide_primaries_(wide_primaries),
      light_(1 << 16),
      gain_(kEntries + 1),
      shown_(kEntries + 1),
      srgb_(kEntries + 1) {
  for (size_t i = 0; i < light_.size(); ++i) {
    const double e = i / 65535.0;
    light_[i] = float(transfer == HdrTransfer::kHlg ? HlgScene(e) : PqLight(e) / kWhite);
  }
  for (int i = 0; i <= kEntries; ++i) {
    const double root = double(i) / kEntries, light = kBrightest * root * root;
    // Table 5's OOTF for a screen of kPeak: gamma 1.2 of the luminance.
    gain_[i] = float(kPeak / kWhite * std::pow(root, 2 * 0.2));
    shown_[i] = i == 0 ? 1 : float(Shown(light) / light);
    srgb_[i] = uint8_t(std::lround(255 * std::min(SrgbOf(root * root), 1.0)));
  }
}

void HdrToSdr::Convert(const uint16_t* from, size_t pixels, int channels, uint8_t* to) const {
  const float to_root = float(1 / std::sqrt(kBrightest));
  const auto at = [](const std::vector<float>& table, float root) {
    const float place = std::min(root * kEntries, kEntries - 0.5f);
    const int i = int(place);
    return table[i] + (place - float(i)) * (table[i + 1] - table[i]);
  };
  for (size_t i = 0; i < pixels; ++i, from += channels, to += channels) {
    float r = light_[from[0]], g = light_[from[1]], b = light_[from[2]];
    if (transfer_ == HdrTransfer::kHlg) {
      const float gain = at(gain_, std::sqrt(0.2627f * r + 0.6780f * g + 0.0593f * b));
      r *= gain, g *= gain, b *= gain;
    }
    const float factor = at(shown_, to_root * std::sqrt(std::max({r, g, b})));
    r *= factor, g *= factor, b *= factor;
    if (wide_primaries_) {  // ITU-R BT.2087: BT.2020's to BT.709's
      const float r2 = r, g2 = g, b2 = b;
      r = 1.6605f * r2 - 0.5876f * g2 - 0.0728f * b2;
      g = -0.1246f * r2 + 1.1329f * g2 - 0.0083f * b2;
      b = -0.0182f * r2 - 0.1006f * g2 + 1.1187f * b2;
    }
    for (int c = 0; c < 3; ++c) {
      const float light = std::clamp(c == 0 ? r : c == 1 ? g : b, 0.f, 1.f);
      to[c] = srgb_[int(kEntries * std::sqrt(light) + 0.5f)];
    }
    if (channels == 4) to[3] = uint8_t(from[3] >> 8);
  }
}

}  // namespace cosplat
