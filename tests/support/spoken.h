// Speech by rule, for tests: a buzz of 120 Hz through three resonances.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

namespace cosplat::test {

constexpr int kSpokenRate = 16000;

// Resonances in Hz; zeros are silence.
struct Spoken {
  std::array<double, 3> formants{};
  double seconds = 0;
};
constexpr std::array<double, 3> kSpokenAh{730, 1150, 2450}, kSpokenEe{280, 2250, 2950},
    kSpokenOo{320, 850, 2250};

inline std::vector<float> Speak(const std::vector<Spoken>& sounds) {
  std::vector<float> samples;
  double phase = 0, noise = 1;
  std::array<std::array<double, 2>, 3> state{};
  for (const Spoken& sound : sounds) {
    const auto count = size_t(sound.seconds * kSpokenRate);
    for (size_t i = 0; i < count; ++i) {
      phase += 120.0 / kSpokenRate;
      const bool pulse = phase >= 1;
      phase -= pulse;
      noise = std::fmod(noise * 16807, 2147483647);
      double x = 1e-3 * (noise / 2147483647 - 0.5);
      if (sound.formants[0] > 0) {
        x += pulse ? 0.3 : 0;
        for (size_t k = 0; k < 3; ++k) {
          const double radius = std::exp(-std::numbers::pi * 90 / kSpokenRate);
          const double angle = 2 * std::numbers::pi * sound.formants[k] / kSpokenRate;
          const double y = x * (1 - radius) + 2 * radius * std::cos(angle) * state[k][0] -
                           radius * radius * state[k][1];
          state[k] = {y, state[k][0]};
          x = 4 * y;
        }
      }
      samples.push_back(float(x));
    }
  }
  float peak = 1e-6f;
  for (const float x : samples) peak = std::max(peak, std::abs(x));
  for (float& x : samples) x *= 0.5f / peak;
  return samples;
}

// Little-endian, 16 bits.
inline std::string SampleBytes(const std::vector<float>& samples) {
  std::string bytes;
  for (const float x : samples) {
    const auto value = int16_t(x * 32767);
    bytes += char(value & 255);
    bytes += char((value >> 8) & 255);
  }
  return bytes;
}

inline void WriteWav(const std::vector<float>& samples, const std::string& path) {
  const auto number = [](uint32_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += char((value >> (8 * i)) & 255);
    return text;
  };
  const std::string data = SampleBytes(samples);
  std::ofstream(path, std::ios::binary)
      << "RIFF" << number(36 + uint32_t(data.size()), 4) << "WAVEfmt " << number(16, 4)
      << number(1, 2) << number(1, 2) << number(kSpokenRate, 4) << number(2 * kSpokenRate, 4)
      << number(2, 2) << number(16, 2) << "data" << number(uint32_t(data.size()), 4) << data;
}

}  // namespace cosplat::test
