#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "splat/train/start/initialize.h"
#include "splat/train/subject/frame_reader.h"
#include "splat/train/subject/reduced_frames.h"

namespace cosplat {
namespace {

constexpr int kSide = 200;        // px, maximum of the longer side of the images compared
constexpr int kDepths = 256;      // about a pixel apart at that size
constexpr int kNeighbours = 8;    // number of images that each is compared with
constexpr int kAgreeing = 4;      // of these, the most similar count: others may not see the point
constexpr float kNearest = 0.2f;  // nearest depth, as a share of the distance to the focus point
// A depth stands out if its difference is below this share of the mean over all depths; images
// agree if it is at most kMaxDifference, in [0, 255].
constexpr float kDistinct = 0.4f, kMaxDifference = 20;
constexpr int kPatch = 1;  // px to either side
constexpr uint64_t kDraws = 4;

struct SweepImage {
  Camera camera;
  Image color;                 // [0, 255]
  std::vector<uint8_t> solid;  // per pixel: alpha is at least one half
  std::vector<int> neighbours;
  float distance = 1;  // to the focus point
};

using Point = std::array<float, 3>;
using Color = std::array<float, 3>;
using Patch = std::array<Color, (2 * kPatch + 1) * (2 * kPatch + 1)>;

float Distance(const Point& a, const Point& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

// Offset of the k-th pixel of a patch from its middle.
float OffsetX(size_t k) { return float(int(k) % (2 * kPatch + 1) - kPatch); }
float OffsetY(size_t k) { return float(int(k) / (2 * kPatch + 1) - kPatch); }

// World position of a pixel at a depth.
Point Unproject(const Camera& c, float x, float y, float depth) {
  const float p[3] = {(x - c.cx) / c.fx * depth - c.translation[0],
                      (y - c.cy) / c.fy * depth - c.translation[1],
                      depth - c.translation[2]};
  Point world{};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) world[i] += c.rotation[3 * k + i] * p[k];
  return world;
}

// Projects a point. Returns whether it lies in front of the camera and inside its image, at least a
// pixel from the border.
bool Project(const Camera& c, const Point& p, float& x, float& y) {
  float q[3];
  for (int i = 0; i < 3; ++i)
    q[i] = c.rotation[3 * i] * p[0] + c.rotation[3 * i + 1] * p[1] + c.rotation[3 * i + 2] * p[2] +
           c.translation[i];
  if (!(q[2] > 1e-6f)) return false;
  x = c.fx * q[0] / q[2] + c.cx;
  y = c.fy * q[1] / q[2] + c.cy;
  return x > 1 && y > 1 && x < float(c.width) - 1 && y < float(c.height) - 1;
}

// Composites over mid-grey if there is alpha.
void CompositeOnGrey(const Image8& image, SweepImage& sweep) {
  sweep.color = Image(image.width, image.height, 3);
  for (size_t i = 0; i < image.pixels(); ++i) {
    const uint8_t* pixel = &image.data[i * image.channels];
    const float alpha = image.channels == 4 ? float(pixel[3]) / 255 : 1.0f;
    sweep.solid.push_back(alpha >= 0.5f);
    for (int c = 0; c < 3; ++c)
      sweep.color.data[3 * i + c] =
          alpha * float(pixel[image.channels == 1 ? 0 : c]) + (1 - alpha) * 128;
  }
}

// Interpolates bilinearly between pixel centres.
Color ColorAt(const Image& image, float x, float y) {
  x = std::clamp(x - 0.5f, 0.0f, float(image.width) - 1.001f);
  y = std::clamp(y - 0.5f, 0.0f, float(image.height) - 1.001f);
  const int column = int(x), row = int(y);
  const float u = x - float(column), v = y - float(row);
  const float* above = &image.at(column, row, 0);
  const float* below = above + 3 * image.width;
  Color color;
  for (int c = 0; c < 3; ++c)
    color[c] = (1 - v) * ((1 - u) * above[c] + u * above[c + 3]) +
               v * ((1 - u) * below[c] + u * below[c + 3]);
  return color;
}

std::vector<SweepImage> DownscaledImages(const std::vector<TrainFrame>& frames) {
  std::vector<SweepImage> small(frames.size());
  std::vector<Camera> cameras;
  for (const TrainFrame& frame : frames) cameras.push_back(frame.camera);
  const Point focus = FocusPoint(cameras);
  tbb::parallel_for(size_t(0), frames.size(), [&](size_t i) {
    const Camera& camera = cameras[i];
    TrainFrame scratch;
    const TrainFrame reduced = Reduced(Loaded(frames[i], scratch),
                                       1 + (std::max(camera.width, camera.height) - 1) / kSide);
    small[i].camera = reduced.camera;
    CompositeOnGrey(reduced.target, small[i]);
    small[i].distance = std::max(Distance(camera.Center(), focus), 1e-6f);
    // The nearest cameras that are not in nearly the same place.
    std::vector<std::pair<float, int>> others;
    for (size_t k = 0; k < cameras.size(); ++k) {
      const float apart = Distance(camera.Center(), cameras[k].Center());
      if (apart > 0.02f * small[i].distance) others.push_back({apart, int(k)});
    }
    std::sort(others.begin(), others.end());
    for (size_t k = 0; k < std::min<size_t>(others.size(), kNeighbours); ++k)
      small[i].neighbours.push_back(others[k].second);
  });
  return small;
}

// Mean difference between the patch around (x, y), placed at this depth, and the neighbours that
// agree best; negative if too few see it.
float DifferenceAt(const std::vector<SweepImage>& images,
                   const SweepImage& from,
                   const Patch& patch,
                   float x,
                   float y,
                   float depth) {
  std::array<Point, Patch().size()> points;
  for (size_t k = 0; k < patch.size(); ++k)
    points[k] = Unproject(from.camera, x + OffsetX(k), y + OffsetY(k), depth);
  std::array<float, kNeighbours> difference;  // ascending
  int seen = 0;
  for (const int neighbour : from.neighbours) {
    const SweepImage& other = images[neighbour];
    float sum = 0, u, v;
    bool inside = true;
    for (size_t k = 0; k < patch.size() && inside; ++k) {
      inside = Project(other.camera, points[k], u, v);
      if (!inside) break;
      const Color color = ColorAt(other.color, u, v);
      for (int c = 0; c < 3; ++c) sum += std::abs(patch[k][c] - color[c]);
    }
    if (!inside) continue;
    const float mean = sum / float(3 * patch.size());
    int at = seen++;
    for (; at > 0 && difference[at - 1] > mean; --at) difference[at] = difference[at - 1];
    difference[at] = mean;
  }
  if (seen < 2) return -1;
  const int counted = std::min(seen, kAgreeing);
  float sum = 0;
  for (int k = 0; k < counted; ++k) sum += difference[k];
  return sum / float(counted);
}

struct Met {
  bool found = false;
  Point point{};
  std::array<uint8_t, 3> color{};
};

Met Sweep(const std::vector<SweepImage>& images, const SweepImage& from, Rng rng) {
  Met met;
  const float x = 1 + rng.Uniform() * float(from.camera.width - 2);
  const float y = 1 + rng.Uniform() * float(from.camera.height - 2);
  if (!from.solid[size_t(y) * from.camera.width + size_t(x)]) return met;
  Patch patch;
  for (size_t k = 0; k < patch.size(); ++k)
    patch[k] = ColorAt(from.color, x + OffsetX(k), y + OffsetY(k));
  const float offset = rng.Uniform();
  float sum = 0, min = 1e30f, best = 0;
  int judged = 0;
  for (int k = 0; k < kDepths; ++k) {
    const float inverse = (float(k) + offset) / kDepths / (kNearest * from.distance);
    const float depth = 1 / std::max(inverse, 1e-9f);
    const float difference = DifferenceAt(images, from, patch, x, y, depth);
    if (difference < 0) continue;
    ++judged;
    sum += difference;
    if (difference < min) {
      min = difference;
      best = depth;
    }
  }
  if (judged == 0 || min > kMaxDifference || min >= kDistinct * sum / float(judged)) return met;
  met.found = true;
  met.point = Unproject(from.camera, x, y, best);
  const Color& color = patch[patch.size() / 2];
  for (int c = 0; c < 3; ++c)
    met.color[c] = uint8_t(std::lround(std::clamp(color[c], 0.0f, 255.0f)));
  return met;
}

}  // namespace

void SweepPoints(const std::vector<TrainFrame>& frames,
                 size_t rays,
                 Rng& rng,
                 std::vector<float>& points,
                 std::vector<uint8_t>& colors) {
  if (frames.empty()) return;
  const std::vector<SweepImage> images = DownscaledImages(frames);
  std::vector<Met> met(rays);
  tbb::parallel_for(size_t(0), rays, [&](size_t i) {
    met[i] = Sweep(images, images[i % images.size()], rng.After(i * kDraws));
  });
  rng = rng.After(rays * kDraws);
  for (const Met& m : met) {
    if (!m.found) continue;
    points.insert(points.end(), m.point.begin(), m.point.end());
    colors.insert(colors.end(), m.color.begin(), m.color.end());
  }
}

}  // namespace cosplat
