// RegisterBusts (avatar/train/bust_track.h): shifts of the image below the neck, from coarse to
// fine.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "avatar/surface/silhouette.h"
#include "avatar/train/bust_track.h"
#include "splat/train/subject/reduced_frames.h"

namespace cosplat {
namespace {

constexpr int kLevels = 3;           // each with twice the resolution of the one before
constexpr int kCoarseSide = 64;      // px: about the longer side of the first level's images
constexpr int kReach = 14;           // px at the first level: about a fifth of the image
constexpr int kRefinedReach = 2;     // px at the others
constexpr double kMinOverlap = 0.5;  // of the reference's pixels

// A frame at one level.
struct Level {
  int width = 0, height = 0;
  std::vector<float> pixels;   // [height, width, 4] premultiplied colour and alpha
  std::vector<uint8_t> head;   // [height, width] whether the head's mesh covers the pixel
  float collar = 0;            // row of the collar at the bust's mean place
  float pixels_per_metre = 0;  // there
};

using Offset = std::array<int, 2>;

math::Mat3<float> RotationOfCamera(const Camera& camera) {
  math::Mat3<float> rotation;
  std::copy(camera.rotation.begin(), camera.rotation.end(), rotation.m);
  return rotation;
}

Level LevelOf(const TrainFrame& frame,
              int downscale,
              const AvatarPoser& poser,
              const std::vector<float>& vertices) {
  const TrainFrame reduced = Reduced(frame, downscale);
  const Image8& image = reduced.target;
  const Camera& camera = reduced.camera;
  Level level{image.width, image.height, std::vector<float>(4 * image.pixels()), {}, 0, 0};
  for (size_t p = 0; p < image.pixels(); ++p) {
    const float alpha = image.data[4 * p + 3] / 255.0f;
    for (int c = 0; c < 3; ++c) level.pixels[4 * p + c] = alpha * image.data[4 * p + c] / 255.0f;
    level.pixels[4 * p + 3] = alpha;
  }
  level.head = MeshSilhouette(vertices, poser.flame().model().faces, camera);
  const math::Vec3<float> collar =
      RotationOfCamera(camera) * poser.bust_pivot() +
      math::Vec3<float>{camera.translation[0], camera.translation[1], camera.translation[2]};
  level.collar = camera.fy * collar.y / collar.z + camera.cy;
  level.pixels_per_metre = camera.fx / collar.z;
  return level;
}

// Mean squared difference over the reference's pixels below the collar where neither frame shows
// the head; infinite if too few remain.
double Difference(const Level& reference, const Level& other, const Offset& offset) {
  double sum = 0;
  size_t compared = 0, all = 0;
  for (int y = std::max(0, int(reference.collar)); y < reference.height; ++y)
    for (int x = 0; x < reference.width; ++x) {
      const size_t a = size_t(y) * reference.width + x;
      if (reference.head[a]) continue;
      ++all;
      const int ox = x + offset[0], oy = y + offset[1];
      if (ox < 0 || oy < 0 || ox >= other.width || oy >= other.height) continue;
      const size_t b = size_t(oy) * other.width + ox;
      if (other.head[b]) continue;
      ++compared;
      for (int c = 0; c < 4; ++c) {
        const float d = reference.pixels[4 * a + c] - other.pixels[4 * b + c];
        sum += double(d * d);
      }
    }
  const bool enough = compared > 0 && double(compared) >= kMinOverlap * double(all);
  return enough ? sum / double(compared) : HUGE_VAL;
}

Offset FindOffset(const Level& reference, const Level& other, const Offset& near, int reach) {
  Offset best = near;
  double min = Difference(reference, other, near);
  for (int dy = -reach; dy <= reach; ++dy)
    for (int dx = -reach; dx <= reach; ++dx) {
      const Offset offset{near[0] + dx, near[1] + dy};
      const double difference = Difference(reference, other, offset);
      if (!(difference < min)) continue;
      min = difference;
      best = offset;
    }
  return best;
}

}  // namespace

std::vector<BustPose> RegisterBusts(const AvatarPoser& poser,
                                    const std::vector<TrainFrame>& frames,
                                    const std::vector<std::vector<float>>& vertices) {
  const size_t middle = frames.size() / 2;
  const int side = std::max(frames[0].target.width, frames[0].target.height);
  std::vector<Offset> offsets(frames.size(), Offset{0, 0});
  std::vector<BustPose> poses(frames.size(), kMeanBustPose);
  int last = 0;
  for (int l = 0; l < kLevels; ++l) {
    const int downscale = std::max(1, (side / kCoarseSide) >> l);
    if (downscale == last) break;
    const int factor = std::exchange(last, downscale);
    const Level reference = LevelOf(frames[middle], downscale, poser, vertices[middle]);
    tbb::parallel_for(size_t(0), frames.size(), [&](size_t i) {
      const Level level = LevelOf(frames[i], downscale, poser, vertices[i]);
      const Offset near{offsets[i][0] * factor / downscale, offsets[i][1] * factor / downscale};
      offsets[i] = FindOffset(reference, level, near, l == 0 ? kReach : kRefinedReach);
      const float metres = 1 / level.pixels_per_metre;
      poses[i].shift = math::TransposeTimes(
          RotationOfCamera(frames[i].camera),
          math::Vec3<float>{offsets[i][0] * metres, offsets[i][1] * metres, 0});
    });
  }
  // Their mean is the bust's mean place.
  math::Vec3<float> mean{0, 0, 0};
  for (const BustPose& pose : poses) mean += pose.shift * (1.0f / float(poses.size()));
  for (BustPose& pose : poses) pose.shift = pose.shift - mean;
  return poses;
}

}  // namespace cosplat
