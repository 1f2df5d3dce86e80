#include "avatar/surface/kernels/face_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "avatar/surface/kernels/holes.h"

namespace cosplat::math {
namespace {

TEST(FaceSearch, GivesTheNearestFirstAndEachFaceOnce) {
  const auto search = std::make_unique<FaceSearch>();
  for (const int limit : {40, 100000}) {
    search->Start();
    std::mt19937 rng(1);
    std::vector<FaceAtDistance> expected;
    for (int i = 0; i < 2000; ++i) {
      const int32_t face = int32_t(rng() % limit);
      const FaceAtDistance entry{double(face % 7), face};  // many at the same distance
      const bool known = std::any_of(
          expected.begin(), expected.end(), [&](const auto& e) { return e.face == face; });
      const bool room = expected.size() < FaceSearch::kMaxFaces;
      ASSERT_EQ(search->See(face), !known && room);
      if (known || !room) continue;
      search->Push(entry);
      expected.push_back(entry);
    }
    EXPECT_EQ(search->IsFull(), limit > 40);
    std::sort(expected.begin(), expected.end(), [](const auto& a, const auto& b) {
      return a.IsBefore(b);
    });
    for (const FaceAtDistance& e : expected) {
      ASSERT_FALSE(search->IsEmpty());
      ASSERT_EQ(search->PopNearest().face, e.face);
    }
    EXPECT_TRUE(search->IsEmpty());
  }
}

TEST(HoleMask, FindsWhatALookAtEveryPixelFinds) {
  constexpr int kWidth = 13, kHeight = 9;
  std::mt19937 rng(2);
  std::uniform_real_distribution<float> uniform(-4, 17);
  int found = 0;
  for (int round = 0; round < 2000; ++round) {
    std::vector<uint8_t> holes(kWidth * kHeight, 0);
    holes[rng() % holes.size()] = 1;
    const float x = uniform(rng), y = uniform(rng), radius = 0.3f * std::abs(uniform(rng));
    bool expected = false;
    for (size_t p = 0; p < holes.size(); ++p)
      expected |= holes[p] &&
                  std::hypot(float(p % kWidth) + 0.5f - x, float(p / kWidth) + 0.5f - y) <= radius;
    EXPECT_EQ((HoleMask{holes.data(), kWidth, kHeight}.HasWithin(x, y, radius)), expected);
    found += expected;
  }
  EXPECT_GT(found, 20);
}

}  // namespace
}  // namespace cosplat::math
