// Lossless WebP images in memory, whose bytes are data rather than colours: every channel of every
// pixel comes back as it was, also the colours of transparent ones, which OpenCV's encoder changes.
#pragma once

#include <string>
#include <vector>

#include "splat/base/image.h"

namespace cosplat {

// image: four channels, RGBA. The same image gives the same bytes. Throws Error naming `path` and
// `field` if a side is not 1 to 16383.
std::string EncodeWebp(const std::string& path, const std::string& field, const Image8& image);

// [height, width, 4]. Throws Error naming `path` and `field` if the bytes are not a WebP image, are
// truncated or damaged, or have more than `max_pixels`, which is checked before anything is
// allocated. A lossy image is refused, since its bytes are no data.
Image8 DecodeWebp(const std::string& path,
                  const std::string& field,
                  const std::vector<char>& bytes,
                  size_t max_pixels);

}  // namespace cosplat
