// CheckScene on renderings with alpha: their silhouettes are all that tells whether images are the
// cameras'.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "splat/io/scene_check.h"
#include "tests/street/findings.h"
#include "tests/street/nerf_scene.h"

namespace cosplat::test {
namespace {

using Point = std::array<double, 3>;

struct Ball {
  Point center;
  double radius;
};

// Renderings of balls by cameras that look at a point each, z up.
struct BallScene {
  static constexpr int kSide = 128;
  static constexpr double kFocal = 170;
  TemporaryFolder folder;
  Json json = {{"fl_x", kFocal}, {"fl_y", kFocal}, {"w", kSide}, {"h", kSide}};

  explicit BallScene(std::vector<Ball> balls) : balls_(std::move(balls)) {
    json["frames"] = Json::array();
  }

  // `count` cameras about a point, from all around and above, `near` and 0.4 more from it.
  void Film(const Point& aim, int count, double near = 2.8) {
    for (int i = 0; i < count; ++i) {
      const double turn = 2.4 * i, up = 0.2 + 0.9 * (i * 5 % count) / count;
      const double distance = near + 0.4 * (i % 2);
      const Point back{std::cos(turn) * std::cos(up), std::sin(turn) * std::cos(up), std::sin(up)};
      Point at = aim;
      for (size_t k = 0; k < 3; ++k) at[k] += distance * back[k];
      Add(at, turn, back);
    }
  }
  // A camera that stands on a rail of 1.2 before the point, 3 from it, and turns by hardly
  // anything.
  void FilmFromARail(int count) {
    for (int i = 0; i < count; ++i) {
      const double turn = 0.004 * (i * 5 % 7 - 3);
      Add({3, 1.2 * i / (count - 1) - 0.6, 0}, turn, {std::cos(turn), std::sin(turn), 0});
    }
  }
  // Each camera with the image of the one `by` places further on.
  void ExchangeImages(size_t by) {
    const Json frames = json["frames"];
    for (size_t i = 0; i < frames.size(); ++i)
      json["frames"][i]["file_path"] = frames[(i + by) % frames.size()]["file_path"];
  }
  std::vector<Finding> Check() const {
    std::ofstream(folder / "transforms.json") << json;
    return CheckScene(LoadScene(folder.path(), {}));
  }

 private:
  // back: of unit length, away from what it sees; turn: its angle about z.
  void Add(const Point& at, double turn, const Point& back) {
    const Point right{-std::sin(turn), std::cos(turn), 0};
    const Point above{back[1] * right[2] - back[2] * right[1],
                      back[2] * right[0] - back[0] * right[2],
                      back[0] * right[1] - back[1] * right[0]};
    Json matrix = Json::array();
    for (size_t k = 0; k < 3; ++k) matrix.push_back({right[k], above[k], back[k], at[k]});
    matrix.push_back({0, 0, 0, 1});
    const std::string name = std::to_string(json["frames"].size()) + ".png";
    WriteImage(folder / name, Rendering(matrix));
    json["frames"].push_back({{"file_path", name}, {"transform_matrix", matrix}});
  }
  Image8 Rendering(const Json& matrix) const {
    Image8 image(kSide, kSide, 4);
    const auto along = [&](const Point& p, size_t column) {
      double sum = 0;
      for (size_t k = 0; k < 3; ++k) sum += p[k] * matrix[k][column].get<double>();
      return sum;
    };
    for (const Ball& ball : balls_) {
      Point p = ball.center;
      for (size_t k = 0; k < 3; ++k) p[k] -= matrix[k][3].get<double>();
      const double z = -along(p, 2);
      if (z < 0.5) continue;
      const double x = kSide / 2. + kFocal * along(p, 0) / z;
      const double y = kSide / 2. - kFocal * along(p, 1) / z;
      const double r = std::max(0.7, kFocal * ball.radius / z);
      for (int v = std::max(0, int(y - r)); v < std::min<double>(kSide, y + r); ++v)
        for (int u = std::max(0, int(x - r)); u < std::min<double>(kSide, x + r); ++u)
          if (std::hypot(u + 0.5 - x, v + 0.5 - y) <= r) {
            const auto color = PlaneColor(ball.center[0] - 3 * (u + 0.5 - x) / kFocal,
                                          ball.center[1] + 3 * (v + 0.5 - y) / kFocal);
            for (int c = 0; c < 3; ++c) image.at(u, v, c) = color[size_t(c)];
            image.at(u, v, 3) = 255;
          }
    }
    return image;
  }
  std::vector<Ball> balls_;
};

// A wire that winds up about the z axis, twelve times as long as it is wide about and thinner than
// a pixel, under a small ball.
std::vector<Ball> Spring() {
  std::vector<Ball> balls{{{0.4, 0.1, 0.5}, 0.1}};
  for (double t = 0; t < 12; t += 0.02)
    balls.push_back({{0.5 * std::cos(t), 0.5 * std::sin(t), 0.08 * t - 0.5}, 0.002});
  return balls;
}

TEST(CheckRendering, ThinThingsAreTheirCameras) {
  BallScene scene(Spring());
  scene.Film({}, 24);
  EXPECT_EQ(Said(scene.Check()), "");
  scene.ExchangeImages(7);
  EXPECT_TRUE(Wrong(scene.Check(), "exchanged or renamed")) << Said(scene.Check());
}

// From wherever one looks, it looks alike: other views' images do as well.
TEST(CheckRendering, ABallIsTheSameFromEverywhere) {
  BallScene scene({{{0, 0, 0}, 0.6}});
  scene.Film({}, 24);
  EXPECT_EQ(Said(scene.Check()), "");
}

TEST(CheckRendering, ThingsApartAreSeenByTheirOwnCameras) {
  BallScene scene(
      {{{-9, 0, 0}, 0.5}, {{9, 1, 0}, 0.3}, {{9, 1.3, 0.4}, 0.2}, {{-9, 0.4, 0.2}, 0.4}});
  scene.Film({-9, 0, 0}, 12);
  scene.Film({9, 1, 0}, 12);
  EXPECT_EQ(Said(scene.Check()), "");
}

// The object is larger than what any camera sees of it.
TEST(CheckRendering, CloseUpsAreCutAtTheirEdges) {
  std::vector<Ball> balls;
  for (int i = 0; i < 9; ++i)
    balls.push_back({{0.5 * (i % 3) - 0.5, 0.5 * (i / 3) - 0.5, 0.2 * (i % 2)}, 0.35});
  BallScene scene(balls);
  for (int i = 0; i < 9; i += 2) scene.Film(balls[size_t(i)].center, 5);
  EXPECT_EQ(Said(scene.Check()), "");
}

TEST(CheckRendering, SomeCamerasAreNearer) {
  BallScene scene(Spring());
  scene.Film({}, 18, 4);
  scene.Film({}, 6, 1.2);
  EXPECT_EQ(Said(scene.Check()), "");
}

TEST(CheckRendering, CamerasOnARailLookNowhere) {
  BallScene scene({{{0, 0.1, 0}, 0.3}, {{0.2, -0.2, 0.2}, 0.15}});
  scene.FilmFromARail(24);
  EXPECT_EQ(Said(scene.Check()), "");
}

// As programs that cut out backgrounds do in a view or two.
TEST(CheckRendering, TwoMattesLackAPart) {
  BallScene scene({{{0.3, 0, 0}, 0.3}, {{-0.3, 0.3, 0.3}, 0.15}, {{0, -0.4, -0.2}, 0.2}});
  scene.Film({}, 24);
  for (const int view : {4, 15}) {
    const std::string path = scene.folder / (std::to_string(view) + ".png");
    Image8 image = ReadImage(path);
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width / 2; ++x) image.at(x, y, 3) = 0;
    WriteImage(path, image);
  }
  EXPECT_EQ(Said(scene.Check()), "");
}

TEST(CheckRendering, FindsHowPosesWereMeant) {
  const auto changed = [](const std::function<void(Json&)>& change) {
    BallScene scene({{{0.3, 0, 0}, 0.3}, {{-0.3, 0.3, 0.3}, 0.15}, {{0, -0.4, -0.2}, 0.2}});
    scene.Film({}, 24);
    for (Json& frame : scene.json["frames"]) change(frame["transform_matrix"]);
    return scene.Check();
  };
  EXPECT_EQ(Said(changed([](Json&) {})), "");
  const auto axes = changed([](Json& m) {
    for (size_t r = 0; r < 3; ++r)
      for (const size_t k : {1, 2}) m[r][k] = -m[r][k].get<double>();
  });
  EXPECT_TRUE(Wrong(axes, "camera axes of the other convention")) << Said(axes);
  const auto mirrored = changed([](Json& m) {
    for (size_t r = 0; r < 3; ++r)
      for (const size_t k : {0, 1}) m[r][k] = -m[r][k].get<double>();
  });
  EXPECT_TRUE(Wrong(mirrored, "turned upside down")) << Said(mirrored);
}

}  // namespace
}  // namespace cosplat::test
