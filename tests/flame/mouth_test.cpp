// flame/mouth.h: what is added behind the lips, what it moves with, and that closed lips hide it.
#include "flame/mouth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include "assets/head/motion.h"
#include "assets/head/procedural_head.h"
#include "assets/head/raster.h"
#include "flame/model.h"
#include "flame/pose.h"
#include "flame/topology.h"
#include "tests/flame/hollow_head.h"

namespace cosplat::test {
namespace {

constexpr int kJaw = 2;

const FlameModel& Hollow() {
  static const FlameModel model = HollowHead();
  return model;
}
const FlameModel& Filled() {
  static const FlameModel model = WithMouth(Hollow());
  return model;
}

using Frame = FlamePoser<float>::Parameters;

Frame RestFrame() {
  Frame frame;
  frame.expression.assign(size_t(Hollow().expression_count), 0.0f);
  return frame;
}
std::vector<float> Posed(const FlameModel& model, const Frame& frame) {
  std::vector<float> vertices;
  FlamePoser<float>(model, {}).Forward(frame, vertices);
  return vertices;
}

// Green: faces that were added.
class Added : public procedural::Shader {
 public:
  explicit Added(const FlameModel& model) : model_(model) {}
  std::array<float, 3> Shade(const procedural::SurfacePoint& p) const override {
    return {0, model_.faces[size_t(p.face)][0] >= model_.own_vertex_count() ? 1.0f : 0.0f, 0};
  }

 private:
  const FlameModel& model_;
};
double PixelsOfMouth(const FlameModel& model, const Frame& frame, float azimuth = 0) {
  const Camera camera = procedural::OrbitCamera(azimuth, 0, 0.9f, 256);
  const Image8 image =
      procedural::Rasterize(Posed(model, frame), model.faces, camera, Added(model));
  double seen = 0;
  for (size_t i = 0; i < image.data.size(); i += 4)
    if (image.data[i + 3] > 0) seen += image.data[i + 1] / 255.0;
  return seen;
}

// The largest change of a distance between two of the vertices [first, first + count).
float Deformation(const std::vector<float>& a, const std::vector<float>& b, int first, int count) {
  const auto distance = [](const std::vector<float>& v, int i, int j) {
    return std::hypot(v[size_t(3 * i)] - v[size_t(3 * j)],
                      v[size_t(3 * i + 1)] - v[size_t(3 * j + 1)],
                      v[size_t(3 * i + 2)] - v[size_t(3 * j + 2)]);
  };
  float max = 0;
  for (int i = first; i < first + count; ++i)
    max = std::max(max, std::abs(distance(a, i, first) - distance(b, i, first)));
  return max;
}

TEST(Mouth, IsAddedBehindFlamesVertices) {
  const FlameModel &m = Filled(), &own = Hollow();
  EXPECT_NO_THROW(Validate(m));
  ASSERT_GT(m.mouth.upper_teeth, 0);
  ASSERT_GT(m.mouth.lower_teeth, 0);
  ASSERT_GT(m.mouth.bowl, 0);
  EXPECT_EQ(m.own_vertex_count(), own.vertex_count);
  EXPECT_TRUE(std::equal(own.faces.begin(), own.faces.end(), m.faces.begin()));
  EXPECT_EQ(BuildTopology(m.name, m.faces, m.vertex_count).component_count,
            BuildTopology(own.name, own.faces, own.vertex_count).component_count + 3);
  // FLAME's own vertices move as before.
  Frame frame = RestFrame();
  frame.expression[0] = 1;
  frame.pose = {{{0.1f, 0.2f, 0}, {0.1f, 0, 0.1f}, {0.3f, 0, 0}, {}, {}}};
  const std::vector<float> before = Posed(own, frame), after = Posed(m, frame);
  for (size_t i = 0; i < before.size(); ++i) ASSERT_NEAR(before[i], after[i], 1e-7f) << i;
}

TEST(Mouth, IsNotAddedTwiceNorToAHeadThatHasOne) {
  EXPECT_EQ(WithMouth(Filled()).vertex_count, Filled().vertex_count);
  const FlameModel made = MakeProceduralHead();
  EXPECT_EQ(WithMouth(made).vertex_count, made.vertex_count);
  FlameModel sphere = Hollow();  // a closed head: no hole to fill
  sphere.faces = {{0, 1, 2}};
  EXPECT_EQ(WithMouth(sphere).vertex_count, sphere.vertex_count);
}

TEST(Mouth, UpperTeethFollowTheHeadAndLowerTeethTheJaw) {
  const MouthParts& parts = Filled().mouth;
  const int upper = Filled().own_vertex_count(), lower = upper + parts.upper_teeth;
  const std::vector<float> rest = Posed(Filled(), RestFrame());
  Frame frame = RestFrame();
  frame.pose[kJaw][0] = 0.3f;
  for (float& e : frame.expression) e = 0.5f;
  const std::vector<float> open = Posed(Filled(), frame);
  for (int i = 3 * upper; i < 3 * lower; ++i) EXPECT_EQ(open[size_t(i)], rest[size_t(i)]) << i;
  EXPECT_LT(open[size_t(3 * lower + 1)], rest[size_t(3 * lower + 1)] - 0.005f);
  EXPECT_LT(Deformation(rest, open, lower, parts.lower_teeth), 1e-6f) << "teeth are rigid";
}

TEST(Mouth, ShowsBetweenOpenLips) {
  Frame frame = RestFrame();
  frame.pose[kJaw][0] = 0.25f;
  EXPECT_GT(PixelsOfMouth(Filled(), frame), 200);
}

TEST(Mouth, DoesNotShowThroughClosedLips) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  for (int k = 0; k < 64; ++k) {
    Frame frame = RestFrame();
    if (k > 0)  // all that leaves the lips shut
      for (const Expression e : {Expression::kSmileLeft,
                                 Expression::kSmileRight,
                                 Expression::kFrown,
                                 Expression::kMouthShift,
                                 Expression::kBrowUp,
                                 Expression::kBlinkLeft,
                                 Expression::kBlinkRight})
        frame.expression[size_t(e)] = std::clamp(normal(random), -1.0f, 1.0f);
    frame.pose[1] = {0.1f * normal(random), 0.1f * normal(random), 0.1f * normal(random)};
    for (const float azimuth : {-0.6f, 0.0f, 0.6f})
      ASSERT_LT(PixelsOfMouth(Filled(), frame, azimuth), 12);
  }
}

TEST(Mouth, OfFlameShowsBetweenOpenLipsOnly) {
  const std::string path = COSPLAT_SOURCE_DIR "/../shared/data/tracked/flame_for_tracks.npz";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path << ": licensed data";
  const FlameModel flame = WithMouth(LoadFlameModel(path));
  ASSERT_GT(flame.mouth.count(), 0);
  Frame frame;
  for (const float azimuth : {-0.6f, 0.0f, 0.6f})
    EXPECT_LT(PixelsOfMouth(flame, frame, azimuth), 12) << azimuth;
  frame.pose[kJaw][0] = 0.25f;
  EXPECT_GT(PixelsOfMouth(flame, frame), 100);
}

TEST(StaticOffset, KeepsWhatVhapHasForTeeth) {
  const size_t own = size_t(Filled().own_vertex_count());
  std::vector<float> offset(3 * (own + 120));
  offset[0] = 1;
  const auto set_row = [&](int row, float x) {
    for (int i = 0; i < 15; ++i) offset[3 * (own + size_t(15 * row + i))] = x;
  };
  for (const int row : {0, 2, 4, 5}) set_row(row, 2);  // of the upper teeth
  for (const int row : {1, 3, 6, 7}) set_row(row, 3);
  EXPECT_EQ(StaticOffsetFor(Hollow(), offset),
            std::vector<float>(offset.begin(), offset.begin() + long(3 * own)));
  const std::vector<float> filled = StaticOffsetFor(Filled(), offset);
  ASSERT_EQ(filled.size(), 3 * size_t(Filled().vertex_count));
  const MouthParts& parts = Filled().mouth;
  EXPECT_EQ(filled[0], 1);
  EXPECT_NEAR(filled[3 * own], 2, 1e-5);
  EXPECT_NEAR(filled[3 * (own + size_t(parts.upper_teeth))], 3, 1e-5);
  EXPECT_EQ(filled[3 * (own + size_t(parts.upper_teeth + parts.lower_teeth))], 0);
  // Without teeth, and of a size that fits nothing.
  offset.resize(3 * own);
  EXPECT_EQ(StaticOffsetFor(Filled(), offset).size(), filled.size());
  EXPECT_EQ(StaticOffsetFor(Filled(), {}), std::vector<float>{});
  EXPECT_EQ(StaticOffsetFor(Filled(), {1, 2, 3}), (std::vector<float>{1, 2, 3}));
}

}  // namespace
}  // namespace cosplat::test
