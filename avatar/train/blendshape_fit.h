// The map from blendshape scores to FLAME's parameters of one head, by ridge regression (Hoerl &
// Kennard 1970).
//
// MatchScores -> BlendshapeSamples -> FitBlendshapes -> BlendshapeMap -> the avatar file.
// Its strength is chosen by cross-validation over blocks of time, since neighbouring frames are
// alike, and by how far the vertices of the posed mesh are off, not the coefficients.
#pragma once

#include "avatar/model/blendshape_map.h"
#include "avatar/train/blendshape_samples.h"
#include "flame/pose.h"

namespace cosplat {

// Fewer frames show too few expressions for a map.
constexpr size_t kMinScoredFrames = 30;

struct BlendshapeFit {
  // Has the scores that vary in the samples and, as in GeneralBlendshapeMap, those that do not.
  // Its figures are of frames held out in turn, a block at a time.
  BlendshapeMap map;
  size_t varying = 0;   // scores that the samples determine
  double strength = 0;  // of the ridge, relative to a score's variance
  FlameParams mean;     // the samples' mean face
};

// poser: of the subject. Deterministic. Throws Error if there are fewer than kMinScoredFrames
// samples, or no score varies.
BlendshapeFit FitBlendshapes(const FlamePoser<float>& poser, const BlendshapeSamples& samples);

// How the fit does on other frames of its subject.
BlendshapeFitFigures MeasureBlendshapes(const FlamePoser<float>& poser,
                                        const BlendshapeFit& fit,
                                        const BlendshapeSamples& samples);

}  // namespace cosplat
