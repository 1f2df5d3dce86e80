// Small scenes for the loaders' tests: one bright spot in front of a few cameras, photographed
// through a lens whose formula the test writes out itself.
#pragma once

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "splat/base/camera.h"
#include "splat/base/files.h"
#include "splat/media/image_io.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {

using Point2 = std::array<double, 2>;
using Point3 = std::array<double, 3>;

constexpr Point3 kSpot{0.35, -0.2, 0.1};  // world

inline Point3 ToCamera(const Camera& camera, const Point3& p) {
  Point3 q;
  for (int r = 0; r < 3; ++r) {
    q[r] = camera.translation[r];
    for (int c = 0; c < 3; ++c) q[r] += camera.rotation[3 * r + c] * p[c];
  }
  return q;
}

// Where the pinhole `camera` sees the spot, px.
inline Point2 SpotIn(const Camera& camera) {
  const Point3 q = ToCamera(camera, kSpot);
  return {camera.fx * q[0] / q[2] + camera.cx, camera.fy * q[1] / q[2] + camera.cy};
}

// A dark image with a round spot of `sigma` px around `center` (px, centres at +0.5).
inline Image8 SpotImage(int width, int height, const Point2& center, double sigma = 4) {
  Image8 image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double dx = x + .5 - center[0], dy = y + .5 - center[1];
      const double value = 250 * std::exp(-(dx * dx + dy * dy) / (2 * sigma * sigma));
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = uint8_t(std::lround(value));
    }
  return image;
}

// Centroid of the brightness above a threshold, px.
inline Point2 Centroid(const Image8& image) {
  double sum = 0, x_sum = 0, y_sum = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const double value = std::max(0, image.at(x, y, 0) - 10);
      sum += value;
      x_sum += value * (x + .5);
      y_sum += value * (y + .5);
    }
  return {x_sum / sum, y_sum / sum};
}

// Three distinct camera poses that have the spot in view, as wxyz and translation.
struct Pose {
  std::array<double, 4> quaternion;
  Point3 translation;
};
inline Pose PoseOf(int index) {
  const double half = 0.05 * (index + 1);
  return {{std::cos(half), 0, std::sin(half), 0}, {0.1 * index, 0.05, 3 + 0.2 * index}};
}
// Rotation about y by the angle 2 * half.
inline Camera WithPose(Camera camera, const Pose& pose) {
  const double angle = 2 * std::atan2(pose.quaternion[2], pose.quaternion[0]);
  const float c = float(std::cos(angle)), s = float(std::sin(angle));
  camera.rotation = {c, 0, s, 0, 1, 0, -s, 0, c};
  for (int k = 0; k < 3; ++k) camera.translation[k] = float(pose.translation[k]);
  return camera;
}

class Bytes {
 public:
  template <class T>
  Bytes& Put(T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    text_.append(raw, sizeof(T));
    return *this;
  }
  Bytes& Text(const std::string& text) {
    text_ += text;
    text_ += '\0';
    return *this;
  }
  const std::string& str() const { return text_; }

 private:
  std::string text_;
};

// Distorts a ray (x, y) = (X/Z, Y/Z).
using Lens = std::function<Point2(double x, double y)>;

// What a COLMAP scene is written from.
struct ColmapFixture {
  int model_id = 1;
  std::string model = "PINHOLE";
  std::vector<double> params;  // at 160x120
  Lens lens = [](double x, double y) { return Point2{x, y}; };
  double fx = 150, fy = 150, cx = 80, cy = 60;
  int images = 4;
};
constexpr int kFixtureWidth = 160, kFixtureHeight = 120;

inline std::string FixtureName(int index) { return "img " + std::to_string(index) + ".png"; }

inline Point2 SpotThroughLens(const ColmapFixture& fixture, int index) {
  const Point3 q = ToCamera(WithPose(Camera(), PoseOf(index % 3)), kSpot);
  const Point2 d = fixture.lens(q[0] / q[2], q[1] / q[2]);
  return {fixture.fx * d[0] + fixture.cx, fixture.fy * d[1] + fixture.cy};
}

inline std::string CamerasBin(const ColmapFixture& fixture) {
  Bytes bytes;
  bytes.Put<uint64_t>(1).Put<uint32_t>(7).Put<int32_t>(fixture.model_id);
  bytes.Put<uint64_t>(kFixtureWidth).Put<uint64_t>(kFixtureHeight);
  for (double p : fixture.params) bytes.Put(p);
  return bytes.str();
}

inline std::string ImagesBin(const ColmapFixture& fixture) {
  Bytes bytes;
  bytes.Put<uint64_t>(uint64_t(fixture.images));
  for (int i = fixture.images - 1; i >= 0; --i) {  // not in the order of the names
    bytes.Put<uint32_t>(uint32_t(i + 1));
    for (double q : PoseOf(i % 3).quaternion) bytes.Put(q * 2);  // any length is a rotation
    for (double t : PoseOf(i % 3).translation) bytes.Put(t);
    bytes.Put<uint32_t>(7).Text(FixtureName(i));
    bytes.Put<uint64_t>(1).Put(1.0).Put(2.0).Put<int64_t>(-1);
  }
  return bytes.str();
}

inline std::string PointsBin() {
  Bytes bytes;
  bytes.Put<uint64_t>(2);
  for (uint64_t i = 0; i < 2; ++i) {
    bytes.Put<uint64_t>(i + 5);
    for (double p : kSpot) bytes.Put(p + double(i));
    bytes.Put<uint8_t>(10).Put<uint8_t>(20).Put<uint8_t>(uint8_t(30 + i)).Put(0.5);
    bytes.Put<uint64_t>(1).Put<int32_t>(1).Put<int32_t>(0);
  }
  return bytes.str();
}

inline ColmapFixture PinholeFixture() {
  ColmapFixture fixture;
  fixture.params = {150, 150, 80, 60};
  return fixture;
}

// Writes model (binary) and images divided by `reduce` into images or images_<reduce>.
inline void WriteScene(const TemporaryFolder& folder,
                       const ColmapFixture& fixture,
                       int reduce = 1) {
  MakeDirectories(folder / "sparse/0");
  WriteFileAtomically(folder / "sparse/0/cameras.bin", CamerasBin(fixture));
  WriteFileAtomically(folder / "sparse/0/images.bin", ImagesBin(fixture));
  WriteFileAtomically(folder / "sparse/0/points3D.bin", PointsBin());
  const std::string images = reduce == 1 ? "images" : "images_" + std::to_string(reduce);
  MakeDirectories(folder / images);
  for (int i = 0; i < fixture.images; ++i) {
    const Point2 spot = SpotThroughLens(fixture, i);
    WriteImage(
        folder / (images + "/" + FixtureName(i)),
        SpotImage(
            kFixtureWidth / reduce, kFixtureHeight / reduce, {spot[0] / reduce, spot[1] / reduce}));
  }
}

}  // namespace cosplat::test
