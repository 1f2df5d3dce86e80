// The arrays of the FLAME head model (Li et al. 2017), as stored in a model file.
//
// Model files (LoadFlameModel, assets/head/procedural_head.h) -> FlameModel -> flame/pose.h.
// Lengths are in metres; files in other units are converted. This library does not depend on
// Gaussians.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace cosplat {

// Square root of the total area of FLAME 2023's template (5,023 vertices, 9,976 faces), measured as
// sqrt(0.181554 m^2) on the openly licensed release.
constexpr double kFlameTemplateSize = 0.426091;

constexpr int kFlameVertices = 5023;
constexpr int kFlameJoints = 5;  // root, neck, jaw, left eye, right eye
constexpr int kFlamePoseFeatures = 9 * (kFlameJoints - 1);

// How many vertices each part of a mouth has that was added to FLAME's mesh (flame/mouth.h); they
// come last, in this order.
struct MouthParts {
  int upper_teeth = 0, lower_teeth = 0, bowl = 0;
  int vhap_teeth = 0;  // instead of these (flame/vhap_teeth.h)
  int count() const { return upper_teeth + lower_teeth + bowl + vhap_teeth; }
};

// A landmark of a detector as a point of the mesh.
struct EmbeddedLandmark {
  int landmark = 0;                   // index into the detector's points
  std::array<int, 3> vertices;        // of a triangle
  std::array<double, 3> barycentric;  // sum to 1
  // Standard deviation of its error, in units of that of a point seen exactly where it is; in
  // FlameModel::landmarks, in units of that of the detector's firm points.
  double looseness = 1;
};
using LandmarkEmbedding = std::vector<EmbeddedLandmark>;

struct FlameModel {
  std::string name;              // file name without folders, or "procedural"
  std::string sha256;            // of the file's bytes; empty for the procedural head
  bool redistributable = false;  // whether its data may be embedded in an avatar file
  // The bytes of the .npz, where it is redistributable: avatars carry them
  // (avatar/io/avatar_file.h).
  std::vector<char> file;

  double unit = 1;  // metres per unit of the file

  int vertex_count = 0;
  int shape_count = 0;       // S
  int expression_count = 0;  // E

  std::vector<float> template_vertices;       // [V, 3] metres
  std::vector<std::array<int32_t, 3>> faces;  // [F] vertex indices, counter-clockwise outside
  std::vector<float> shape_directions;        // [S, V, 3] metres per unit coefficient
  std::vector<float> expression_directions;   // [E, V, 3]
  // What each does, where it has a meaning of its own: one of ARKit's names
  // (flame/blendshape_names.h), "" if it has none; and the coefficient that is a score of 1. [E]
  // each, or empty: none has.
  std::vector<std::string> expression_names;
  std::vector<float> expression_scores;
  std::vector<float> pose_directions;   // [36, V, 3], of vec(R_1..4 - I), row-major
  std::vector<float> joint_regressor;   // [5, V], rows sum to 1
  std::vector<float> skinning_weights;  // [V, 5], rows sum to 1
  std::array<int, kFlameJoints> parents{-1, 0, 1, 1, 1};
  // Where detectors see MediaPipe's landmarks on this mesh, of a model that people are fitted with
  // in place of FLAME. Empty in FLAME's own files, whose mesh is known (FlameLandmarks,
  // flame/fit/landmark_embedding.h).
  LandmarkEmbedding landmarks;
  MouthParts mouth;  // all zero: the model as its file has it
  // The last two expression coefficients close the left and the right eyelid: they are named
  // eyeBlinkLeft and eyeBlinkRight, or were added (flame/eyelids.h).
  bool has_eyelids = false;

  // Vertices of the file, without an added mouth.
  int own_vertex_count() const { return vertex_count - mouth.count(); }
};

// Parameters of one frame (or of a subject: shape). Missing trailing coefficients count as zero.
struct FlameParams {
  std::vector<float> shape;       // [<= S]
  std::vector<float> expression;  // [<= E]
  // Axis-angle per joint, radians: root, neck, jaw, left eye, right eye.
  std::array<std::array<float, 3>, kFlameJoints> pose{};
  std::array<float, 3> translation{};  // metres, after skinning
  // How far the left and the right eyelid are closed, in trackers' unit: 0 open, 1 closed; fitted
  // values may exceed either. 0 from trackers that do not have it. Not posed: becomes a part of
  // the expression by EyelidsToExpression (flame/track.h).
  std::array<float, 2> eyelids{};
  std::vector<float> static_offset;  // [V, 3] metres, added to the template; or empty

  bool operator==(const FlameParams&) const = default;
};

// Throws Error (naming model.name and the array) unless every array has its size, every index is in
// range, every number is finite and the rows of the weights sum to 1.
void Validate(const FlameModel& model);

// FLAME model files: FLAME's own .pkl, and .npz with the same arrays.
//
//   v_template [V, 3], f or faces [F, 3], shapedirs* [V, 3, S + E] (shape first), posedirs*
//   [V, 3, 36], J_regressor [5, V] (dense or scipy csc), weights [V, 5], kintree_table [2, 5] or
//   parents [5]; optional numbers n_shape, n_expr, redistributable; optional arrays of a model that
//   is not FLAME's mesh, with MediaPipe's landmarks on it: landmark_indices [L], landmark_vertices
//   [L, 3], landmark_barycentric [L, 3], landmark_looseness [L]; and with directions that are
//   ARKit's blendshapes: expression_blendshapes [E], the place in kArkitNames or -1, and
//   expression_scores [E], the coefficient that is a score of 1.
//
// A template of 426 or 43 units, or of 0.0004, is one in millimetres, centimetres or kilometres
// (kFlameTemplateSize, within a factor of 3) and is converted to metres; other sizes are left.
//
// Without n_shape and n_expr, the first 300 directions are shape, as in FLAME's own files, and the
// rest expression. Trailing all-zero directions of either group are dropped: they have no effect
// and make up most of a reduced model.

// The path's extension selects the format. The returned model is valid (Validate); its sha256 is
// that of the file. redistributable is false unless the .npz says otherwise: no FLAME file is
// assumed to be free. Throws Error naming file, array and shape or value.
FlameModel LoadFlameModel(const std::string& path);
// The same of a file's bytes; `path` names it, and is for errors.
FlameModel ParseFlameModel(const std::string& path, std::vector<char> bytes);

// Writes an .npz that LoadFlameModel reads back unchanged (except for name, sha256 and
// file).
void WriteFlameModelNpz(const std::string& path, const FlameModel& model);

}  // namespace cosplat
