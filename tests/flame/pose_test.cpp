// flame/pose.h and flame/model.h: known poses, properties, the gradient, refused input.
#include "flame/pose.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <limits>
#include <numbers>

#include "flame/math/rodrigues.h"
#include "splat/base/error.h"
#include "tests/flame/random_model.h"
#include "tests/support/gradient_check.h"

namespace cosplat::test {
namespace {

using Poser = FlamePoser<double>;

std::array<double, 3> Joint(const FlameModel& m, int j, const std::vector<double>& vertices) {
  std::array<double, 3> p{};
  for (int v = 0; v < m.vertex_count; ++v)
    for (int i = 0; i < 3; ++i)
      p[i] += m.joint_regressor[size_t(j) * m.vertex_count + v] * vertices[3 * v + i];
  return p;
}

std::vector<double> Posed(const Poser& poser, const Poser::Parameters& frame) {
  std::vector<double> vertices;
  poser.Forward(frame, vertices);
  return vertices;
}

Poser::Parameters RandomFrame(unsigned seed, double scale = 0.6) {
  const auto x = RandomVector(22, seed, scale);
  Poser::Parameters frame;
  frame.expression.assign(x.begin(), x.begin() + 4);
  for (int j = 0; j < kFlameJoints; ++j)
    for (int i = 0; i < 3; ++i) frame.pose[j][i] = x[4 + 3 * j + i];
  for (int i = 0; i < 3; ++i) frame.translation[i] = x[19 + i];
  return frame;
}

TEST(FlamePose, ZeroParametersGiveTheTemplate) {
  const FlameModel model = RandomModel();
  const auto v = Posed(Poser(model, {}), {});
  ASSERT_EQ(v.size(), model.template_vertices.size());
  for (size_t i = 0; i < v.size(); ++i) EXPECT_NEAR(v[i], model.template_vertices[i], 1e-6);
}

TEST(FlamePose, ShapeOffsetExpressionAndTranslationAdd) {
  const FlameModel model = RandomModel();
  const std::vector<float> offset(3 * model.vertex_count, 0.25f);
  const Poser poser(model, {0, 2}, offset);
  Poser::Parameters frame;
  frame.expression = {0, 0, -3};
  frame.translation = {1, 2, 3};
  const auto v = Posed(poser, frame);
  const size_t n = 3 * model.vertex_count;
  for (size_t i = 0; i < n; ++i)
    EXPECT_NEAR(v[i],
                model.template_vertices[i] + 2 * model.shape_directions[n + i] + 0.25 -
                    3 * model.expression_directions[2 * n + i] + 1 + i % 3,
                1e-6);
}

TEST(FlamePose, RootTurnsAboutItsJointNotTheOrigin) {
  const FlameModel model = RandomModel();
  const Poser poser(model, {});
  const auto rest = Posed(poser, {});
  const auto pivot = Joint(model, 0, rest);
  Poser::Parameters frame;
  frame.pose[0] = {0, 0, std::numbers::pi / 2};
  const auto v = Posed(poser, frame);
  for (int i = 0; i < model.vertex_count; ++i) {
    const double x = rest[3 * i] - pivot[0], y = rest[3 * i + 1] - pivot[1];
    EXPECT_NEAR(v[3 * i], pivot[0] - y, 1e-6);
    EXPECT_NEAR(v[3 * i + 1], pivot[1] + x, 1e-6);
    EXPECT_NEAR(v[3 * i + 2], rest[3 * i + 2], 1e-6);
  }
}

// The definition, written out with dense matrices as the papers print it (G * T(-J), joints
// regressed from the vertices), against the poser's folded and streamed form.
TEST(FlamePose, MatchesTheDefinition) {
  const FlameModel m = RandomModel();
  const Poser::Parameters frame = RandomFrame(5);
  const size_t n = 3 * m.vertex_count;
  std::vector<double> v(m.template_vertices.begin(), m.template_vertices.end());
  for (size_t i = 0; i < n; ++i) {
    v[i] += double(0.7f) * m.shape_directions[i];
    for (int k = 0; k < 4; ++k) v[i] += frame.expression[k] * m.expression_directions[k * n + i];
  }
  std::array<math::Mat3<double>, 5> world;
  std::array<math::Vec3<double>, 5> rest, posed;
  std::vector<double> p = v;
  for (int j = 0; j < 5; ++j) {
    rest[j] = math::ToVec3(Joint(m, j, v));
    const auto r = flame_math::Rodrigues(math::ToVec3(frame.pose[j]));
    const int parent = m.parents[j];
    world[j] = j == 0 ? r : world[parent] * r;
    posed[j] = rest[j];
    if (j > 0) {
      posed[j] = world[parent] * (rest[j] - rest[parent]) + posed[parent];
      for (int k = 0; k < 9; ++k)
        for (size_t i = 0; i < n; ++i)
          p[i] += m.pose_directions[(9 * (j - 1) + k) * n + i] * (r.m[k] - (k % 4 == 0));
    }
  }
  const auto actual = Posed(Poser(m, {0.7f}), frame);
  for (int i = 0; i < m.vertex_count; ++i) {
    math::Vec3<double> sum = math::ToVec3(frame.translation);
    for (int j = 0; j < 5; ++j)
      sum += double(m.skinning_weights[5 * i + j]) *
             (world[j] * (math::ToVec3(&p[3 * i]) - rest[j]) + posed[j]);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(actual[3 * i + k], sum[k], 1e-12);
  }
}

TEST(FlamePose, FloatAgreesWithDouble) {
  const FlameModel model = RandomModel(3000);  // longer than one strip of the product
  FlameParams params;
  params.expression = {0.5f, 0, -1.5f};
  params.pose = {{{0.1f, 0.4f, 0}, {0, 0, 0.2f}, {0.3f, 0, 0}, {0, 0.1f, 0}, {0, 0, 0}}};
  params.translation = {0.1f, 0.2f, 0.3f};
  const auto exact = Posed(Poser(model, {1.0f}), Poser::ParametersOf(params));
  std::vector<float> v;
  FlamePoser<float>(model, {1.0f}).Forward(FlamePoser<float>::ParametersOf(params), v);
  for (size_t i = 0; i < v.size(); ++i) EXPECT_NEAR(v[i], exact[i], 2e-6);
}

template <class T>
void ExpectCacheIsInvisible(const FlameModel& model) {
  const FlamePoser<T> poser(model, {0.3f});
  typename FlamePoser<T>::Cache cache;
  std::vector<T> kept, fresh;
  const std::vector<T> d(3 * model.vertex_count, T(0.5));
  typename FlamePoser<T>::Parameters frame;  // first without expression
  for (int step = 0; step < 24; ++step) {
    const auto x = RandomVector(22, 70 + step, 0.5);
    if (step % 3 == 1) frame.expression.assign(x.begin(), x.begin() + step % 5);
    if (step % 4 == 1) frame.pose[step % kFlameJoints] = {T(x[4]), T(x[5]), T(x[6])};
    if (step % 4 == 2) frame.pose = {};
    if (step % 5 == 1) frame.translation = {T(x[7]), T(x[8]), T(x[9])};
    poser.Forward(frame, kept, cache);
    poser.Forward(frame, fresh);
    ASSERT_EQ(kept, fresh) << step;
    const auto a = poser.Backward(frame, d, cache), b = poser.Backward(frame, d);
    ASSERT_EQ(a.expression, b.expression) << step;
    ASSERT_EQ(a.pose, b.pose) << step;
    ASSERT_EQ(a.translation, b.translation) << step;
  }
}

TEST(FlamePose, TheCacheChangesNothing) {
  ExpectCacheIsInvisible<float>(RandomModel(700));
  ExpectCacheIsInvisible<double>(RandomModel());
}

TEST(FlamePose, SameBitsForAnyNumberOfThreads) {
  const FlameModel model = RandomModel(3000);
  const FlamePoser<float> poser(model, {0.3f});
  FlamePoser<float>::Parameters frame;
  frame.expression = {0.1f, -0.4f, 0, 0.9f};
  frame.pose = {{{0.1f, 0.4f, 0}, {0, 0, 0.2f}, {0.3f, 0, 0}, {0, 0.1f, 0}, {0, 0, 0}}};
  std::vector<float> one, many;
  poser.Forward(frame, many);
  const auto d_many = poser.Backward(frame, many);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  poser.Forward(frame, one);
  const auto d_one = poser.Backward(frame, one);
  EXPECT_EQ(one, many);
  EXPECT_EQ(d_one.expression, d_many.expression);
  EXPECT_EQ(d_one.pose, d_many.pose);
  EXPECT_EQ(d_one.translation, d_many.translation);
}

TEST(FlamePose, ARefusedFrameLeavesVerticesAndCache) {
  const FlameModel model = RandomModel();
  const Poser poser(model, {});
  Poser::Cache cache;
  std::vector<double> v;
  const Poser::Parameters good = RandomFrame(3);
  poser.Forward(good, v, cache);
  const std::vector<double> before = v;
  Poser::Parameters bad = RandomFrame(4);
  bad.translation[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(poser.Forward(bad, v, cache), Error);
  EXPECT_EQ(v, before);
  poser.Forward(good, v, cache);
  EXPECT_EQ(v, before);
}

void ExpectGradientMatchesDifferences(const Poser& poser, Poser::Parameters frame) {
  const auto weights = RandomVector(3 * poser.model().vertex_count, 9);
  const Poser::Parameters d = poser.Backward(frame, weights);
  const auto loss = [&] {
    const auto v = Posed(poser, frame);
    double sum = 0;
    for (size_t i = 0; i < v.size(); ++i) sum += weights[i] * v[i];
    return sum;
  };
  // Central differences, step 1e-5: truncation ~1e-10 of a third derivative below 10, rounding
  // 1e-16 * 30 / 1e-5.
  const auto expect = [&](double& x, double gradient, const char* what, int i) {
    const double at = x, h = 1e-5;
    x = at + h;
    const double high = loss();
    x = at - h;
    const double low = loss();
    x = at;
    EXPECT_NEAR(gradient, (high - low) / (2 * h), 1e-8) << what << i;
  };
  ASSERT_EQ(d.expression.size(), frame.expression.size());
  for (size_t k = 0; k < d.expression.size(); ++k)
    expect(frame.expression[k], d.expression[k], "expression ", k);
  for (int j = 0; j < kFlameJoints; ++j)
    for (int i = 0; i < 3; ++i) expect(frame.pose[j][i], d.pose[j][i], "pose ", 3 * j + i);
  for (int i = 0; i < 3; ++i) expect(frame.translation[i], d.translation[i], "translation ", i);
}

TEST(FlamePose, BackwardMatchesDifferences) {
  const FlameModel model = RandomModel();
  const Poser poser(model, {0.5f, -0.3f});
  for (unsigned seed : {1, 2, 3}) ExpectGradientMatchesDifferences(poser, RandomFrame(seed));
  ExpectGradientMatchesDifferences(poser, RandomFrame(4, 0));  // everything at zero
  ExpectGradientMatchesDifferences(poser, RandomFrame(5, 2));  // beyond a half turn
  Poser::Parameters few = RandomFrame(6);
  few.expression.resize(2);
  ExpectGradientMatchesDifferences(poser, few);
}

TEST(FlamePose, RefusesUnusableParameters) {
  const FlameModel model = RandomModel();
  const Poser poser(model, {});
  std::vector<double> v;
  Poser::Parameters frame;
  frame.expression = {0, 0, 0, 0, 0, 0};
  EXPECT_NO_THROW(poser.Forward(frame, v));
  frame.expression[5] = 0.1;
  EXPECT_THROW(poser.Forward(frame, v), Error);
  for (double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1e30}) {
    frame = {};
    frame.pose[2][1] = bad;
    EXPECT_THROW(poser.Forward(frame, v), Error);
    frame = {};
    frame.translation[0] = bad;
    EXPECT_THROW(poser.Forward(frame, v), Error);
    frame = {};
    frame.expression = {bad};
    EXPECT_THROW(poser.Forward(frame, v), Error);
  }
  EXPECT_THROW(Poser(model, {0, 0, 0, 1}), Error);
  EXPECT_THROW(Poser(model, {}, {1, 2, 3}), Error);
  EXPECT_THROW(poser.Backward({}, std::vector<double>{1, 2, 3}), Error);
}

TEST(FlameModel, ValidateNamesTheFault) {
  EXPECT_NO_THROW(Validate(RandomModel()));
  const auto expect = [](const char* words, auto&& spoil) {
    FlameModel model = RandomModel();
    spoil(model);
    try {
      Validate(model);
      ADD_FAILURE() << "accepted: " << words;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(words), std::string::npos) << e.what();
    }
  };
  expect("random: template_vertices", [](FlameModel& m) { m.template_vertices.pop_back(); });
  expect("pose_directions", [](FlameModel& m) { m.pose_directions[7] = NAN; });
  expect("faces", [](FlameModel& m) { m.faces[3][1] = m.vertex_count; });
  expect("faces", [](FlameModel& m) { m.faces[3][1] = -1; });
  expect("faces", [](FlameModel& m) { m.faces.clear(); });
  expect("skinning_weights", [](FlameModel& m) { m.skinning_weights[0] += 0.1f; });
  expect("joint_regressor", [](FlameModel& m) { m.joint_regressor[0] += 0.1f; });
  expect("parents", [](FlameModel& m) { m.parents[2] = 3; });
  expect("vertex_count", [](FlameModel& m) { m.vertex_count = 0; });
  expect("expression_directions", [](FlameModel& m) { ++m.expression_count; });
}

}  // namespace
}  // namespace cosplat::test
