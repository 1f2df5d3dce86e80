#include "flame/fit/head_crop.h"

#include <algorithm>
#include <cmath>

#include "flame/io/landmarks.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

// Room around the middle of the landmarks, in units of the face's size (ChooseFaces').
constexpr double kAside = 1.5, kAbove = 1.4, kBelow = 1.75;
constexpr double kOutermost = 0.02;  // of the frames, at each side
// Of what does not fit into the frame, this much is lost above.
constexpr double kLostAbove = 0.25;

FaceBox WithRoom(const FaceBox& face) {
  const double size = face.size();
  const auto [x, y] = face.middle();
  return {x - kAside * size, y - kAbove * size, x + kAside * size, y + kBelow * size};
}

double Quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[size_t(std::lround(share * double(values.size() - 1)))];
}

}  // namespace

FrameCrop HeadCrop(const std::vector<std::vector<DetectedFace>>& faces,
                   int width,
                   int height,
                   int size) {
  std::vector<double> left, top, right, bottom;
  for (const std::vector<DetectedFace>& found : faces) {
    if (found.empty()) continue;
    const FaceBox room = WithRoom(BoxOf(found[0].points));
    left.push_back(room.left), right.push_back(room.right);
    top.push_back(room.top), bottom.push_back(room.bottom);
  }
  if (left.empty()) throw Error("landmarks", "no frame has a face");
  const double x0 = Quantile(left, kOutermost), x1 = Quantile(right, 1 - kOutermost);
  const double y0 = Quantile(top, kOutermost), y1 = Quantile(bottom, 1 - kOutermost);
  const int side = int(std::ceil(std::max({x1 - x0, y1 - y0, 2.0}) / 2)) * 2;
  FrameCrop crop;
  crop.frame_width = width, crop.frame_height = height;
  Crop& part = crop.part;
  part.width = std::min(side, width), part.height = std::min(side, height);
  part.x = std::clamp(int(std::lround((x0 + x1 - part.width) / 2)), 0, width - part.width);
  const double missing = y1 - y0 - part.height;
  part.y = std::clamp(int(std::lround(y0 + kLostAbove * missing)), 0, height - part.height);
  const auto [image_width, image_height] = SidesWithin(part, size);
  crop.width = image_width, crop.height = image_height;
  return crop;
}

std::array<int, 2> SidesWithin(const Crop& part, int size) {
  const double scale = std::min(1.0, size / std::sqrt(double(part.width) * part.height));
  return {std::max(1, int(std::lround(scale * part.width))),
          std::max(1, int(std::lround(scale * part.height)))};
}

}  // namespace cosplat
