// What a camera wrote into a JPEG, PNG, WebP or TIFF about the shot (EXIF 2.3, CIPA DC-008).
// ReadImage ignores it; ReadUpright turns the image as viewers do.
#pragma once

#include <cstddef>
#include <vector>

#include "splat/base/image.h"

namespace cosplat {

struct ExifInfo {
  int orientation = 1;        // 1 to 8, see Upright
  double focal_length = 0;    // mm; 0: not stated
  int extra_samples = 0;      // TIFF 6.0's: 1 if colours are multiplied by alpha, 2 if they are not
  bool is_raw = false;        // a TIFF of sensor values, whose first image is a preview of them
  size_t orientation_at = 0;  // where a TIFF has its orientation, in bytes; 0: nowhere, or no TIFF
};

// `bytes`: a whole file or its beginning. What is absent or damaged keeps its default.
ExifInfo ParseExif(const std::vector<char>& bytes);

// The image as it is meant to be seen: turned by a quarter clockwise for orientation 6, by half for
// 3, counter-clockwise for 8; 2, 4, 5 and 7 are mirrored.
Image8 Upright(const Image8& image, int orientation);

}  // namespace cosplat
