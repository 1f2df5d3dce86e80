// The made head before made backgrounds, with its true mattes and those of a made network: what
// `cosplat-study mattes` measures on.
#pragma once

#include <optional>
#include <vector>

#include "splat/base/image.h"
#include "splat/media/refine_mattes.h"

namespace cosplat {

enum class MadeBackground {
  kStill,   // a room before a camera at rest
  kMoving,  // the same before a camera in a hand
  kBusy,    // fine patterns of skin's and hair's colours, of which some move; a camera at rest
};
const char* NameOf(MadeBackground background);

struct MatteFrame {
  Image8 image;  // RGB
  Image8 truth;  // 1 channel; empty if not known
  Image8 matte;  // of the made network
  std::optional<FaceBox> face;
};

// A head that turns and talks, `frames` of `size` px.
std::vector<Image8> DrawHeads(int frames, int size, unsigned seed);

// Puts heads (RGBA) before a background. The made network's matte is that of 256x256 over the
// frame with a rim that wanders, blurred, with an island and, in some frames, a hole, blown up.
std::vector<MatteFrame> Compose(const std::vector<Image8>& heads,
                                MadeBackground background,
                                unsigned seed);

// Pixels of the made frame that one of the made network's spans.
double MadeNetworkPx(int size);

}  // namespace cosplat
