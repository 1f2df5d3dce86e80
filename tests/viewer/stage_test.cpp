// apps/viewer/stage.h: the four views against what they must show.
#include "apps/viewer/stage.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "apps/viewer/mesh_view.h"
#include "splat/math/gaussian.h"
#include "splat/media/image_io.h"
#include "tests/support/expect_error.h"
#include "tests/support/looking_at.h"
#include "tests/viewer/viewer_fixture.h"

namespace cosplat::test {
namespace {

using viewer::Content;
using viewer::OrbitCamera;
using viewer::Pace;
using viewer::Rgb;
using viewer::Shot;
using viewer::Stage;
using viewer::View;

Shot ShotOf(const Content& content, View view, int side = 64) {
  Shot shot;
  shot.view = view;
  shot.camera = OrbitCamera(content.start).At(side, side);
  shot.background = {0.2f, 0.4f, 0.8f};
  return shot;
}

Image8 Drawn(Stage& stage, const Shot& shot) {
  Image8 image;
  stage.Draw(shot, image);
  return image;
}

Rgb At(const Image8& image, int x, int y) {
  return {image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
}

TEST(Stage, SplatsHaveThePlayersBits) {
  const Content& head = PaintedHead();
  Shot shot = ShotOf(head, View::kSplats);
  shot.face.pose[2][0] = 0.3f;
  shot.transparent = true;
  Stage stage{Content(head)};
  Player player(head.avatar->model, head.avatar->flame);
  EXPECT_EQ(Drawn(stage, shot).data, player.Render(shot.face, shot.camera).data);
}

TEST(Stage, ScenesHaveTheRasterizersBits) {
  const Content scene = SmallScene();
  Shot shot = ShotOf(scene, View::kSplats);
  shot.background = {0.3f, 0.5f, 0.7f};
  Stage stage{Content(scene)};
  const Image8 image = Drawn(stage, shot);
  const Image8 expected = ToBytes(Image(scene.scene, shot.camera).ToImage());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      EXPECT_EQ(At(image, x, y), At(expected, x, y));
      EXPECT_EQ(image.at(x, y, 3), 255);
    }
}

// All that can be seen, unless there is too little time for it.
TEST(Stage, ScenesWithLevelsKeepThePaceOfAShot) {
  Content whole = SceneOf(RandomGaussians(200000, 0, Basis::kSh, 1));
  for (float& s : whole.scene.values[kScaleLog]) s -= 2.5f;
  Content leveled = whole;
  leveled.levels = BuildLevels(std::move(leveled.scene));
  leveled.scene = {};
  EXPECT_EQ(leveled.gaussian_count(), 200000u);
  Shot shot = ShotOf(whole, View::kSplats, 256);
  shot.camera.fx *= 6;  // close: no level but the finest is fine enough
  shot.camera.fy *= 6;
  Stage all{std::move(whole)}, stage{std::move(leveled)};
  EXPECT_FALSE(all.KeepsPace(shot.view));
  EXPECT_TRUE(stage.KeepsPace(shot.view));
  const Image8 expected = Drawn(all, shot);
  const auto difference = [&](const Image8& image) {
    double sum = 0;
    for (size_t i = 0; i < image.data.size(); ++i)
      sum += std::abs(int(image.data[i]) - int(expected.data[i]));
    return sum / double(image.data.size());
  };
  EXPECT_LT(difference(Drawn(stage, shot)), 0.02);
  Shot hurried = shot;
  hurried.pace = Pace::kMoving;
  EXPECT_FALSE(shot == hurried);
  Drawn(stage, hurried);
  EXPECT_LT(difference(Drawn(stage, shot)), 0.02) << "whatever was drawn before";
  shot.view = View::kEllipsoids;
  EXPECT_FALSE(stage.KeepsPace(shot.view));
  EXPECT_EQ(Drawn(stage, shot).data, Drawn(all, shot).data);
}

// Whether the ray through a sample meets the surface at one standard deviation, in double.
bool Meets(const Gaussians& g, size_t i, const Camera& c, double x, double y) {
  const float* q = g.at(kRotation, i);
  const double n = std::sqrt(double(q[0]) * q[0] + double(q[1]) * q[1] + double(q[2]) * q[2] +
                             double(q[3]) * q[3]);
  const auto turn = math::RotationOf(math::Quat<double>{q[0] / n, q[1] / n, q[2] / n, q[3] / n});
  const double ray[3] = {(x - c.cx) / c.fx, (y - c.cy) / c.fy, 1};
  double from[3] = {}, along[3] = {};  // in units of the standard deviations
  const std::array<float, 3> eye = c.Center();
  for (int a = 0; a < 3; ++a) {
    const double scale = std::exp(double(g.at(kScaleLog, i)[a]));
    for (int k = 0; k < 3; ++k) {
      double direction = 0;
      for (int r = 0; r < 3; ++r) direction += c.rotation[3 * r + k] * ray[r];
      from[a] += turn(k, a) * (double(g.at(kPosition, i)[k]) - eye[k]) / scale;
      along[a] += turn(k, a) * direction / scale;
    }
  }
  double aa = 0, ab = 0, bb = 0;
  for (int a = 0; a < 3; ++a) {
    aa += along[a] * along[a];
    ab += along[a] * from[a];
    bb += from[a] * from[a];
  }
  return ab * ab >= aa * (bb - 1);
}

TEST(Stage, EllipsoidsCoverWhatTheirRaysMeet) {
  Gaussians g = RandomGaussians(12, 0, Basis::kSh, 9);
  for (size_t i = 0; i < g.size(); ++i) {
    *g.at(kOpacityLogit, i) = i == 3 ? -3.0f : 2.0f;  // one is too faint
    g.at(kScaleLog, i)[i % 3] -= 4;                   // flat, as trained ones are
  }
  const Camera camera = LookingAt({0.4f, 1, -4}, {0, 0, 0}, 96);
  viewer::SurfaceBuffer buffer;
  buffer.Clear(camera.width, camera.height);
  viewer::DrawEllipsoids(ViewOf(g), camera, buffer);
  const Camera samples = viewer::SampleCamera(camera);
  int covered = 0, wrong = 0;
  for (int y = 0; y < buffer.height; ++y)
    for (int x = 0; x < buffer.width; ++x) {
      bool expected = false;
      for (size_t i = 0; i < g.size(); ++i)
        expected = expected || (i != 3 && Meets(g, i, samples, x + 0.5, y + 0.5));
      const bool drawn = std::isfinite(buffer.depth[size_t(y) * size_t(buffer.width) + size_t(x)]);
      covered += expected;
      wrong += expected != drawn;
    }
  EXPECT_GT(covered, 500);
  EXPECT_EQ(wrong, 0);
}

TEST(Stage, TheNearerEllipsoidHidesTheOther) {
  Gaussians g = RandomGaussians(2, 0, Basis::kSh, 1);
  for (size_t i = 0; i < 2; ++i) {
    for (int k = 0; k < 3; ++k) {
      g.at(kPosition, i)[k] = k == 2 ? (i == 0 ? 0.5f : -0.5f) : 0;
      g.at(kScaleLog, i)[k] = std::log(0.3f);
      g.at(kColorDc, i)[k] = (k == 0) == (i == 0) ? 1.7f : -1.7f;  // red; cyan
    }
    *g.at(kOpacityLogit, i) = 3;
  }
  viewer::SurfaceBuffer buffer;
  const Camera camera = LookingAt({0, 0, -4}, {0, 0, 0}, 32);
  buffer.Clear(32, 32);
  viewer::DrawEllipsoids(ViewOf(g), camera, buffer);
  const size_t middle = 32 * 64 + 32;
  EXPECT_NEAR(buffer.depth[middle], 4 - 0.5 - 0.3, 1e-2);
  EXPECT_GT(buffer.color[middle][1], 100);  // the one at z = -0.5
  EXPECT_LT(buffer.color[middle][0], 20);
}

TEST(Stage, TrianglesShowTheirCounts) {
  Content head = PaintedHead();
  const size_t faces = head.avatar->model.mesh.faces.size();
  std::fill(head.avatar->model.embedding.triangle.begin(),
            head.avatar->model.embedding.triangle.end(),
            0);
  const std::vector<int> counts =
      viewer::CountPerFace(head.avatar->model.embedding.triangle, faces);
  EXPECT_EQ(counts[0], int(head.avatar->model.size()));
  EXPECT_EQ(counts[1], 0);
  const std::vector<Rgb> colors = viewer::CountColors(counts);
  EXPECT_EQ(colors[0], viewer::ScaleColor(1));
  EXPECT_EQ(colors[1], viewer::kNoneColor);
  Shot shot = ShotOf(head, View::kTriangles);
  shot.transparent = true;
  Stage stage{std::move(head)};
  const Image8 image = Drawn(stage, shot);
  EXPECT_EQ(image.at(1, 1, 3), 0);
  EXPECT_EQ(image.at(32, 32, 3), 255);
  const Rgb middle = At(image, 32, 32);  // of the face, which has none: grey in some light
  EXPECT_LE(middle[0], viewer::kNoneColor[0]);
  EXPECT_GE(middle[0], viewer::kNoneColor[0] / 3);
}

TEST(Stage, WireHasEdgesOverDarkFaces) {
  Shot shot = ShotOf(PaintedHead(), View::kWire, 256);
  shot.camera.fx *= 4;
  shot.camera.fy *= 4;
  Stage stage{Content(PaintedHead())};
  const Image8 image = Drawn(stage, shot);
  int bright = 0, dark = 0;
  for (size_t i = 0; i < image.pixels(); ++i) {
    bright += image.data[4 * i + 2] > 200;
    dark += image.data[4 * i + 2] < 60;
  }
  EXPECT_GT(bright, 2000);
  EXPECT_GT(dark, 2000);
}

TEST(Stage, SameBitsForAnyNumberOfThreads) {
  for (const View view : {View::kEllipsoids, View::kTriangles, View::kWire}) {
    const Shot shot = ShotOf(PaintedHead(), view);
    Stage several{Content(PaintedHead())}, one{Content(PaintedHead())};
    const Image8 image = Drawn(several, shot);
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(image.data, Drawn(one, shot).data);
  }
}

TEST(Stage, RefusesWhatItCannotDraw) {
  Stage scene{SmallScene()};
  const Shot mesh = ShotOf(PaintedHead(), View::kWire);
  ExpectError([&] { Drawn(scene, mesh); }, {"scene", "view", "wire is only available for avatars"});
  Stage head{Content(PaintedHead())};
  Shot flat = ShotOf(PaintedHead(), View::kSplats);
  flat.camera.height = 0;
  ExpectError([&] { Drawn(head, flat); }, {"head", "image", "no pixels"});
  Shot broken = ShotOf(PaintedHead(), View::kWire);
  broken.face.pose[1][0] = NAN;
  ExpectError([&] { Drawn(head, broken); }, {"pose", "nan"});
  EXPECT_EQ(Drawn(head, ShotOf(PaintedHead(), View::kWire)).width, 64);  // it goes on
}

TEST(Shot, EqualitySeesEveryChange) {
  const Shot shot = ShotOf(PaintedHead(), View::kSplats);
  EXPECT_TRUE(shot == shot);
  std::vector<Shot> others(7, shot);
  others[0].view = View::kWire;
  others[1].face.expression = {0.1f};
  others[2].face.translation[1] = 1;
  others[3].camera.translation[0] += 1e-3f;
  others[4].camera.width += 1;
  others[5].background[2] = 0;
  others[6].transparent = true;
  for (const Shot& other : others) EXPECT_FALSE(shot == other);
}

TEST(ColorScale, BrightnessRisesAndEndsAreExact) {
  float last = 0;
  for (int i = 0; i <= 20; ++i) {
    const Rgb c = viewer::ScaleColor(float(i) / 20);
    const float brightness = 0.3f * c[0] + 0.59f * c[1] + 0.11f * c[2];
    EXPECT_GT(brightness, last);
    last = brightness;
  }
  EXPECT_EQ(viewer::CountPlace(1, 64), 0);
  EXPECT_EQ(viewer::CountPlace(64, 64), 1);
  EXPECT_NEAR(viewer::CountPlace(8, 64), 0.5f, 1e-6);
  EXPECT_EQ(viewer::CountPlace(1, 1), 1);
}

}  // namespace
}  // namespace cosplat::test
