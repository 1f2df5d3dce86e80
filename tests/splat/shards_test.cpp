// What ranks send each other, of more Gaussians than go into one exchange.
#include "splat/train/shards.h"

#include <gtest/gtest.h>

#include <numeric>

#include "splat/base/rng.h"
#include "splat/train/gradient_sum.h"
#include "splat/train/kernels/adam.h"
#include "tests/support/thread_ranks.h"

namespace cosplat {
namespace {

using namespace test;  // NOLINT: OnThreads

constexpr size_t kCount = 2 * kRowsPerExchange + 3 * kRowsPerBlock + 7;
constexpr size_t kRanks = 3;

// Of degree 0; number k of attribute a of row i is unlike all others.
float NumberOf(size_t i, int a, int k) { return float(i) + 0.1f * float(a) + 0.01f * float(k); }

Gaussians Numbered(size_t count, float factor = 1) {
  Gaussians g;
  g.degree = 0;
  g.Resize(count);
  for (int a = 0; a < kAttributeCount; ++a)
    for (size_t i = 0; i < count; ++i)
      for (int k = 0; k < g.width(a); ++k) g.at(Attribute(a), i)[k] = factor * NumberOf(i, a, k);
  return g;
}

Gaussians OwnOf(const Gaussians& all, const RowShare& share) {
  Gaussians own = all.ZerosLike(share.CountOf(all.size()));
  for (int a = 0; a < kAttributeCount; ++a)
    for (size_t i = 0; i < all.size(); ++i)
      if (share.Owns(i))
        std::copy_n(all.at(Attribute(a), i), all.width(a), own.at(Attribute(a), share.PlaceOf(i)));
  return own;
}

void ExpectSame(const Gaussians& a, const Gaussians& b) {
  ASSERT_EQ(a.size(), b.size());
  for (int k = 0; k < kAttributeCount; ++k)
    EXPECT_TRUE(
        std::equal(a.values[k].begin(), a.values[k].end(), b.values[k].begin(), b.values[k].end()))
        << "attribute " << k;
}

// Four views on three ranks; view v shows every (v + 2)nd group.
TEST(Shards, SumGradientsInTheOrderOfTheViews) {
  constexpr size_t kViews = 4;
  const auto shows = [](size_t view, size_t i) { return i / kGaussianGroup % (view + 2) == 0; };
  const Gaussians scene = Numbered(kCount);
  Gaussians expected = scene.ZerosLike(kCount);
  for (size_t v = 0; v < kViews; ++v)
    for (int a = 0; a < kAttributeCount; ++a)
      for (size_t i = 0; i < kCount; ++i)
        for (int k = 0; shows(v, i) && k < scene.width(a); ++k)
          expected.at(Attribute(a), i)[k] += 0.25f * (float(v + 1) * NumberOf(i, a, k));
  OnThreads(kRanks, [&](std::shared_ptr<Ranks> ranks) {
    const RowShare share = ShareOf(*ranks);
    GradientSum sum(*ranks, HostStream());
    sum.Begin(scene, kViews);
    for (size_t first = 0; first < kViews; first += kRanks) {
      const size_t v = first + ranks->rank();
      Gaussians gradients = Numbered(kCount, float(v + 1));
      Buffer<float> screen(2 * kCount, 0.0f), radii(kCount, 0.0f);
      for (size_t i = 0; i < kCount; ++i) radii[i] = shows(v, i) ? 1.0f : 0.0f;
      const ViewGradients mine{gradients, screen, std::as_const(radii).view(), {double(v), 64, 64}};
      sum.Add(v < kViews ? &mine : nullptr, scene, nullptr);
    }
    sum.ZeroUnseen();
    EXPECT_EQ(sum.MeanLoss(), 1.5);
    ExpectSame(sum.gradients(), OwnOf(expected, share));
  });
}

TEST(Shards, ShareWhatTheyUpdated) {
  const auto updated = [](size_t g) { return g % 3 == 0; };
  Gaussians expected = Numbered(kCount);
  size_t groups = 0;
  for (size_t g = 0; g < AdamGroupCount(kCount); ++g) {
    if (!updated(g)) continue;
    ++groups;
    for (size_t i = g * kGaussianGroup; i < std::min((g + 1) * kGaussianGroup, kCount); ++i)
      expected.at(kPosition, i)[1] = -1;
  }
  OnThreads(kRanks, [&](std::shared_ptr<Ranks> ranks) {
    Shards shards(*ranks);
    const RowShare& share = shards.share();
    Gaussians scene = Numbered(kCount);
    AdamState adam(scene, share);
    adam.step = 5;
    adam.behind.resize(adam.updated.size());
    for (size_t g = 0; g < adam.behind.size(); ++g) {
      const bool now = updated(g) && share.Owns(g * kGaussianGroup);
      adam.behind[g] = now ? 0 : kNotNow;
      if (!now) continue;
      adam.updated[g] = adam.step;
      for (size_t i = g * kGaussianGroup; i < std::min((g + 1) * kGaussianGroup, kCount); ++i)
        scene.at(kPosition, i)[1] = -1;
    }
    EXPECT_EQ(shards.ShareUpdated(scene, adam, HostStream()), groups);
    ExpectSame(scene, expected);
    for (size_t g = 0; g < adam.updated.size(); ++g)
      ASSERT_EQ(adam.updated[g], updated(g) ? adam.step : 0) << "group " << g;
  });
}

// Each new Gaussian has the moments of its source, or none.
TEST(Shards, HandMomentsOver) {
  const Gaussians before = Numbered(kCount);
  constexpr size_t kKept = kCount - 1000, kAfter = kCount + 1234;
  Rng rng{1};
  std::vector<uint32_t> source(kAfter);
  for (uint32_t& s : source) s = uint32_t(rng.Below(kCount));
  Gaussians expected = before.ZerosLike(kAfter);
  for (int a = 0; a < kAttributeCount; ++a)
    for (size_t i = 0; i < kKept; ++i)
      std::copy_n(
          before.at(Attribute(a), source[i]), before.width(a), expected.at(Attribute(a), i));
  OnThreads(kRanks, [&](std::shared_ptr<Ranks> ranks) {
    Shards shards(*ranks);
    AdamState adam(before, shards.share());
    adam.m = OwnOf(before, shards.share());
    adam.v = OwnOf(before, shards.share());
    shards.Gather({{source.data(), source.size()}, kKept}, adam, HostStream());
    ExpectSame(adam.m, OwnOf(expected, shards.share()));
    ExpectSame(adam.v, adam.m);
  });
}

TEST(Shards, AssembleRowsOnTheFirstRankAndTakeThemBack) {
  const Gaussians all = Numbered(kCount);
  OnThreads(kRanks, [&](std::shared_ptr<Ranks> ranks) {
    Shards shards(*ranks);
    const Gaussians own = OwnOf(all, shards.share());
    Gaussians taken = own.ZerosLike();
    for (size_t begin = 0; begin < kCount; begin += kRowsPerExchange) {
      const size_t end = std::min(begin + kRowsPerExchange, kCount);
      const Buffer<float> rows = shards.Assembled(own.values[kRotation], 4, begin, end);
      const Buffer<float> part(all.at(kRotation, begin),
                               all.at(kRotation, begin) + 4 * (end - begin));
      EXPECT_TRUE(ranks->rank() == 0 ? rows == part : rows.empty());
      shards.TakeOwn(part, 4, begin, end, taken.values[kRotation]);
    }
    EXPECT_TRUE(std::ranges::equal(taken.values[kRotation], own.values[kRotation]));
  });
}

}  // namespace
}  // namespace cosplat
