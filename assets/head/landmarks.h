// The landmarks that a detector would see of the made head: known points of its surface.
#pragma once

#include <string>
#include <vector>

#include "assets/head/video.h"
#include "flame/fit/landmark_embedding.h"
#include "flame/track.h"

namespace cosplat {

// About as many points as FLAME's embedding has, at the same places: lips, lids, pupils, and spread
// over the front of the face. The landmarks are numbered in this order.
LandmarkEmbedding MadeHeadLandmarks(const ProceduralHead& head);

// Writes <folder>/landmarks.json, with the points as each frame's camera sees them and
// options.landmark_noise added and the masks as mattes, and <folder>/landmark_embedding.npz. Points
// on the far side are written, too. Throws Error if a file cannot be written.
void WriteMadeLandmarks(const std::string& folder,
                        const ProceduralHead& head,
                        const std::vector<TrackedFrame>& frames,
                        const MakeHeadOptions& options);

}  // namespace cosplat
