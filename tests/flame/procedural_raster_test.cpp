// assets/head/raster.h: exact pinhole, coverage, depth, perspective.
#include <gtest/gtest.h>

#include <cmath>

#include "assets/head/motion.h"
#include "assets/head/raster.h"

namespace cosplat::test {
namespace {

using procedural::Rasterize;
using procedural::Shader;
using procedural::SurfacePoint;
using Faces = std::vector<std::array<int32_t, 3>>;

Camera FrontCamera(int size) {  // at the origin, looking along +z
  Camera camera;
  camera.width = camera.height = size;
  camera.fx = camera.fy = float(size);
  camera.cx = camera.cy = 0.5f * float(size);
  return camera;
}

class Plain : public Shader {
 public:
  explicit Plain(std::array<float, 3> color = {1, 0, 0}) : color_(color) {}
  std::array<float, 3> Shade(const SurfacePoint&) const override { return color_; }

 private:
  std::array<float, 3> color_;
};

class ByFace : public Shader {
 public:
  std::array<float, 3> Shade(const SurfacePoint& p) const override {
    return {p.face == 0 ? 1.0f : 0.0f, p.face == 1 ? 1.0f : 0.0f, p.back ? 1.0f : 0.0f};
  }
};

class FirstWeight : public Shader {
 public:
  std::array<float, 3> Shade(const SurfacePoint& p) const override {
    return {p.barycentrics[0], 0, 0};
  }
};

// A square about (x, y) at depth z, facing the camera: clockwise as the camera's y points down.
std::vector<float> Square(float x, float y, float z, float half) {
  return {
      x - half, y - half, z, x - half, y + half, z, x + half, y + half, z, x + half, y - half, z};
}
const Faces kSquareFaces = {{0, 1, 2}, {0, 2, 3}};

TEST(Raster, CentroidOfASmallSquareLiesOnItsProjection) {
  const Camera camera = procedural::OrbitCamera(0.3f, -0.1f, 0.9f, 96);
  const std::array<float, 3> center{0.031f, 0.027f, -0.012f};
  std::array<double, 3> p{};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) p[i] += double(camera.rotation[3 * i + k]) * center[k];
    p[i] += camera.translation[i];
  }
  // Corners offset along the camera's own axes: a square parallel to the image.
  std::vector<float> vertices;
  for (const auto& corner : {std::array<float, 2>{-1, -1}, {-1, 1}, {1, 1}, {1, -1}})
    for (int k = 0; k < 3; ++k)
      vertices.push_back(center[k] + 0.02f * (corner[0] * camera.rotation[k] +
                                              corner[1] * camera.rotation[3 + k]));
  const Image8 image = Rasterize(vertices, kSquareFaces, camera, Plain());
  double x = 0, y = 0, sum = 0;
  for (int row = 0; row < image.height; ++row)
    for (int column = 0; column < image.width; ++column) {
      const double a = image.at(column, row, 3) / 255.0;
      x += a * (column + 0.5), y += a * (row + 0.5), sum += a;
    }
  // Coverage is quantised to quarter pixels along a border of some 10 px.
  EXPECT_NEAR(x / sum, camera.fx * p[0] / p[2] + camera.cx, 0.13);
  EXPECT_NEAR(y / sum, camera.fy * p[1] / p[2] + camera.cy, 0.13);
  const double side = 0.04 * camera.fx / p[2];
  EXPECT_NEAR(sum, side * side, 0.03 * side * side);
}

TEST(Raster, PixelCentresLieAtOneHalf) {
  // Covers [10, 20) x [6, 12) exactly.
  const Camera camera = FrontCamera(32);
  const std::vector<float> vertices = {10, 6, 32, 10, 12, 32, 20, 12, 32, 20, 6, 32};
  std::vector<float> moved = vertices;
  for (size_t i = 0; i < moved.size(); i += 3) moved[i] -= 16, moved[i + 1] -= 16;
  const Image8 image = Rasterize(moved, kSquareFaces, camera, Plain());
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x)
      EXPECT_EQ(image.at(x, y, 3), x >= 10 && x < 20 && y >= 6 && y < 12 ? 255 : 0)
          << x << " " << y;
}

TEST(Raster, SharedEdgesLeaveNoGap) {
  // A fan about an awkward point: every pixel well inside is covered in full.
  std::vector<float> vertices = {0.0137f, -0.0071f, 1};
  Faces faces;
  constexpr int kSpokes = 37;
  for (int k = 0; k < kSpokes; ++k) {
    const float a = -6.2831853f * float(k) / kSpokes;
    vertices.insert(vertices.end(),
                    {0.4f * std::cos(a), 0.4f * std::sin(a), 1 + 0.1f * std::sin(3 * a)});
    faces.push_back({0, 1 + k, 1 + (k + 1) % kSpokes});
  }
  const Image8 image = Rasterize(vertices, faces, FrontCamera(64), Plain());
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      if (std::hypot(x + 0.5 - 32, y + 0.5 - 32) < 20) {
        EXPECT_EQ(image.at(x, y, 3), 255);
      }
}

TEST(Raster, NearerSurfaceHidesTheOther) {
  std::vector<float> vertices = {-1,
                                 -1,
                                 3,
                                 -1,
                                 3,
                                 3,
                                 3,
                                 -1,
                                 3,  // far, faces the camera
                                 -1,
                                 -1,
                                 2,
                                 3,
                                 -1,
                                 2,
                                 -1,
                                 3,
                                 2};  // near, turned away
  const Image8 image = Rasterize(vertices, {{0, 1, 2}, {3, 4, 5}}, FrontCamera(32), ByFace());
  EXPECT_EQ(image.at(12, 12, 0), 0);
  EXPECT_EQ(image.at(12, 12, 1), 255);
  EXPECT_EQ(image.at(12, 12, 2), 255) << "seen from inside";
  for (float& x : vertices) x = -x;
  for (size_t i = 2; i < vertices.size(); i += 3) vertices[i] = -vertices[i];
  const Image8 turned = Rasterize(vertices, {{3, 4, 5}, {0, 1, 2}}, FrontCamera(32), ByFace());
  EXPECT_EQ(turned.at(18, 18, 0), 255) << "independent of the order of faces";
}

TEST(Raster, InterpolatesWithPerspective) {
  // Corner 0 at depth 1, corners 1 and 2 at depth 4, all in the plane x = const of the image's
  // middle column: at the image's point y the weight solves the perspective division.
  const Camera camera = FrontCamera(64);
  const std::vector<float> vertices = {0, -0.4f, 1, -1.6f, 1.6f, 4, 1.6f, 1.6f, 4};
  const Image8 image = Rasterize(vertices, {{0, 1, 2}}, camera, FirstWeight());
  for (int y : {16, 24, 32, 40, 48}) {
    const double v = (y + 0.5 - 32) / 64;  // = (-0.4 w + 1.6 (1 - w)) / (w + 4 (1 - w))
    const double w = (1.6 - 4 * v) / (2.0 - 3 * v);
    EXPECT_NEAR(image.at(32, y, 0) / 255.0, w, 0.006) << y;
  }
}

TEST(Raster, NothingInViewIsTransparentWhite) {
  const Image8 image = Rasterize(Square(0, 0, -1, 0.2f), kSquareFaces, FrontCamera(16), Plain());
  for (size_t i = 0; i < image.data.size(); ++i) EXPECT_EQ(image.data[i], i % 4 == 3 ? 0 : 255);
}

}  // namespace
}  // namespace cosplat::test
