#include "apps/study/face_points/cast_points.h"

#include <gtest/gtest.h>

#include <cmath>

#include "assets/head/procedural_head.h"
#include "flame/pose.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

constexpr int kSize = 400;

Camera FrontCamera() {
  Camera camera;
  camera.width = camera.height = kSize;
  camera.fx = camera.fy = 800;
  camera.cx = camera.cy = kSize / 2;
  camera.rotation = {1, 0, 0, 0, -1, 0, 0, 0, -1};
  camera.translation = {0, 0, 0.6f};
  return camera;
}

std::array<float, 3> PlaceOf(const std::vector<float>& vertices, const EmbeddedLandmark& point) {
  std::array<float, 3> place{};
  for (size_t k = 0; k < 3; ++k)
    for (size_t i = 0; i < 3; ++i)
      place[i] += float(point.barycentric[k]) * vertices[3 * size_t(point.vertices[k]) + i];
  return place;
}

float DistanceOf(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

// A person who turns, and a detector that is right.
struct Filmed {
  FlameModel model = MakeHeadForPeople();
  TrackedVideo video;
  LandmarkVideo marks;

  Filmed() {
    video.source = "made";
    marks.file = "made.json";
    marks.width = marks.height = kSize;
    const FlamePoser<float> poser(model, {});
    for (int f = 0; f < 7; ++f) {
      TrackedFrame frame;
      frame.name = std::to_string(f);
      frame.timestep = f;
      frame.camera = FrontCamera();
      frame.params.pose[1] = {0.04f * float(f % 3 - 1), 0.08f * float(f - 3), 0};
      frame.params.expression.resize(size_t(model.expression_count));
      std::vector<float> vertices;
      poser.Forward(FlamePoser<float>::ParametersOf(frame.params), vertices);
      LandmarkFrame seen;
      seen.name = frame.name;
      seen.frame = f;
      seen.faces.resize(1);
      seen.faces[0].points.assign(478, {0, 0});
      for (const EmbeddedLandmark& point : model.landmarks) {
        const auto [x, y, z] = PlaceOf(vertices, point);
        const double scale = 800 / (0.6 - z);
        seen.faces[0].points[size_t(point.landmark)] = {kSize / 2 + scale * x,
                                                        kSize / 2 - scale * y};
      }
      marks.frames.push_back(seen);
      video.train.push_back(frame);
    }
  }
};

TEST(CastPoints, FindsThePointsOfADetectorAgain) {
  Filmed filmed;
  const LandmarkEmbedding truth = filmed.model.landmarks;
  // Wrong by a part of a triangle; points on eyes and in the median plane stay.
  const std::vector<float>& rest = filmed.model.template_vertices;
  for (EmbeddedLandmark& point : filmed.model.landmarks) {
    const float* const weights =
        &filmed.model.skinning_weights[kFlameJoints * size_t(point.vertices[0])];
    if (weights[3] + weights[4] < 0.5f && std::abs(PlaceOf(rest, point)[0]) > 0.004f)
      point.barycentric = {1.0 / 3, 1.0 / 3, 1.0 / 3};
  }
  const std::vector<CastPlaces> people(2, CastPoints(filmed.model, filmed.video, filmed.marks));
  const PlacedPoints placed = PlaceOnSkin(filmed.model, people);
  EXPECT_GT(placed.seen, int(truth.size()) * 9 / 10);
  EXPECT_LT(placed.people, 1e-9);
  double squares = 0, before = 0;
  for (size_t p = 0; p < truth.size(); ++p) {
    const std::array<float, 3> place = PlaceOf(rest, truth[p]);
    squares += std::pow(DistanceOf(PlaceOf(rest, placed.landmarks[p]), place), 2);
    before += std::pow(DistanceOf(PlaceOf(rest, filmed.model.landmarks[p]), place), 2);
  }
  EXPECT_LT(std::sqrt(squares / double(truth.size())), 5e-4);  // metres, most of it at lids
  EXPECT_LT(squares, 0.5 * before);
}

TEST(CastPoints, NamesFilesThatDoNotBelongTogether) {
  Filmed filmed;
  LandmarkVideo of_another = filmed.marks;
  for (LandmarkFrame& frame : of_another.frames)
    for (std::array<double, 2>& point : frame.faces[0].points) point[0] += 100;
  test::ExpectError([&] { CastPoints(filmed.model, filmed.video, of_another); },
                    {"made.json", "points", "made", "another video"});
  filmed.marks.width = 300;
  test::ExpectError([&] { CastPoints(filmed.model, filmed.video, filmed.marks); },
                    {"made.json", "300x400", "made", "400x400"});
  for (LandmarkFrame& frame : filmed.marks.frames) frame.name += "x";
  test::ExpectError([&] { CastPoints(filmed.model, filmed.video, filmed.marks); },
                    {"made.json", "0 frames", "made", "at least 3"});
}

}  // namespace
}  // namespace cosplat
