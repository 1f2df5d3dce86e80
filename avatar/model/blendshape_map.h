// A linear map from the blendshape scores of a face tracker to FLAME's parameters.
//
// of this head, fitted to its video (avatar/train/blendshape_fit.h), stored in the avatar file;
// of any head (GeneralBlendshapeMap); or a user's (avatar/live/blendshape_matrix.h)
//   -> BlendshapeMap -> ApplyBlendshapes -> LiveFrame.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "flame/blendshape_names.h"
#include "flame/model.h"

namespace cosplat {

// Scores by their names.
using BlendshapeScores = std::map<std::string, float>;

// Outputs after the expression coefficients: the axis-angles of jaw, left eye and right eye.
constexpr size_t kMappedTurns = 9;
constexpr size_t kMaxBlendshapes = 1024;  // in a map
// The largest magnitude that an output can reach: beyond it are no faces (avatar/live/guard.h).
constexpr float kMaxMapped = 100;
// Scores are 0 to 1, and smoothing takes some a little beyond. Larger magnitudes are of another
// scale, such as percent, and are no scores.
constexpr float kMaxScore = 2;

// How a fitted map did on frames that it had not seen.
struct BlendshapeFitFigures {
  int frames = 0;             // that it was fitted to; 0: the map is not fitted
  float r2 = 0;               // share of the squared motion of the vertices that is predicted
  float error = 0;            // metres, mean distance of the vertices that expressions move
  float mean_face_error = 0;  // metres, the same of the mean face, which ignores the scores
};

// output_o = offset_o + sum over c of matrix_co * score_c, scores limited softly to [least_c,
// most_c].
struct BlendshapeMap {
  std::vector<std::string> names;  // [C], of the scores
  std::vector<float> min, max;     // [C] in the frames that it was fitted to, within 0 to 1
  std::vector<float> offset;       // [E + kMappedTurns] at scores of zero
  std::vector<float> matrix;       // [C, E + kMappedTurns], a row per score
  BlendshapeFitFigures fit;

  size_t expression_count() const { return offset.size() - kMappedTurns; }
};

// What is wrong with a map's contents, as "field: problem", or "": a size, a number that is not
// finite, a name that is empty or occurs twice, a range that is empty or beyond 0 to 1, or an
// output that can exceed kMaxMapped.
std::string ProblemOf(const BlendshapeMap& map);

// Index in `names`, in any spelling (NormalName); -1 for an unknown name.
int FindBlendshape(const BlendshapeMap& map, std::string_view name);

// Sets expression, jaw and eyes. scores: [C]; those beyond 0 to 1 count as 0 or 1.
void ApplyBlendshapes(const BlendshapeMap& map,
                      const std::vector<float>& scores,
                      FlameParams& params);
// The same by name: scores that the map does not have are ignored, those that are missing are 0.
void ApplyBlendshapes(const BlendshapeMap& map,
                      const BlendshapeScores& scores,
                      FlameParams& params);

// What holds for any head by the meaning of ARKit's names: jawOpen turns the jaw, eyeLook the eyes,
// eyeBlink closes the lids if `flame` has them (flame/eyelids.h), and a name moves the direction
// that has it (FlameModel::expression_names: our own head's). All others do nothing, since FLAME's
// expression coefficients have no meaning of their own. flame: null if unknown.
BlendshapeMap GeneralBlendshapeMap(const FlameModel* flame);

}  // namespace cosplat
