#include "avatar/live/guard.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "avatar/math/turn.h"
#include "splat/base/rng.h"

namespace cosplat {
namespace {

constexpr int64_t kMillisecond = 1'000'000;
constexpr int64_t kEarliest = std::numeric_limits<int64_t>::min();
constexpr int64_t kLatest = std::numeric_limits<int64_t>::max();

// Two coefficients; the head rests turned and moved.
FlameParams Rest() {
  FlameParams rest;
  rest.expression.resize(2);
  rest.pose[0] = {0, 0.4f, 0};
  rest.translation = {0, 0, 0.5f};
  return rest;
}

FlameParams Face(float x) {
  FlameParams face = Rest();
  face.expression = {x, -x};
  face.pose[0] = {0.1f * x, -0.3f * x, 0.2f};
  face.pose[2] = {0.3f * x, 0, 0};
  face.translation = {0.1f * x, 0, 0.4f};
  return face;
}

bool Same(const FlameParams& a, const FlameParams& b) {
  return a.expression == b.expression && a.pose == b.pose && a.translation == b.translation;
}

bool Finite(const FlameParams& face) {
  bool finite = true;
  for (const float x : face.expression) finite = finite && std::isfinite(x);
  for (const auto& joint : face.pose)
    for (const float x : joint) finite = finite && std::isfinite(x);
  for (const float x : face.translation) finite = finite && std::isfinite(x);
  return finite;
}

FlameParams At(FaceGuard& guard, int64_t milliseconds) {
  return guard.At(milliseconds * kMillisecond);
}
Verdict Offer(FaceGuard& guard, float x, int64_t milliseconds) {
  return guard.Offer(Face(x), milliseconds * kMillisecond);
}

TEST(FaceGuard, RestsHoldsDecays) {
  FaceGuard guard(Rest(), {});
  EXPECT_TRUE(Same(At(guard, 0), Rest()));
  EXPECT_EQ(guard.Age(), -1);
  guard.Reset();
  Offer(guard, 1, 100);
  EXPECT_TRUE(Same(At(guard, 100), Face(1))) << "nothing was shown that it could come from";
  EXPECT_TRUE(Same(At(guard, 350), Face(1)));
  EXPECT_EQ(guard.state(), FaceState::kLive);
  const FlameParams midway = At(guard, 850);
  EXPECT_NEAR(midway.expression[0], 0.5f, 1e-6f);
  EXPECT_EQ(guard.state(), FaceState::kDecaying);
  EXPECT_TRUE(Same(At(guard, 1350), Rest()));
  EXPECT_EQ(guard.state(), FaceState::kRest);
  EXPECT_NEAR(guard.Age(), 1.25, 1e-9);
}

TEST(FaceGuard, JointsDecayByTheShorterWay) {
  FlameParams face = Rest();
  face.pose[0] = {0, 6.0f, 0};  // 6 rad one way is 0.28 the other
  FaceGuard guard(Rest(), {});
  guard.Offer(face, 0);
  guard.At(0);
  const FlameParams midway = At(guard, 750);
  const float expected = 0.5f * (0.4f + 6.0f - 2 * float(M_PI));
  EXPECT_NEAR(midway.pose[0][1], expected, 1e-5f);
}

// Every number of a face as far as it can be seen: rotations as quaternions.
std::vector<float> Seen(const FlameParams& face) {
  std::vector<float> seen = face.expression;
  for (const auto& joint : face.pose) {
    const auto q = math::ShorterWay(math::QuatOfAxisAngle(joint));
    seen.insert(seen.end(), {q.w, q.x, q.y, q.z});
  }
  seen.insert(seen.end(), face.translation.begin(), face.translation.end());
  return seen;
}

// Plays a story at one image per millisecond; the largest step of any number and the largest
// change of a step.
struct Motion {
  float step = 0, turn = 0;
};
Motion Play(FaceGuard& guard, int milliseconds, const std::function<void(int)>& before_image) {
  Motion max;
  std::vector<float> last, last_step;
  for (int t = 0; t < milliseconds; ++t) {
    before_image(t);
    const std::vector<float> seen = Seen(At(guard, t));
    std::vector<float> step(seen.size());
    for (size_t i = 0; i < seen.size() && !last.empty(); ++i) {
      step[i] = seen[i] - last[i];
      max.step = std::max(max.step, std::abs(step[i]));
      if (!last_step.empty()) max.turn = std::max(max.turn, std::abs(step[i] - last_step[i]));
    }
    if (!last.empty()) last_step = step;
    last = seen;
  }
  return max;
}

// The ease's second derivative is at most 6 / duration^2: 0.2 s, 1e-6 s^2 per image, faces at
// most 2 apart; the courses underneath and rounding add less than half. A corner would show its
// change of speed, which is above 2e-3 per image where the decay is cut into.
constexpr float kMinCorner = 1.5f * 2 * 6 / (0.2f * 0.2f) * 1e-6f;

TEST(FaceGuard, NeitherValueNorSpeedJumps) {
  // From rest to a face, which decays; another comes when it is half way.
  FaceGuard guard(Rest(), {});
  const Motion motion = Play(guard, 2500, [&](int t) {
    if (t >= 5 && t < 400 && t % 40 == 0) Offer(guard, 1, t);
    if (t >= 1150 && t < 1500 && t % 40 == 0) Offer(guard, -1, t);
  });
  EXPECT_EQ(guard.counts().returned, 2u);
  EXPECT_LT(motion.turn, kMinCorner);
  EXPECT_LT(motion.step, 1.5f * 2 / 200 * 1.5f);
}

TEST(FaceGuard, AGapWithinAReturnHasNoJumpEither) {
  GuardPolicy policy;
  policy.hold = 0.05;
  policy.blend_in = 1;
  policy.decay = 0.5;
  FaceGuard guard(Rest(), {}, policy);
  const Motion motion = Play(guard, 2000, [&](int t) {
    if (t == 10 || t == 300 || t == 700) Offer(guard, t == 300 ? -1 : 1, t);
  });
  EXPECT_EQ(guard.counts().returned, 3u);
  EXPECT_LT(motion.step, 0.02f);
  EXPECT_TRUE(Same(At(guard, 4000), Rest()));
}

TEST(FaceGuard, ComesBackToExactlyWhatComesIn) {
  FaceGuard guard(Rest(), {});
  Offer(guard, 1, 0);
  At(guard, 0);
  At(guard, 900);
  for (int t = 900; t <= 1100; t += 20) {
    Offer(guard, 0.5f, t);
    const FlameParams face = At(guard, t);
    EXPECT_EQ(Same(face, Face(0.5f)), t == 1100) << t;
    EXPECT_EQ(guard.state(), t == 1100 ? FaceState::kLive : FaceState::kReturning) << t;
  }
}

TEST(FaceGuard, AHostThatLooksRarelyMissesNothing) {
  FaceGuard guard(Rest(), {});
  for (int t = 0; t < 5000; t += 500) {
    Offer(guard, 0.0002f * float(t), t);
    EXPECT_TRUE(Same(At(guard, t), Face(0.0002f * float(t)))) << t;
  }
  EXPECT_EQ(guard.counts().returned, 0u);
}

TEST(FaceGuard, RefusesAndCounts) {
  FaceGuard guard(Rest(), {});
  Offer(guard, 1, 100);
  At(guard, 100);
  const auto refused = [&](Verdict verdict, const std::function<void(FlameParams&)>& spoil) {
    FlameParams bad = Face(0.5f);
    spoil(bad);
    EXPECT_EQ(guard.Offer(bad, 200 * kMillisecond), verdict);
    EXPECT_TRUE(Same(At(guard, 200), Face(1)));
  };
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float x : {std::nanf(""), infinity, -infinity, 100.5f, -1e30f}) {
    const Verdict verdict = std::isfinite(x) ? Verdict::kOutOfRange : Verdict::kNotFinite;
    refused(verdict, [&](auto& f) { f.expression[1] = x; });
    refused(verdict, [&](auto& f) { f.pose[4][2] = x; });
    refused(verdict, [&](auto& f) { f.translation[1] = x; });
    refused(verdict, [&](auto& f) { f.expression.assign(9, x); });  // those left out count too
  }
  refused(Verdict::kNotFinite, [&](auto& f) { f.expression = {1e30f, std::nanf("")}; });
  refused(Verdict::kWrongSize, [](auto& f) { f.expression.resize(kMaxExpressions + 1); });
  EXPECT_EQ(Offer(guard, 1, 99), Verdict::kLate);
  EXPECT_EQ(Offer(guard, 1, 100), Verdict::kAccepted);
  const GuardCounts& counts = guard.counts();
  EXPECT_EQ(counts.not_finite, 13u);
  EXPECT_EQ(counts.out_of_range, 8u);
  EXPECT_EQ(counts.wrong_size, 1u);
  EXPECT_EQ(counts.late, 1u);
  EXPECT_EQ(counts.accepted, 1u);
}

TEST(FaceGuard, OfSeveralFramesTheNewestIsShown) {
  FaceGuard guard(Rest(), {});
  Offer(guard, 1, 10);
  Offer(guard, 0.8f, 10);  // of the same moment: the same frame
  Offer(guard, 0.5f, 20);
  EXPECT_EQ(Offer(guard, 0.1f, 15), Verdict::kLate);
  EXPECT_TRUE(Same(At(guard, 20), Face(0.5f)));
  EXPECT_EQ(guard.counts().replaced, 1u);
  EXPECT_EQ(guard.counts().accepted, 1u);
}

TEST(FaceGuard, MissingCoefficientsAreZeroAndExcessOnesLeftOut) {
  FaceGuard guard(Rest(), {});
  FlameParams face = Face(1);
  face.expression = {0.5f};
  guard.Offer(face, 0);
  EXPECT_EQ(guard.At(0).expression, (std::vector<float>{0.5f, 0}));
  face.expression = {0.1f, 0.2f, 0.3f};
  guard.Offer(face, 1);
  EXPECT_EQ(guard.At(1).expression, (std::vector<float>{0.1f, 0.2f}));
}

TEST(FaceGuard, ResetIsAsNew) {
  FaceGuard guard(Rest(), {});
  Offer(guard, 1, 1000);
  At(guard, 1000);
  At(guard, 1600);
  Offer(guard, 0.3f, 1600);
  At(guard, 1650);
  guard.Reset();
  EXPECT_TRUE(Same(At(guard, 0), Rest()));
  EXPECT_EQ(guard.state(), FaceState::kRest);
  guard.Reset();
  EXPECT_EQ(Offer(guard, 0.7f, 5), Verdict::kAccepted);
  EXPECT_TRUE(Same(At(guard, 5), Face(0.7f)));
  EXPECT_EQ(guard.counts().accepted, 3u);
}

TEST(FaceGuard, TimesMayBeAny) {
  FaceGuard guard(Rest(), {});
  EXPECT_TRUE(Same(guard.At(kEarliest), Rest()));
  guard.Offer(Face(1), kEarliest);
  guard.At(kEarliest + 1);
  guard.Offer(Face(0.5f), kLatest);
  EXPECT_TRUE(Finite(guard.At(kLatest)));
  EXPECT_TRUE(Finite(guard.At(kEarliest))) << "counts as the one before";
  EXPECT_EQ(guard.Offer(Face(1), 0), Verdict::kLate);
}

// Whatever comes, what is drawn is finite, and what is not late at the end is shown in the end.
TEST(FaceGuard, NothingBadComesOut) {
  Rng rng{17};
  const float odd[] = {std::nanf(""), INFINITY, -INFINITY, 1e30f, 99, -99, 0, 3.2f, 6.3f};
  for (int round = 0; round < 20; ++round) {
    GuardPolicy policy;
    policy.hold = 0.3 * rng.Uniform();
    policy.decay = 0.01 + rng.Uniform();
    policy.blend_in = 0.01 + rng.Uniform();
    policy.soft_range = round % 2;
    if (round % 3 == 0) policy.smoothing = math::OneEuro{};
    FaceGuard guard(Rest(), {}, policy);
    int64_t now = 0;
    for (int i = 0; i < 300; ++i) {
      now += int64_t(rng.Uniform() * 2e8);
      FlameParams face = Face(2 * rng.Uniform() - 1);
      if (rng.Uniform() < 0.5f) {
        const float x = odd[size_t(rng.Uniform() * 8.99f)];
        face.expression[size_t(i % 2)] = x;
        face.pose[size_t(i % 5)][size_t(i % 3)] = x;
      }
      if (rng.Uniform() < 0.5f) guard.Offer(face, now - int64_t(rng.Uniform() * 5e7));
      ASSERT_TRUE(Finite(guard.At(now))) << round << " " << i;
    }
    guard.Offer(Face(0.25f), now);
    for (int i = 0; i < 200; ++i) {
      guard.Offer(Face(0.25f), now += 50 * kMillisecond);
      guard.At(now);
    }
    const FlameParams& face = guard.At(now);
    EXPECT_NEAR(face.expression[0], 0.25f, 1e-5f);
    EXPECT_NEAR(face.pose[2][0], 0.075f, 1e-5f);
  }
}

}  // namespace
}  // namespace cosplat
