// Images embedded into an HTML page, so that it needs no other file.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "splat/base/image.h"

namespace cosplat {

// RFC 4648, with padding.
std::string Base64(const std::vector<uint8_t>& bytes);

// "data:image/png;base64,..." (RFC 2397), PNG or JPEG by `extension` (".png", ".jpg"). Throws Error
// as EncodeImage does.
std::string ImageUri(const Image8& image, const std::string& extension);

}  // namespace cosplat
