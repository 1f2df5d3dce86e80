// How the bust follows the head where nothing else tells its pose: in playback and in held-out
// frames.
//
// training frames' head and bust poses -> FitBustFollow -> Bust::follow -> PoseOfBust ->
// AvatarPoser.
#pragma once

#include <vector>

#include "avatar/model/avatar_model.h"
#include "flame/model.h"

namespace cosplat {

// Where the bust is when the head is at `params`; at its mean place if it has not learned to
// follow.
BustPose PoseOfBust(const Bust& bust, const FlameParams& params);

// Makes the avatar's bust, if it has one that follows the head, stay at the mean of where it was in
// training.
void HoldBustStill(AvatarModel& avatar);

// Learns how the bust follows the head, from at least two instants in the order of time: a linear
// map by ridge regression, a mean over dampings that are weighted by how well each predicts blocks
// of consecutive instants from the others, so that a motion of the shoulders that the head does not
// explain is hardly followed. The outputs are limited to the range of `busts`.
BustFollow FitBustFollow(const Bust& bust,
                         const std::vector<FlameParams>& heads,
                         const std::vector<BustPose>& busts);

}  // namespace cosplat
