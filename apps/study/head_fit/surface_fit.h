// How well a head model's directions of shape reach other people's faces.
//
// FlameModel (ours), a face of FLAME's topology -> FitToFace -> distances, coefficients.
#pragma once

#include <vector>

#include "flame/model.h"

namespace cosplat {

struct FaceFit {
  std::vector<double> distances;     // [face's vertices in the region], metres, from ours
  std::vector<double> coefficients;  // of shape
};

// Fits `ours` to `face` ([V, 3] metres, of `people`'s faces): turn, shift and size of the face and,
// with_shape, our coefficients, by the distance from its surface to ours along our normals, from
// the landmarks that both models have. Distances are those of the region that NoW's benchmark
// evaluates: within 96.5 mm of a point between nose and eyes (Sanyal et al. 2019, section 5).
FaceFit FitToFace(const FlameModel& ours,
                  const FlameModel& people,
                  const std::vector<float>& face,
                  bool with_shape);

}  // namespace cosplat
