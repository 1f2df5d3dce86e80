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
  float degrees = 0;   // of the camera around the head, from before the face, counterclockwise from
                       // above
  double outside = 0;  // of the view's alpha, the share that is farther from the mesh's outline
                       // than all but a hundredth of it is from the front
};

struct TurnedSheet {
  std::vector<TurnedView> views;
  Image8 image;  // RGB: the views side by side, in rows
};

// Draws the avatar, placed by `rest`, from before its face, aside and behind: by the camera `lens`,
// which goes around the head.
TurnedSheet DrawTurned(Player& player,
                       const FlameModel& flame,
                       const FlameParams& rest,
                       const Camera& lens,
                       const std::array<float, 3>& background);

// "0 deg 0.23 %, -15 deg 0.26 %, ...": the shares outside.
std::string ToString(const TurnedSheet& sheet);

}  // namespace cosplat
