// Which head model a run is about: the user's, or the head that comes with the program.
#pragma once

#include <string>

namespace cosplat {

// `given`, or where it is empty <folder>/head.npz: the procedural head (assets/head), which may be
// passed on and which every avatar file of it has inside. It is written unless an earlier run has
// left it there.
std::string HeadModelFor(const std::string& given, const std::string& folder);

}  // namespace cosplat
