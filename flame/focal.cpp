#include <vector>

#include "flame/mouth.h"
#include "flame/pose.h"
#include "flame/track.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

// The frames of both sets with the depth of the middle of the head in the camera, metres. Without
// expressions, whose coefficients a model may lack.
struct Head {
  TrackedFrame* frame;
  double depth;
};
std::vector<Head> HeadsOf(const FlameModel& flame, TrackedVideo& video) {
  const FlamePoser<float> poser(flame, video.shape, StaticOffsetFor(flame, video.static_offset));
  FlamePoser<float>::Cache cache;
  std::vector<float> vertices;
  std::vector<Head> heads;
  for (auto* set : {&video.train, &video.test})
    for (TrackedFrame& frame : *set) {
      auto parameters = FlamePoser<float>::ParametersOf(frame.params);
      parameters.expression.clear();
      poser.Forward(parameters, vertices, cache);
      double sum = 0;
      for (size_t i = 0; i < vertices.size(); ++i)
        sum += double(frame.camera.rotation[6 + i % 3]) * double(vertices[i]);
      const double depth = 3 * sum / double(vertices.size()) + frame.camera.translation[2];
      heads.push_back({&frame, depth});
    }
  return heads;
}

}  // namespace

bool HasOneStillCamera(const TrackedVideo& video) {
  if (video.head_is_fixed || video.train.empty()) return false;
  for (const auto* set : {&video.train, &video.test})
    for (const TrackedFrame& frame : *set)
      if (frame.camera != video.train[0].camera) return false;
  return true;
}

void ScaleFocal(const FlameModel& flame, double scale, TrackedVideo& video) {
  if (!HasOneStillCamera(video))
    throw Error(video.source,
                "--focal-scale",
                "is for one camera that stands still; this track has several, or one that moves");
  const std::vector<Head> heads = HeadsOf(flame, video);
  double mean = 0;
  for (const Head& head : heads) mean += head.depth / double(heads.size());
  for (const Head& head : heads) {
    Camera& camera = head.frame->camera;
    for (size_t k = 0; k < 3; ++k)
      head.frame->params.translation[k] +=
          float((scale - 1) * (head.depth - mean) * camera.rotation[6 + k]);
    camera.translation[2] += float((scale - 1) * mean);
    camera.fx = float(scale * camera.fx);
    camera.fy = float(scale * camera.fy);
  }
}

}  // namespace cosplat
