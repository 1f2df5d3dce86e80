// COLMAP's sparse model as stored in its files, binary or text.
// Format: colmap.github.io/format.html.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "splat/base/camera.h"
#include "splat/media/image_io.h"

namespace cosplat {

struct ColmapCamera {
  Camera lens;  // intrinsics; no pose
  Distortion distortion;
};

struct ColmapImage {
  std::string name;  // path below the images folder
  uint32_t camera_id = 0;
  std::array<double, 4> rotation{};  // cam_from_world quaternion, wxyz, as stored
  std::array<double, 3> translation{};
};

struct ColmapModel {
  std::string images_file;  // for messages
  std::map<uint32_t, ColmapCamera> cameras;
  std::vector<ColmapImage> images;
  std::vector<double> points;         // [P, 3]
  std::vector<uint8_t> point_colors;  // [P, 3]
  double mean_error = 0;              // px: of the points' reprojection; 0 where none is stored
  std::vector<std::string> notes;     // what a user should know of how it was read
};

// Reads cameras, images and points3D (.bin, or .txt if there is no .bin) from a folder; points3D is
// optional. COLMAP 3.12 and later write rigs and frames as well, which are not read: each image's
// pose is still in images. Throws Error naming the file, the record and what was expected.
ColmapModel ReadColmapModel(const std::string& folder);

// A camera of COLMAP's `model` ("OPENCV", ...). Throws Error(file, field, ...) for models that
// Distortion has not, and for a wrong number or value of parameters.
ColmapCamera MakeColmapCamera(const std::string& file,
                              const std::string& field,
                              const std::string& model,
                              const std::array<int64_t, 2>& size,
                              const std::vector<double>& params);

// A camera model: its id in a binary file, its name in text, and its parameters.
struct ColmapModelKind {
  int id;
  const char* name;
  int params;
  int focals;  // of these focal lengths, which come first: f, or fx and fy; 0: it is refused
  Distortion::Model distortion;
};
const ColmapModelKind* FindColmapModelKind(int id);

namespace colmap {
// One function per format; ReadColmapModel calls it if its camera file exists.
void ReadBinary(const std::string& folder, ColmapModel& model);
void ReadText(const std::string& folder, ColmapModel& model);

// The mean of the points' errors as COLMAP's model_analyzer computes it: of those that have one.
class MeanError {
 public:
  // error: px; of a point without one -1.
  void Add(double error) {
    if (!(error >= 0 && std::isfinite(error))) return;
    sum_ += error;
    ++count_;
  }
  double Mean() const { return count_ == 0 ? 0 : sum_ / double(count_); }

 private:
  double sum_ = 0;
  size_t count_ = 0;
};
}  // namespace colmap

}  // namespace cosplat
