// The rounds of `cosplat track` in which small avatars make a track more exact.
//
// A track in memory -> RefineByAvatars (avatar/train/refine_by_avatar.h, with the settings of
// train-avatar's quick preset, but 800 steps) -> the same with other parameters.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "flame/track.h"

namespace cosplat {

constexpr int kAvatarRounds = 3;

// flame: the model's file; image: as RefineByAvatar has it. Frames' eyelids are apart from their
// expressions, before and after. Returns what RefineByAvatar does, and nothing for no rounds.
std::vector<double> RefineByAvatars(const std::string& flame,
                                    TrackedVideo& video,
                                    const std::function<Image8(const TrackedFrame&)>& image,
                                    int rounds,
                                    bool quiet);

// "frames that small avatars had not seen: 24.31 dB, 25.50 dB after round 1, 25.45 dB after round
// 2, which is undone".
std::string AvatarRoundsText(const std::vector<double>& psnr);

}  // namespace cosplat
