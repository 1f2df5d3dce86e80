// What the fourth byte of a pixel says.
#pragma once

namespace cosplat {

enum class AlphaMode {
  kStraight,       // colour not multiplied by alpha; of a picture over black
  kPremultiplied,  // colour <= alpha; of a picture over black
  kOpaque          // alpha 255, the colour as it is; of a picture over its background
};

}  // namespace cosplat
