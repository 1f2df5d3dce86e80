// A made scene in nerfstudio's layout: FourColors-like images of a plane that four cameras see,
// with points of its colours.
#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "splat/base/camera.h"
#include "splat/base/files.h"
#include "splat/io/dataset.h"
#include "splat/media/image_io.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {

using Json = nlohmann::json;

// The plane z = 3 in colours that tell left from right and top from bottom.
inline std::array<uint8_t, 3> PlaneColor(double x, double y) {
  const auto wave = [](double t) { return uint8_t(std::lround(127 + 100 * std::sin(t))); };
  return {uint8_t(x > 0 ? 230 : 30), uint8_t(y > 0 ? 230 : 30), wave(5 * x + 3 * y)};
}

struct NerfScene {
  static constexpr int kWidth = 64, kHeight = 48;
  static constexpr double kFocal = 60;
  TemporaryFolder folder;
  Json json = {{"fl_x", kFocal}, {"fl_y", kFocal}, {"w", kWidth}, {"h", kHeight}};

  explicit NerfScene(int views = 9,
                     const std::string& images = "images",
                     const char* ending = ".png") {
    std::filesystem::create_directories(folder / images);
    json["frames"] = Json::array();
    for (int i = 0; i < views; ++i) {
      const double x = 0.1 * (i - views / 2), y = 0.05 * (i % 3);
      WriteImage(folder / (images + "/" + std::to_string(i) + ending), Photograph(x, y));
      json["frames"].push_back(
          {{"file_path", images + "/" + std::to_string(i) + ending},
           // OpenGL's axes, looking along +z with y up in the world turned over
           {"transform_matrix", {{1, 0, 0, x}, {0, -1, 0, y}, {0, 0, -1, 0}, {0, 0, 0, 1}}}});
    }
  }
  static Image8 Photograph(double center_x, double center_y) {
    Image8 image(kWidth, kHeight, 3);
    for (int v = 0; v < kHeight; ++v)
      for (int u = 0; u < kWidth; ++u) {
        const double x = center_x + 3 * (u + .5 - kWidth / 2.0) / kFocal;
        const double y = center_y + 3 * (v + .5 - kHeight / 2.0) / kFocal;
        const auto color = PlaneColor(x, y);
        for (int c = 0; c < 3; ++c) image.at(u, v, c) = color[c];
      }
    return image;
  }
  void WritePoints(const std::string& name) const {
    std::ofstream ply(folder / name);
    ply << "ply\nformat ascii 1.0\nelement vertex 400\nproperty float x\nproperty float "
           "y\nproperty "
           "float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
    for (int i = 0; i < 400; ++i) {
      const double x = 0.1 * (i % 20 - 9.5), y = 0.08 * (i / 20 - 9.5);
      const auto c = PlaneColor(x, y);
      ply << x << ' ' << y << " 3 " << int(c[0]) << ' ' << int(c[1]) << ' ' << int(c[2]) << '\n';
    }
  }
  std::string Frame(int i) const { return json["frames"][i]["file_path"]; }
  SceneData Load(const SceneOptions& options = {}, const char* name = "transforms.json") const {
    std::ofstream(folder / name) << json;
    return LoadScene(folder.path(), options);
  }
};

// Mean difference of the views' images from what their cameras see of the plane.
inline double PlaneDifference(const std::vector<SceneView>& views) {
  double sum = 0;
  size_t count = 0;
  for (const SceneView& view : views) {
    const Image8 image = LoadViewImage(view);
    const std::array<float, 3> center = view.camera.Center();
    for (int v = 4; v < image.height; v += 5)
      for (int u = 4; u < image.width; u += 5) {
        const double x = center[0] + 3 * (u + .5 - view.camera.cx) / view.camera.fx;
        const double y = center[1] + 3 * (v + .5 - view.camera.cy) / view.camera.fy;
        const auto color = PlaneColor(x, y);
        for (int c = 0; c < 3; ++c, ++count) sum += std::abs(image.at(u, v, c) - color[c]);
      }
  }
  return sum / double(count);
}

inline bool Notes(const std::vector<std::string>& notes, const std::string& part) {
  for (const std::string& note : notes)
    if (note.find(part) != std::string::npos) return true;
  return false;
}

// Puts an EXIF orientation into a JPEG, as a phone does.
inline void SetOrientation(const std::string& path, int orientation) {
  const std::vector<char> jpeg = ReadFile(path);
  std::string tiff("II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0", 18);
  tiff += char(orientation);
  tiff += std::string("\0\0\0\0\0\0\0", 7);
  const std::string exif = std::string("Exif\0\0", 6) + tiff;
  std::string bytes(jpeg.begin(), jpeg.begin() + 2);
  bytes += std::string("\xff\xe1\0", 3) + char(exif.size() + 2) + exif;
  bytes.append(jpeg.begin() + 2, jpeg.end());
  WriteFileAtomically(path, bytes);
}

}  // namespace cosplat::test
