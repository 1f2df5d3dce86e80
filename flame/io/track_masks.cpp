// Whether a tracked video's masks show the head that its track says.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "flame/track.h"
#include "splat/base/error.h"
#include "splat/base/text.h"
#include "splat/media/image_glance.h"

namespace cosplat {
namespace {

constexpr size_t kFrames = 8;
constexpr int kCorner = 8;  // px
// Share of the head's points that its masks hold: of good data 0.9 and more, of inverted masks 0.1.
constexpr double kHeld = 0.5;
constexpr double kInverted = 0.3;
// Share of an image that a mask which shows anything covers.
constexpr double kEmpty = 1e-4;

// Means of alpha, 0 to 1.
struct Coverage {
  double image = 0, head = 0, corners = 0;
  void Add(const Coverage& more) {
    image += more.image, head += more.head, corners += more.corners;
  }
};

double AlphaAt(const Image8& image, int x, int y) { return image.at(x, y, 3) / 255.0; }

Coverage CoverageOf(const Image8& image, const Camera& camera, const std::vector<float>& vertices) {
  Coverage c;
  for (size_t i = 0; i < image.pixels(); ++i) c.image += image.data[4 * i + 3] / 255.0;
  c.image /= double(image.pixels());
  const int side = std::min({kCorner, image.width, image.height});
  for (int y = 0; y < side; ++y)  // shoulders fill the lower ones
    for (int x = 0; x < side; ++x)
      c.corners += AlphaAt(image, x, y) + AlphaAt(image, image.width - 1 - x, y);
  c.corners /= 2.0 * side * side;
  size_t seen = 0;
  for (size_t i = 0; i + 2 < vertices.size(); i += 3) {
    const Sighting at = Sight(camera, &vertices[i]);
    if (!at.inside) continue;
    c.head += AlphaAt(image, int(at.x), int(at.y));
    ++seen;
  }
  c.head = seen == 0 ? 1 : c.head / double(seen);  // a head outside the image says nothing of masks
  return c;
}

}  // namespace

void SettleMasks(const FlameModel& flame, TrackedVideo& video) {
  Coverage sum;
  size_t masked = 0;
  const size_t step = std::max<size_t>(1, video.train.size() / kFrames);
  for (size_t i = 0; i < video.train.size(); i += step) {
    const TrackedFrame& frame = video.train[i];
    if (!frame.has_image) continue;
    Image8 image;  // training skips those that cannot be used
    if (!Problem([&] { image = LoadTrackedImage(video, frame); }).empty()) continue;
    if (image.channels != 4) continue;
    sum.Add(CoverageOf(image, frame.camera, TrackedVertices(flame, video, frame)));
    ++masked;
  }
  if (masked == 0) return;
  const double image = sum.image / double(masked), head = sum.head / double(masked);
  if (image < kEmpty)
    throw Error(
        video.source, "masks", Format("show nothing in any of the {} frames looked at", masked));
  if (image > 1 - kEmpty) {
    video.notes.push_back(video.source + ": the masks hold the whole image, background included");
  } else if (head < kInverted && sum.corners / double(masked) > 1 - kInverted) {
    video.masks_inverted = true;
    video.notes.push_back(video.source + ": the masks are bright where the head is not (" +
                          Format("{:.0f} %", 100 * head) +
                          " of it is inside): they are taken as inverted");
  } else if (head < kHeld) {
    video.notes.push_back(video.source + ": the masks hold only " + Format("{:.0f} %", 100 * head) +
                          " of the head where the track says it is");
  }
}

}  // namespace cosplat
