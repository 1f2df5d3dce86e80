// Scores of ARKit's blendshapes from the geometry of MediaPipe's landmarks, for detectors that give
// points only.
//
// A face's own map (avatar/train/blendshape_fit.h) is fitted to the scores of its video, so that
// they need to follow the face, not to agree with ARKit's own.
#pragma once

#include <map>
#include <string>

#include "flame/io/landmarks.h"

namespace cosplat {

// 24 of ARKit's 52 scores, 0 to 1: jaw, mouth, brows, lids and, with irises, gaze. Sides are the
// subject's. What has no definition here is left out; empty for sets that are not MediaPipe's.
//
// The frame of the face: x along the line of the outer corners of the eyes, to the subject's left,
// y down, origin at the bridge of the nose; lengths in units of the distance of those corners.
std::map<std::string, float> ScoresOf(const DetectedFace& face, LandmarkSet set);

// Gives scores to all faces that have none.
void AddScores(LandmarkVideo& video);

}  // namespace cosplat
