// How the results of two back ends are compared.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "splat/device/buffer.h"
#include "tests/parity/parity_case.h"

namespace cosplat::test {

struct Agreement {
  double cosine = 1;    // of the two as vectors
  double relative = 0;  // L2 of the difference by that of the first
  double norm = 0;      // of the first
};

inline Agreement AgreementOf(View<const float> a, View<const float> b) {
  double aa = 0, bb = 0, ab = 0, dd = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double x = a[i], y = b[i];
    aa += x * x;
    bb += y * y;
    ab += x * y;
    dd += (x - y) * (x - y);
  }
  Agreement g;
  g.norm = std::sqrt(aa);
  if (aa > 0 && bb > 0) g.cosine = ab / std::sqrt(aa * bb);
  g.relative = aa > 0 ? std::sqrt(dd / aa) : std::sqrt(dd);
  return g;
}

// Tight but for few values, whose difference is bounded and on average next to nothing.
inline void ExpectSameImage(View<const float> expected,
                            View<const float> actual,
                            const ParityTolerance& tolerance,
                            const std::string& what) {
  ASSERT_EQ(expected.size(), actual.size()) << what;
  float brightest = 1;
  for (const float v : expected) brightest = std::max(brightest, std::abs(v));
  size_t flipped = 0;
  double bias = 0;
  for (size_t i = 0; i < expected.size(); ++i) {
    const float off = actual[i] - expected[i];
    ASSERT_TRUE(std::isfinite(actual[i])) << what << " at " << i;
    ASSERT_LE(std::abs(off), tolerance.flip * brightest) << what << " at " << i;
    flipped += std::abs(off) > tolerance.pixel * brightest;
    bias += off;
  }
  const double count = double(std::max<size_t>(expected.size(), 1));
  EXPECT_LE(double(flipped), std::max(2.0, tolerance.flipped * count)) << what;
  EXPECT_LE(std::abs(bias) / count, tolerance.pixel * brightest) << what;
}

inline void ExpectSameGradients(View<const float> expected,
                                View<const float> actual,
                                const ParityTolerance& tolerance,
                                const std::string& what) {
  ASSERT_EQ(expected.size(), actual.size()) << what;
  for (const float v : actual) ASSERT_TRUE(std::isfinite(v)) << what;
  const Agreement g = AgreementOf(expected, actual);
  EXPECT_GE(g.cosine, 1 - tolerance.cosine) << what << ", norm " << g.norm;
  EXPECT_LE(g.relative, tolerance.relative) << what << ", norm " << g.norm;
}

}  // namespace cosplat::test
