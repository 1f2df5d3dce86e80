// Gaussians divided between ranks, of more than go into one exchange; and views added up.
#include "splat/train/ranks/shards.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "splat/base/rng.h"
#include "splat/train/step/gradient_sum.h"
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

void ExpectSame(const Gaussians& a, const Gaussians& b) {
  ASSERT_EQ(a.size(), b.size());
  for (int k = 0; k < kAttributeCount; ++k)
    EXPECT_TRUE(
        std::equal(a.values[k].begin(), a.values[k].end(), b.values[k].begin(), b.values[k].end()))
        << "attribute " << k;
}

// Three views of a scene in two parts; view v shows every (v + 2)nd group. Their sums round.
TEST(GradientSum, AddsViewsInTheirOrder) {
  constexpr size_t kViews = 3, kSecond = kRowsPerExchange;
  const auto shows = [](size_t view, size_t i) { return i / kGaussianGroup % (view + 2) == 0; };
  const Gaussians scene = Numbered(kCount);
  Gaussians expected = scene.ZerosLike(kCount);
  size_t seen = 0;
  for (size_t i = 0; i < kCount; i += kGaussianGroup)
    seen += shows(0, i) || shows(1, i) || shows(2, i);
  for (size_t v = 0; v < kViews; ++v)
    for (int a = 0; a < kAttributeCount; ++a)
      for (size_t i = 0; i < kCount; ++i)
        for (int k = 0; shows(v, i) && k < scene.width(a); ++k)
          expected.at(Attribute(a), i)[k] += 1 / 3.0f * (float(v + 1) * NumberOf(i, a, k));
  GradientSum sum(HostStream());
  sum.Begin(scene, kViews);
  for (const size_t first : {size_t(0), kSecond})
    for (size_t v = 0; v < kViews; ++v) {
      const size_t rows = first == 0 ? kSecond : kCount - kSecond;
      const Gaussians all = Numbered(kCount, float(v + 1));
      Gaussians part = all.ZerosLike(rows);
      for (int a = 0; a < kAttributeCount; ++a)
        std::copy_n(all.at(Attribute(a), first), rows * all.width(a), part.values[a].data());
      Buffer<float> screen(2 * rows, 0.0f), radii(rows, 0.0f);
      for (size_t i = 0; i < rows; ++i) radii[i] = shows(v, first + i) ? 1.0f : 0.0f;
      sum.Add({part, screen, radii, 64, 64}, first, scene, nullptr);
    }
  EXPECT_EQ(sum.CountSeen(), seen);
  sum.ZeroUnseen();
  ExpectSame(sum.gradients(), expected);
}

TEST(Shards, AssembleAndTakeTheirOwn) {
  Gaussians scene = Numbered(kCount);
  OnThreads(kRanks, [&](std::shared_ptr<Ranks> ranks) {
    Shards shards(*ranks);
    Gaussians own = shards.OwnOf(scene);
    EXPECT_EQ(own.size(), shards.share().CountOf(kCount));
    Gaussians all = scene.ZerosLike();
    shards.Assemble(RowsOf(own), RowsOf(all), kCount, HostStream());
    ExpectSame(all, scene);
    Gaussians again = own.ZerosLike();
    shards.TakeOwn(RowsOf(all), RowsOf(again), kCount, HostStream());
    ExpectSame(again, own);
    const Gaussians gathered = shards.AllOf(own, kCount);
    if (ranks->rank() == 0)
      ExpectSame(gathered, scene);
    else
      EXPECT_EQ(gathered.size(), 0u);
  });
}

// Each new Gaussian has what its source had: here all attributes, and of those that are kept the
// moments.
TEST(Shards, HandRowsOver) {
  const Gaussians before = Numbered(kCount);
  constexpr size_t kKept = kCount - 1000, kAfter = kCount + 1234;
  Rng rng{1};
  std::vector<uint32_t> source(kAfter);
  for (uint32_t& s : source) s = uint32_t(rng.Below(kCount));
  Gaussians of_all = before.ZerosLike(kAfter), of_kept = of_all;
  for (int a = 0; a < kAttributeCount; ++a)
    for (size_t i = 0; i < kAfter; ++i)
      for (Gaussians* to : {&of_all, &of_kept})
        if (to == &of_all || i < kKept)
          std::copy_n(before.at(Attribute(a), source[i]), before.width(a), to->at(Attribute(a), i));
  OnThreads(kRanks, [&](std::shared_ptr<Ranks> ranks) {
    Shards shards(*ranks);
    Gaussians values = shards.OwnOf(before), moments = values;
    std::vector<HandedOver> arrays;
    for (int a = 0; a < kAttributeCount; ++a) {
      arrays.push_back({&values.values[a], size_t(values.width(a)), kAfter});
      arrays.push_back({&moments.values[a], size_t(values.width(a)), kKept});
    }
    shards.Gather({{source.data(), source.size()}, kKept}, arrays, HostStream());
    ExpectSame(values, shards.OwnOf(of_all));
    ExpectSame(moments, shards.OwnOf(of_kept));
  });
}

// Of rows, and of groups of them; also where the last block is not whole.
TEST(Shards, AssembleStretchesInHostMemoryAndTakeThemBack) {
  const Gaussians all = Numbered(kCount);
  const auto entries = [](size_t rows) { return GroupCount(rows); };
  OnThreads(kRanks, [&](std::shared_ptr<Ranks> ranks) {
    Shards shards(*ranks);
    const Gaussians own = shards.OwnOf(all);
    Gaussians taken = own.ZerosLike();
    Buffer<uint32_t> of_groups(entries(own.size())), groups_taken(of_groups.size());
    for (size_t g = 0; g < of_groups.size(); ++g)
      of_groups[g] = uint32_t(shards.share().RowAt(g * kGaussianGroup) / kGaussianGroup);
    for (size_t begin = 0; begin < kCount; begin += kRowsPerExchange) {
      const size_t end = std::min(begin + kRowsPerExchange, kCount);
      const Stretch stretch{begin, end, 4};
      const Buffer<float> rows =
          shards.Assembled(own.values[kRotation], stretch, ForWhom::kFirstRank);
      const Buffer<float> part(all.at(kRotation, begin),
                               all.at(kRotation, begin) + 4 * (end - begin));
      EXPECT_TRUE(ranks->rank() == 0 ? rows == part : rows.empty());
      shards.TakeOwn(part, stretch, taken.values[kRotation]);
      const Stretch groups{begin, end, 1, kGaussianGroup};
      const Buffer<uint32_t> numbers = shards.Assembled(of_groups, groups, ForWhom::kAllRanks);
      ASSERT_EQ(numbers.size(), entries(end - begin));
      for (size_t g = 0; g < numbers.size(); ++g) ASSERT_EQ(numbers[g], begin / kGaussianGroup + g);
      shards.TakeOwn(numbers, groups, groups_taken);
    }
    EXPECT_TRUE(std::ranges::equal(taken.values[kRotation], own.values[kRotation]));
    EXPECT_EQ(groups_taken, of_groups);
  });
}

// Fewer Gaussians than blocks: some ranks have none.
TEST(Shards, MayHaveNothing) {
  Gaussians scene = Numbered(kRowsPerBlock - 3);
  scene.smoothing.assign(scene.size(), 0.5f);
  OnThreads(kRanks, [&](std::shared_ptr<Ranks> ranks) {
    Shards shards(*ranks);
    const Gaussians own = shards.OwnOf(scene);
    EXPECT_EQ(own.size(), ranks->rank() == 0 ? scene.size() : 0);
    EXPECT_TRUE(shards.AnyHas(own.smoothing));
    EXPECT_FALSE(shards.AnyHas(own.degrees));
    const Gaussians all = shards.AllOf(own, scene.size());
    EXPECT_EQ(all.smoothing.size(), ranks->rank() == 0 ? scene.size() : 0);
  });
}

}  // namespace
}  // namespace cosplat
