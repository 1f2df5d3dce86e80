// Images embedded into an HTML page, so that it needs no other file.
#pragma once

#include <string>

#include "splat/base/image.h"

namespace cosplat {

// "data:image/png;base64,..." (RFC 2397), PNG or JPEG by `extension` (".png", ".jpg"). Throws Error
// as EncodeImage does.
std::string ImageUri(const Image8& image, const std::string& extension);

}  // namespace cosplat
