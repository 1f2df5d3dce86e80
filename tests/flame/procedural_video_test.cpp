// assets/head/video.h: the demonstration video and its track.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <filesystem>

#include "assets/head/raster.h"
#include "assets/head/shading.h"
#include "assets/head/video.h"
#include "flame/model.h"
#include "flame/pose.h"
#include "flame/track.h"
#include "splat/base/error.h"
#include "splat/media/image_io.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

const ProceduralHead& Head() {
  static const ProceduralHead head = MakeProceduralHeadParts();
  return head;
}

std::vector<float> Posed(const FlameParams& params) {
  const FlamePoser<float> poser(Head().model, {});
  std::vector<float> vertices;
  poser.Forward(FlamePoser<float>::ParametersOf(params), vertices);
  return vertices;
}

TEST(ProceduralVideo, ImagesDoNotDependOnTheNumberOfThreads) {
  const auto script = procedural::MakeScript({30, 5, 128, 3});
  const auto vertices = Posed(script[20].params);
  auto render = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return RenderProceduralHead(Head(), vertices, script[20].params, script[20].camera);
  };
  const Image8 one = render(1);
  EXPECT_EQ(one.data, render(2).data);
  EXPECT_EQ(one.data, render(5).data);
}

// Brightness = weight of one vertex, brightest where the rasteriser draws it.
class Tip : public procedural::Shader {
 public:
  explicit Tip(int vertex) : vertex_(vertex) {}
  std::array<float, 3> Shade(const procedural::SurfacePoint& p) const override {
    const auto& face = Head().model.faces[p.face];
    for (int k = 0; k < 3; ++k)
      if (face[k] == vertex_ && !p.back) return {p.barycentrics[k], 0, 0};
    return {0, 0, 0};
  }

 private:
  int vertex_;
};

// The same camera through a magnifying glass held before the point (x, y) of the image.
Camera Magnified(const Camera& camera, double x, double y, float zoom, int size) {
  Camera c = camera;
  c.width = c.height = size;
  c.fx *= zoom;
  c.fy *= zoom;
  c.cx = float(size / 2.0 + zoom * (camera.cx - x));
  c.cy = float(size / 2.0 + zoom * (camera.cy - y));
  return c;
}

TEST(ProceduralVideo, VerticesAreDrawnWhereTheTrackPutsThem) {
  constexpr float kZoom = 8;
  const auto script = procedural::MakeScript({30, 5, 512, 0});
  int seen = 0;
  for (int f : {0, 13, 27}) {
    const auto vertices = Posed(script[f].params);
    const Camera& camera = script[f].camera;
    for (int v = 7; v < Head().model.vertex_count; v += 83) {
      double p[3];
      for (int i = 0; i < 3; ++i) {
        p[i] = camera.translation[i];
        for (int k = 0; k < 3; ++k)
          p[i] += double(camera.rotation[3 * i + k]) * vertices[3 * v + k];
      }
      const double x = camera.fx * p[0] / p[2] + camera.cx, y = camera.fy * p[1] / p[2] + camera.cy;
      const Image8 image = procedural::Rasterize(
          vertices, Head().model.faces, Magnified(camera, x, y, kZoom, 48), Tip(v));
      int brightest = 0, at_x = 0, at_y = 0;
      for (int row = 0; row < image.height; ++row)
        for (int column = 0; column < image.width; ++column)
          if (image.at(column, row, 3) == 255 && image.at(column, row, 0) > brightest)
            brightest = image.at(column, row, 0), at_x = column, at_y = row;
      if (brightest < 235) continue;  // hidden in this frame
      ++seen;
      // In pixels of the video: well below a quarter.
      EXPECT_NEAR((at_x + 0.5 - 24) / kZoom, 0, 0.2) << f << " " << v;
      EXPECT_NEAR((at_y + 0.5 - 24) / kZoom, 0, 0.2) << f << " " << v;
    }
  }
  EXPECT_GT(seen, 50);
}

TEST(ProceduralVideo, HighlightsMoveWithTheView) {
  FlameParams rest;
  rest.expression.assign(kExpressionCount, 0.0f);
  procedural::ShadedPose pose;
  pose.vertices = Head().mesh.positions;
  pose.posed_from_rest = {{1, 0, 0, 0, 1, 0, 0, 0, 1}};
  const procedural::HeadShader ahead(Head(), pose, {0, 0, 0.9f});
  const procedural::HeadShader aside(Head(), pose, {0.5f, 0.25f, 0.7f});
  float max = 0, min = 1;
  for (size_t f = 0; f < Head().mesh.faces.size(); ++f) {
    const procedural::SurfacePoint point{int(f), {0.3f, 0.3f, 0.4f}, false};
    const float change = std::abs(ahead.Shade(point)[1] - aside.Shade(point)[1]);
    max = std::max(max, change);
    min = std::min(min, change);
  }
  EXPECT_GT(max, 0.10f);
  EXPECT_LT(min, 0.004f);
}

TEST(ProceduralVideo, ScriptKeepsWithinRangeAndSurprisesAtTheEnd) {
  const auto script = procedural::MakeScript({360, 60, 512, 0});
  std::vector<float> trained(kExpressionCount, 0.0f), tested(kExpressionCount, 0.0f);
  float yaw = 0, pitch = 0;
  for (int f = 0; f < 360; ++f) {
    const FlameParams& p = script[f].params;
    yaw = std::max(yaw, std::abs(p.pose[0][1]));
    pitch = std::max(pitch, std::abs(p.pose[0][0]));
    for (int e = 0; e < kExpressionCount; ++e) {
      EXPECT_GE(p.expression[e], -0.6f);
      EXPECT_LE(p.expression[e], 1.6f);
      float& max = (f < 300 ? trained : tested)[e];
      max = std::max(max, std::abs(p.expression[e]));
    }
    EXPECT_GE(p.pose[2][0], 0);
    EXPECT_LT(p.pose[2][0], 0.26f);
  }
  EXPECT_GT(yaw, 0.45f);
  EXPECT_LT(yaw, 0.62f);
  EXPECT_GT(pitch, 0.17f);
  EXPECT_LT(pitch, 0.27f);
  int unseen = 0;
  for (int e = 0; e < kExpressionCount; ++e) unseen += trained[e] == 0 && tested[e] > 0.3f;
  EXPECT_GE(unseen, 3);
  EXPECT_GT(trained[int(Expression::kBlinkLeft)], 0.9f);
}

TEST(ProceduralVideo, AFrontalScriptIsTestedFromAllAround) {
  const auto script = procedural::MakeScript({60, 12, 64, 0, true});
  std::vector<double> turned;
  for (const procedural::ScriptFrame& frame : script)
    turned.push_back(DegreesTurned(frame.params, frame.camera));
  for (size_t f = 0; f < 48; ++f) {
    EXPECT_LT(turned[f], 12) << f;
    EXPECT_EQ(script[f].camera.rotation, script[0].camera.rotation);
  }
  for (size_t f = 48; f < 60; ++f)
    EXPECT_NEAR(turned[f], std::abs(procedural::kTestAzimuths[f - 48]), 12) << f;
}

TEST(ProceduralVideo, FolderIsReadBackAsWritten) {
  const TemporaryFolder folder;
  MakeHeadOptions options;
  options.frames = 6;
  options.test_frames = 2;
  options.size = 64;
  std::vector<int> reported;
  WriteProceduralVideo(folder / "video", options, [&](int done, int total) {
    EXPECT_EQ(total, 6);
    reported.push_back(done);
  });
  EXPECT_EQ(reported, (std::vector<int>{1, 2, 3, 4, 5, 6}));

  const TrackedVideo video = LoadTrackedVideo(folder / "video", {});
  EXPECT_EQ(video.layout, "imavatar");
  EXPECT_TRUE(video.skipped.empty());
  ASSERT_EQ(video.train.size(), 4u);
  ASSERT_EQ(video.test.size(), 2u);
  EXPECT_EQ(video.shape.size(), size_t(Head().model.shape_count));
  const auto script = procedural::MakeScript({6, 2, 64, 0});
  for (int f = 0; f < 6; ++f) {
    const TrackedFrame& frame = f < 4 ? video.train[f] : video.test[f - 4];
    EXPECT_EQ(frame.params.expression, script[f].params.expression);
    EXPECT_EQ(frame.params.pose, script[f].params.pose);
    EXPECT_NEAR(frame.camera.fx, script[f].camera.fx, 1e-4);
    EXPECT_NEAR(frame.camera.cy, script[f].camera.cy, 1e-5);
    for (int i = 0; i < 9; ++i)
      EXPECT_NEAR(frame.camera.rotation[i], script[f].camera.rotation[i], 1e-6);
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(frame.camera.translation[i], script[f].camera.translation[i], 1e-6);
    const Image8 image = LoadTrackedImage(video, frame);
    const auto vertices = Posed(script[f].params);
    const Image8 again = RenderProceduralHead(Head(), vertices, script[f].params, script[f].camera);
    EXPECT_EQ(image.data, again.data);
    const Image8 mask = ReadImage(folder / ("video/mask/" + std::to_string(f + 1) + ".png"));
    ASSERT_EQ(mask.channels, 1);
    for (size_t i = 0; i < mask.data.size(); ++i) EXPECT_EQ(mask.data[i], image.data[4 * i + 3]);
  }
  const FlameModel model = LoadFlameModel(folder / "video/model.npz");
  EXPECT_EQ(model.template_vertices, Head().model.template_vertices);
  EXPECT_EQ(model.faces, Head().model.faces);
  EXPECT_EQ(model.expression_directions, Head().model.expression_directions);
  EXPECT_TRUE(model.redistributable);
}

TEST(ProceduralVideo, RefusesBadOptionsBeforeWritingAnything) {
  const TemporaryFolder folder;
  auto attempt = [&](int frames, int test_frames, int size) {
    MakeHeadOptions options;
    options.frames = frames;
    options.test_frames = test_frames;
    options.size = size;
    WriteProceduralVideo(folder / "video", options);
  };
  EXPECT_THROW(attempt(0, 0, 64), Error);
  EXPECT_THROW(attempt(5, 5, 64), Error);
  EXPECT_THROW(attempt(5, -1, 64), Error);
  EXPECT_THROW(attempt(5, 1, 8), Error);
  EXPECT_FALSE(std::filesystem::exists(folder / "video"));
}

}  // namespace
}  // namespace cosplat::test
