// Landmark files: where a detector saw the points of a face, frame by frame.
//
// `cosplat landmarks` writes them, `cosplat track` and `train-avatar --landmarks` read them;
// docs/landmarks.md describes the format. Points are in pixels: x right, y down, (0, 0) is the
// image's top left corner, the centre of its first pixel (0.5, 0.5).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/media/face_part.h"

namespace cosplat {

// The extent of points, px.
inline FaceBox BoxOf(const std::vector<std::array<double, 2>>& points) {
  FaceBox box;
  for (const auto& [x, y] : points) {
    box.left = std::min(box.left, x), box.right = std::max(box.right, x);
    box.top = std::min(box.top, y), box.bottom = std::max(box.bottom, y);
  }
  return box;
}

// Which points of the face a file has, and in which order.
enum class LandmarkSet {
  kMediapipe478,  // MediaPipe's face mesh with the ten points of the irises at its end
  kMediapipe468,  // the same without irises
  kIbug68,        // the 68 points of iBUG 300-W (Sagonas et al. 2013)
  kOther,         // any number, for a model with its own embedding (flame/fit/landmark_embedding.h)
};

// "mediapipe-478", "mediapipe-468", "ibug-68" or "other".
const char* NameOf(LandmarkSet set);

struct DetectedFace {
  std::vector<std::array<double, 2>> points;  // [LandmarkVideo::point_count()] px
  double score = 1;                           // the detector's confidence, 0 to 1
  std::map<std::string, float> blendshapes;   // by ARKit's names, 0 to 1; or empty
};

struct LandmarkFrame {
  std::string name;                 // stem of the image file, or the frame's number in a video
  int frame = 0;                    // its place in the video, from 0; increasing
  std::vector<DetectedFace> faces;  // none, one or several, in any order
  std::string matte;  // path of an 8-bit grey image, 255 where the person is; or empty
};

// A part of a video's frames, the same in all of them, as an image of its own.
struct FrameCrop {
  Crop part;                              // px of the frame
  int frame_width = 0, frame_height = 0;  // px
  int width = 0, height = 0;              // px of the image; at most the part's

  // Px of the image per px of the frame: in x, and in y, which differ by rounding alone.
  double scale_x() const { return double(width) / part.width; }
  double scale_y() const { return double(height) / part.height; }
  // The camera of the whole frame, whose image this is a part of.
  Camera WholeCamera(const Camera& of_part) const;
  // A point of the image, px of the frame.
  std::array<double, 2> InFrame(const std::array<double, 2>& point) const {
    return {part.x + point[0] / scale_x(), part.y + point[1] / scale_y()};
  }
  // And back.
  std::array<double, 2> InImage(const std::array<double, 2>& point) const {
    return {(point[0] - part.x) * scale_x(), (point[1] - part.y) * scale_y()};
  }
};

struct LandmarkVideo {
  std::string file;                         // that it was read from, for messages
  std::string source;                       // the video or folder that was looked at, as then given
  std::optional<uint32_t> source_checksum;  // CRC-32 of the video, or of the images in their order
  int width = 0, height = 0;                // of the images, px; those of the crop, if there is one
  std::optional<FrameCrop> crop;            // points and mattes are its
  double frames_per_second = 0;             // 0 if unknown
  LandmarkSet set = LandmarkSet::kMediapipe478;
  std::vector<LandmarkFrame> frames;
  int held_out = 0;  // of the frames, at the end, are for testing; 0: nobody said
  int left_out = 0;  // frames of the video that were not looked at: other shots
  // frames_per_second, or what is usual.
  double rate() const { return frames_per_second > 0 ? frames_per_second : 25; }
  // Points of every face; 0 if there is none in a set of any number.
  int point_count() const;
};

// A matte's path in the file is relative to the file's folder, and absolute or relative to the
// working directory in the struct. Throws Error naming file, field and value if the file is
// damaged.
LandmarkVideo ReadLandmarks(const std::string& path);

// Writes the file atomically, as its reader reads it. Throws Error if it cannot be written.
void WriteLandmarks(const std::string& path, const LandmarkVideo& video);

}  // namespace cosplat
