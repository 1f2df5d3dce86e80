// The 52 blendshapes of Apple's ARKit, which face trackers speak.
#pragma once

#include <array>
#include <string_view>

namespace cosplat {

constexpr size_t kArkitBlendshapes = 52;

// In the order in which Apple's Live Link Face writes them; rows of a matrix file are in it.
extern const std::array<std::string_view, kArkitBlendshapes> kArkitNames;

// Upper and lower case alike, since senders differ; -1 for a name that is none.
int FindArkitBlendshape(std::string_view name);

}  // namespace cosplat
