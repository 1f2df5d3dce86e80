// What a file is that is not what a reader expects: for the errors of all readers.
#pragma once

#include <string>
#include <string_view>

namespace cosplat {

// From the first bytes of a file (64 are enough): what it is and what to do about it, as the end of
// a sentence ("is a web page ..., download it again"). Empty: nothing that people have by mistake.
std::string OtherContent(std::string_view begin);

// What that is of a camera's raw image.
inline constexpr char kRawImage[] =
    "is a camera's raw image, which is not read: develop it to JPEG or TIFF";

}  // namespace cosplat
