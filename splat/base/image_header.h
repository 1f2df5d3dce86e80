// What a PNG or JPEG file says about itself, without decoding it. Decoders hand back partial
// pictures for cut-off files; walking the file's own structure finds the cut.
#pragma once

#include <string>
#include <vector>

#include "splat/base/image_io.h"

namespace cosplat {

// True and `info` filled when `bytes` (a whole file or its beginning) is a PNG or JPEG with a
// complete header.
bool ParseImageHeader(const std::vector<char>& bytes, ImageInfo& info);

// Throws Error(path, ...) when a PNG lacks chunks up to IEND or one of its critical chunks fails
// its CRC, or when a JPEG lacks its end-of-image marker. Other kinds of file pass.
void CheckImageIsComplete(const std::string& path, const std::vector<char>& bytes);

}  // namespace cosplat
