// From a frame's parameters to the weights of an avatar's corrections (avatar/math/correct.h).
//
// training frames' parameters -> FindCorrectionMap -> CorrectionMap -> CorrectionWeights -> Bind;
// after training DropIdleCorrections.
#pragma once

#include <vector>

#include "avatar/model/avatar_model.h"
#include "flame/pose.h"

namespace cosplat {

constexpr int kMaxCorrections = 64;
// Inputs of a CorrectionMap besides expression coefficients: all joints but the root.
constexpr size_t kMinCorrectionInputs = 3 * (kFlameJoints - 1);

// At most `count` weights: the principal components of the frames' expressions and of the turns of
// neck, jaw and eyes, each measured by how far it moves the mesh; fewer if the frames have fewer
// motions. In the frames a weight is zero on average and at most 1 in magnitude.
CorrectionMap FindCorrectionMap(const FlameModel& flame,
                                const std::vector<FlamePoser<float>::Parameters>& frames,
                                size_t count);

// weights: [map.count()], softly limited to the range of the training frames. Its memory is reused.
void CorrectionWeights(const CorrectionMap& map,
                       const FlamePoser<float>::Parameters& parameters,
                       std::vector<float>& weights);
inline std::vector<float> CorrectionWeights(const CorrectionMap& map,
                                            const FlamePoser<float>::Parameters& parameters) {
  std::vector<float> weights;
  CorrectionWeights(map, parameters, weights);
  return weights;
}

// Removes the bases that do nothing from the Gaussians and from the map: those whose numbers, times
// the largest weight of a training frame, are less than a hundredth of the strongest basis's (root
// mean squares over the Gaussians).
void DropIdleCorrections(AvatarModel& avatar);

}  // namespace cosplat
