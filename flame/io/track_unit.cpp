// Tracks in other units than metres, recognised by how large the head would be seen.
#include <algorithm>
#include <cmath>
#include <limits>

#include "flame/io/track_layouts.h"
#include "splat/base/error.h"
#include "splat/base/median.h"

namespace cosplat {
namespace {

// The face's width as a share of the image's shorter side. Less is too little to track, more is
// seen from within the head.
constexpr double kMinShare = 0.015, kMaxShare = 20;
// The share of the width that a face takes which fills a video of a head, and its limits.
constexpr double kUsualShare = 0.3, kMinUsual = 0.05, kMaxUsual = 1.5;
// Metres: of a head from the origin without a camera that would tell, and of hair from the head.
constexpr double kMaxPlace = 20, kMaxOffset = 0.5;
// The place of camera and head over the distance between them at which 32 bits of a number leave
// half a millimetre of a metre.
constexpr double kFarthest = 1e4;

template <class Action>
void ForEachFrame(TrackedVideo& video, const Action& action) {
  for (auto* list : {&video.train, &video.test})
    for (TrackedFrame& frame : *list) action(frame);
}

double Length(const std::array<float, 3>& v) { return std::hypot(v[0], v[1], v[2]); }

// In metres, the closest of those in use to what a usual picture needs; 1 if none does.
double UnitByShare(double share) {
  if (share >= kMinShare && share <= kMaxShare) return 1;
  double unit = 1, min = std::numeric_limits<double>::max();
  for (const double candidate : {0.001, 0.01, 100.0, 1000.0}) {
    const double seen = share / candidate, off = std::abs(std::log(seen / kUsualShare));
    if (seen < kMinUsual || seen > kMaxUsual || off >= min) continue;
    min = off;
    unit = candidate;
  }
  return unit;
}

double UnitOf(TrackedVideo& video) {
  std::vector<double> shares, places;
  ForEachFrame(video, [&](const TrackedFrame& frame) {
    const double depth = DepthOfHead(frame);
    const Camera& camera = frame.camera;
    places.push_back(Length(frame.params.translation));
    if (depth > 0 && Length(camera.translation) > 0)
      shares.push_back(kFaceSize * camera.fx / depth / std::min(camera.width, camera.height));
    if (depth > 0 && Length(camera.translation) > kFarthest * depth)
      throw Error(video.source,
                  "frame " + frame.name,
                  "the camera is " + std::to_string(Length(camera.translation)) +
                      " from the origin and " + std::to_string(depth) +
                      " from the head, too far for 32-bit numbers: move the track to the origin");
  });
  if (!shares.empty()) return UnitByShare(Median(shares));
  return !places.empty() && Median(places) > kMaxPlace ? 0.001 : 1;
}

}  // namespace

void ConvertToMetres(const FlameModel* flame, TrackedVideo& video) {
  video.unit = UnitOf(video);
  const auto unit = float(video.unit);
  if (unit != 1)
    ForEachFrame(video, [&](TrackedFrame& frame) {
      for (float& x : frame.params.translation) x *= unit;
      for (float& x : frame.camera.translation) x *= unit;
    });
  // Offsets may be in metres already: they are the model's, not the camera's.
  const float offset_unit = unit == 1 && flame ? float(flame->unit) : unit;
  float max = 0;
  for (const float x : video.static_offset) max = std::max(max, std::abs(x));
  if (max > kMaxOffset)
    for (float& x : video.static_offset) x *= offset_unit;
}

}  // namespace cosplat
