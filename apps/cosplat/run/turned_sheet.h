// An avatar seen from where nobody filmed it: does it hold there?
#pragma once

#include <string>
#include <vector>

#include "avatar/play/player.h"
#include "flame/model.h"
#include "splat/base/camera.h"
#include "splat/base/image.h"

namespace cosplat {

struct TurnedView {
  float degrees = 0;   // of the camera around the head, towards the image's right
  double outside = 0;  // of the view's alpha, the share that is farther from the mesh's outline
                       // than all but a hundredth of it is from the front
};

struct TurnedSheet {
  std::vector<TurnedView> views;
  Image8 image;  // RGB: the views side by side, in rows
};

// Draws the avatar at rest from the front, aside and behind. `front` shows the head placed by
// `rest`.
TurnedSheet DrawTurned(Player& player,
                       const FlameModel& flame,
                       const FlameParams& rest,
                       const Camera& front,
                       const std::array<float, 3>& background);

// "0 deg 0.010, 15 deg 0.012, ...": the shares.
std::string ToString(const TurnedSheet& sheet);

}  // namespace cosplat
