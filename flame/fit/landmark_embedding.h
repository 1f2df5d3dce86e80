// Which point of the mesh each landmark is.
//
// Landmarks of a detector (flame/io/landmarks.h) -> LandmarkEmbedding -> points on FLAME's surface
// (flame/fit/points_on_flame.h), which the tracker brings onto the image.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "flame/io/landmarks.h"
#include "flame/model.h"

namespace cosplat {

// The model's own landmarks if it has some (FlameModel::landmarks), as of a detector. Otherwise,
// for a model with FLAME's topology: 105 points of MediaPipe's mesh as placed by FLAME 2023 Open
// (CC-BY-4.0, Max Planck Institute for Intelligent Systems), of which iBUG's are a part, and the
// pupils where the set has irises. Throws Error if the model has another topology.
LandmarkEmbedding FlameLandmarks(const FlameModel& model, LandmarkSet set);

// From an .npz with the arrays of FLAME's mediapipe_landmark_embedding.npz: lmk_face_idx [L],
// lmk_b_coords [L, 3], landmark_indices [L]. Throws Error naming array and value unless the indices
// exist in the model and in a set of `point_count` points.
LandmarkEmbedding ReadLandmarkEmbedding(const std::string& path,
                                        const FlameModel& model,
                                        int point_count);

}  // namespace cosplat
