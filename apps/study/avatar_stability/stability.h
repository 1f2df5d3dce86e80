// Where avatars bound to a mesh are known to fail: the forms of SplattingAvatar's code release, or
// the plainest ones, beside ours. Nothing here is part of training or of playing.
//
// AvatarStability -> apps/study/stability/stability_case.h -> `cosplat study --stability`;
// tests/study/avatar_stability_test.cpp holds each case to its bound. docs/stability.md explains
// them.
#pragma once

#include <vector>

#include "apps/study/stability/stability_case.h"

namespace cosplat {

// All cases, measured on the procedural head: the same bits on every run. Some seconds. Writes a
// small video into the system's temporary folder and removes it; throws Error where it cannot.
std::vector<StabilityCase> AvatarStability();

}  // namespace cosplat
