// Whether a head's images show what its track says: the part of CheckTrack (flame/track.h) that
// tries how else they could have been meant.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "flame/track.h"
#include "splat/media/image_glance.h"

namespace cosplat {

constexpr int kShifts = 2;  // frames before and after

// A frame, reduced.
struct SeenFrame {
  const TrackedFrame* frame = nullptr;
  Camera camera;                 // at the reduced size
  std::vector<Sighting> points;  // of the model's own vertices
  std::vector<uint8_t> visible;  // whether they face the camera
  double share_inside = 0;
  std::array<Image8, 2 * kShifts + 1> images;  // of the frames before, its own, those after

  const Image8& image() const { return images[kShifts]; }
};

// Adds what they find: whether masks overlap the head more elsewhere, and whether its points'
// colours change less in images that are mirrored or of other moments.
void CheckPlace(const FlameModel& flame,
                const std::vector<SeenFrame>& all,
                std::vector<Finding>& findings);
void CheckHeadColors(const FlameModel& flame,
                     const std::vector<SeenFrame>& all,
                     std::vector<Finding>& findings);

}  // namespace cosplat
