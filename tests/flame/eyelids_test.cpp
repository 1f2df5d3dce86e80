// flame/eyelids.h: lids that cover the eye, and tracks that move them.
#include "flame/eyelids.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "assets/head/procedural_head.h"
#include "assets/head/raster.h"
#include "assets/head/video.h"
#include "flame/model.h"
#include "flame/pose.h"
#include "flame/track.h"
#include "tests/support/expect_error.h"

namespace cosplat::test {
namespace {

const FlameModel& Lidded() {
  static const FlameModel model = WithEyelids(MakeProceduralHead());
  return model;
}

// Red: eyeballs.
class Eyes : public procedural::Shader {
 public:
  explicit Eyes(const FlameModel& model) : model_(model) {}
  std::array<float, 3> Shade(const procedural::SurfacePoint& p) const override {
    const size_t v = size_t(model_.faces[size_t(p.face)][0]);
    const float* weights = &model_.skinning_weights[kFlameJoints * v];
    return {weights[3] + weights[4] > 0.5f ? 1.0f : 0.0f, 0, 0};
  }

 private:
  const FlameModel& model_;
};
double PixelsOfEyes(const FlameModel& model, float left, float right, float azimuth = 0) {
  FlamePoser<float>::Parameters frame;
  frame.expression.assign(size_t(model.expression_count), 0.0f);
  frame.expression[frame.expression.size() - 2] = left;
  frame.expression.back() = right;
  std::vector<float> vertices;
  FlamePoser<float>(model, {}).Forward(frame, vertices);
  const Camera camera = procedural::OrbitCamera(azimuth, 0, 0.9f, 256);
  const Image8 image = procedural::Rasterize(vertices, model.faces, camera, Eyes(model));
  double seen = 0;
  for (size_t i = 0; i < image.data.size(); i += 4)
    if (image.data[i + 3] > 0) seen += image.data[i] / 255.0;
  return seen;
}

TEST(Eyelids, CoverTheEye) {
  const double open = PixelsOfEyes(Lidded(), 0, 0), half = PixelsOfEyes(Lidded(), 0.5f, 0.5f);
  EXPECT_GT(open, 150);
  EXPECT_LT(half, 0.75 * open);
  EXPECT_GT(half, 0.25 * open);
  EXPECT_NEAR(PixelsOfEyes(Lidded(), 1, 0), open / 2, 0.1 * open);
  for (const float azimuth : {-0.5f, 0.0f, 0.5f})
    EXPECT_LT(PixelsOfEyes(Lidded(), 1, 1, azimuth), 0.03 * open) << azimuth;
}

TEST(Eyelids, OfFlameCoverItsEyes) {
  const std::string path = COSPLAT_SOURCE_DIR "/../shared/data/tracked/flame_for_tracks.npz";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path << ": licensed data";
  const FlameModel flame = WithEyelids(LoadFlameModel(path));
  const double open = PixelsOfEyes(flame, 0, 0);
  EXPECT_GT(open, 100);
  EXPECT_NEAR(PixelsOfEyes(flame, 1, 0), open / 2, 0.1 * open);
  for (const float azimuth : {-0.5f, 0.0f, 0.5f})
    EXPECT_LT(PixelsOfEyes(flame, 1, 1, azimuth), 0.05 * open) << azimuth;
}

TEST(Eyelids, MoveTheirOwnSideOnly) {
  const FlameModel& m = Lidded();
  EXPECT_NO_THROW(Validate(m));
  EXPECT_EQ(m.expression_count, MakeProceduralHead().expression_count + 2);
  EXPECT_EQ(WithEyelids(m).expression_count, m.expression_count);
  const size_t row = 3 * size_t(m.vertex_count);
  const float* left = &m.expression_directions[size_t(m.expression_count - 2) * row];
  size_t moved = 0;
  for (size_t v = 0; v < size_t(m.vertex_count); ++v) {
    for (size_t axis = 0; axis < 3; ++axis) {
      if (m.template_vertices[3 * v] < 0) EXPECT_EQ(left[3 * v + axis], 0) << v;
      if (m.skinning_weights[kFlameJoints * v + 3] > 0.5f) EXPECT_EQ(left[3 * v + axis], 0) << v;
    }
    moved += left[3 * v + 1] != 0;
    EXPECT_LT(left[3 * v + 1], 0.001f);  // down
    EXPECT_GT(left[3 * v + 1], -0.02f);
  }
  EXPECT_GT(moved, 50u);
}

TEST(Eyelids, ShutEyesAreAnError) {
  FlameModel blind = MakeProceduralHead();
  for (size_t v = 0; v < size_t(blind.vertex_count); ++v)  // no eyeballs
    for (const int joint : {3, 4}) blind.skinning_weights[kFlameJoints * v + size_t(joint)] = 0;
  ExpectError([&] { WithEyelids(blind); }, {"procedural", "eyelids", "joint 3"});
}

TEST(Eyelids, OfATrackBecomeExpression) {
  TrackedVideo video;
  video.train.resize(2);
  video.test.resize(1);
  EXPECT_FALSE(TracksEyelids(video));
  video.test[0].params.eyelids = {0.25f, 0.5f};
  EXPECT_TRUE(TracksEyelids(video));
  video.train[0].params.expression = {7};
  video.train[1].params.expression.assign(1000, 1);
  const FlameModel plain = MakeProceduralHead();
  EyelidsToExpression(plain, video);  // a model without lids: nothing happens
  EXPECT_TRUE(TracksEyelids(video));
  EyelidsToExpression(Lidded(), video);
  EXPECT_FALSE(TracksEyelids(video));
  const size_t own = size_t(plain.expression_count);
  for (const TrackedFrame& frame : {video.train[0], video.train[1], video.test[0]})
    EXPECT_EQ(frame.params.expression.size(), own + 2);
  EXPECT_EQ(video.train[0].params.expression[0], 7);
  EXPECT_EQ(video.train[1].params.expression[own], 0) << "a coefficient that the model lacks";
  EXPECT_EQ(video.test[0].params.expression[own], 0.25f);
  EXPECT_EQ(video.test[0].params.expression[own + 1], 0.5f);
  EyelidsFromExpression(Lidded(), video);
  EXPECT_EQ(video.test[0].params.expression.size(), own);
  EXPECT_EQ(video.test[0].params.eyelids, (std::array<float, 2>{0.25f, 0.5f}));
}

}  // namespace
}  // namespace cosplat::test
