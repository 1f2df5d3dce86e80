// What the checks of a data set found (splat/io/scene_check.h, flame/track.h), for users.
#pragma once

#include <string>
#include <vector>

#include "splat/base/skipped.h"

namespace cosplat {

// A block of lines, what is wrong first; "the data tells one story" if there are none.
std::string ToString(const std::vector<Finding>& findings);

// Before training: prints the block on stderr, if there is any. Throws Error if something is wrong
// and `strict`.
void PrintFindings(const std::string& source, const std::vector<Finding>& findings, bool strict);

}  // namespace cosplat
