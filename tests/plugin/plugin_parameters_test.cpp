// cosplat.h: parameters. What is refused leaves the last good ones in place.
#include <cmath>
#include <functional>
#include <limits>

#include "tests/plugin/plugin_fixture.h"
#include "tests/support/restless_params.h"

namespace cosplat::test {
namespace {

// What is set, with a copy of the coefficients.
struct Kept {
  cosplat_parameters parameters = Zeroed<cosplat_parameters>();
  std::vector<float> expression;
};
Kept Get(cosplat_avatar* avatar) {
  Kept kept;
  EXPECT_EQ(cosplat_get_parameters(avatar, &kept.parameters), COSPLAT_OK);
  kept.expression.assign(kept.parameters.expression,
                         kept.parameters.expression + kept.parameters.expression_count);
  return kept;
}
void ExpectSame(const Kept& a, const Kept& b) {
  EXPECT_EQ(a.expression, b.expression);
  EXPECT_EQ(a.parameters.time_ns, b.parameters.time_ns);
  EXPECT_EQ(std::memcmp(a.parameters.joints, b.parameters.joints, sizeof(b.parameters.joints)), 0);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(a.parameters.translation[k], b.parameters.translation[k]);
}

const FlameModel& Flame() { return PluginFiles::Get().flame; }

TEST(PluginParameters, ComeBackAsTheyWereSet) {
  const OpenAvatar avatar;
  const FlameParams params = RestlessParams(Flame(), 3);
  const cosplat_parameters set = ParametersOf(params, 12345);
  ASSERT_EQ(cosplat_set_parameters(avatar, &set), COSPLAT_OK);
  Kept kept = Get(avatar);
  ExpectSame(kept, {set, params.expression});
  // What comes back may be handed in again, changed.
  kept.parameters.joints[COSPLAT_JOINT_JAW][0] = 0.5f;
  kept.parameters.time_ns = 12346;
  ASSERT_EQ(cosplat_set_parameters(avatar, &kept.parameters), COSPLAT_OK);
  ExpectSame(Get(avatar), kept);
}

TEST(PluginParameters, OneAtATimeIsTheSame) {
  const OpenAvatar whole, single;
  const FlameParams params = RestlessParams(Flame(), 5);
  const cosplat_parameters set = ParametersOf(params, 7);
  ASSERT_EQ(cosplat_set_parameters(whole, &set), COSPLAT_OK);
  for (uint32_t i = 0; i < set.expression_count; ++i)
    ASSERT_EQ(cosplat_set_expression(single, i, set.expression[i], 7), COSPLAT_OK);
  for (uint32_t j = 0; j < COSPLAT_JOINT_COUNT; ++j)
    ASSERT_EQ(cosplat_set_joint(single, j, set.joints[j], 7), COSPLAT_OK);
  ASSERT_EQ(cosplat_set_translation(single, set.translation, 7), COSPLAT_OK);
  ExpectSame(Get(single), Get(whole));
}

TEST(PluginParameters, MissingCoefficientsAreZeroAndExcessOnesLeftOut) {
  const OpenAvatar avatar;
  FlameParams params;
  params.expression.assign(100, 0.5f);
  cosplat_parameters set = ParametersOf(params);
  ASSERT_EQ(cosplat_set_parameters(avatar, &set), COSPLAT_OK);
  EXPECT_EQ(Get(avatar).expression, std::vector<float>(kExpressionCount, 0.5f));
  set.expression_count = 2;
  ASSERT_EQ(cosplat_set_parameters(avatar, &set), COSPLAT_OK);
  std::vector<float> expected(kExpressionCount, 0.0f);
  expected[0] = expected[1] = 0.5f;
  EXPECT_EQ(Get(avatar).expression, expected);
  set.expression_count = 0;
  set.expression = nullptr;
  ASSERT_EQ(cosplat_set_parameters(avatar, &set), COSPLAT_OK);
  EXPECT_EQ(Get(avatar).expression, std::vector<float>(kExpressionCount, 0.0f));
}

TEST(PluginParameters, WhatIsRefusedChangesNothing) {
  const OpenAvatar avatar;
  const FlameParams params = RestlessParams(Flame(), 4);
  const cosplat_parameters good = ParametersOf(params, 1000);
  ASSERT_EQ(cosplat_set_parameters(avatar, &good), COSPLAT_OK);
  const Kept before = Get(avatar);
  const auto refused = [&](cosplat_status status,
                           const std::function<void(cosplat_parameters&)>& spoil) {
    cosplat_parameters bad = good;
    bad.time_ns = 2000;
    bad.translation[0] += 0.1f;
    spoil(bad);
    EXPECT_EQ(cosplat_set_parameters(avatar, &bad), status) << cosplat_last_error(avatar);
    ExpectSame(Get(avatar), before);
  };
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = INFINITY;
  std::vector<float> expression(kExpressionCount, 0.1f);
  for (const float x : {nan, infinity, -infinity, 1e5f, -1e30f}) {
    const cosplat_status status =
        std::isfinite(x) ? COSPLAT_ERROR_ARGUMENT : COSPLAT_ERROR_NOT_FINITE;
    refused(status, [&](auto& p) { p.joints[4][2] = x; });
    refused(status, [&](auto& p) { p.translation[2] = x; });
    expression.back() = x;
    refused(status, [&](auto& p) { p.expression = expression.data(); });
    EXPECT_EQ(cosplat_set_expression(avatar, 0, x, 2000), status);
    const float three[3] = {0, 0, x};
    EXPECT_EQ(cosplat_set_joint(avatar, 2, three, 2000), status);
    EXPECT_EQ(cosplat_set_translation(avatar, three, 2000), status);
    ExpectSame(Get(avatar), before);
  }
  refused(COSPLAT_ERROR_ARGUMENT, [](auto& p) { p.expression = nullptr; });
  refused(COSPLAT_ERROR_ARGUMENT, [](auto& p) { p.expression_count = ~0u; });
  refused(COSPLAT_ERROR_ARGUMENT, [](auto& p) { p.struct_size = 8; });
  refused(COSPLAT_ERROR_LATE, [](auto& p) { p.time_ns = 999; });
  EXPECT_EQ(cosplat_set_parameters(avatar, nullptr), COSPLAT_ERROR_ARGUMENT);
  EXPECT_EQ(cosplat_get_parameters(avatar, nullptr), COSPLAT_ERROR_ARGUMENT);
  EXPECT_EQ(cosplat_set_joint(avatar, 0, nullptr, 2000), COSPLAT_ERROR_ARGUMENT);
  EXPECT_EQ(cosplat_set_translation(avatar, nullptr, 2000), COSPLAT_ERROR_ARGUMENT);
  const float three[3] = {0, 0, 0};
  EXPECT_EQ(cosplat_set_joint(avatar, 5, three, 2000), COSPLAT_ERROR_NOT_FOUND);
  EXPECT_EQ(cosplat_set_joint(avatar, 1, three, 999), COSPLAT_ERROR_LATE);
  EXPECT_EQ(cosplat_set_expression(avatar, kExpressionCount, 0, 2000), COSPLAT_ERROR_NOT_FOUND);
  ExpectSame(Get(avatar), before);
}

TEST(PluginParameters, ResetIsRestAndAnyTimeIsNewAgain) {
  const OpenAvatar avatar;
  const Kept rest = Get(avatar);
  EXPECT_EQ(rest.expression, std::vector<float>(kExpressionCount, 0.0f));
  const FlameParams params = RestlessParams(Flame(), 4);
  const cosplat_parameters late = ParametersOf(params, 1000), early = ParametersOf(params, -5);
  ASSERT_EQ(cosplat_set_parameters(avatar, &late), COSPLAT_OK);
  ASSERT_EQ(cosplat_set_parameters(avatar, &late), COSPLAT_OK);  // equal times are not late
  ASSERT_EQ(cosplat_set_parameters(avatar, &early), COSPLAT_ERROR_LATE);
  ASSERT_EQ(cosplat_reset_parameters(avatar), COSPLAT_OK);
  ExpectSame(Get(avatar), rest);
  EXPECT_EQ(cosplat_set_parameters(avatar, &early), COSPLAT_OK);
}

}  // namespace
}  // namespace cosplat::test
