// An avatar: Gaussians embedded on the triangles of a subject's FLAME mesh.
//
// avatar/train/avatar_subject.h trains it, avatar/io/avatar_file.h stores it, avatar/play/player.h
// renders it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "avatar/math/bust.h"
#include "avatar/math/light.h"
#include "avatar/model/blendshape_map.h"
#include "flame/model.h"
#include "splat/gaussians.h"

namespace cosplat {

// The frame of the viewing direction in which a Gaussian's colour is evaluated.
enum class ColorFrame {
  kSurface,  // d_local = R(q)^T d, q the blended canonical-to-posed rotation at the Gaussian
  kWorld
};

// The subject's shape at zero expression and pose, or as AvatarModel::canonical_frame poses it.
struct CanonicalMesh {
  std::vector<float> vertices;                // [V, 3] metres
  std::vector<std::array<int32_t, 3>> faces;  // [F]
};

// Where the bust is in a frame, relative to its mean place (avatar/math/bust.h).
using BustPose = math::BustMotion<float>;
constexpr BustPose kMeanBustPose{{1, 0, 0, 0}, {0, 0, 0}};

constexpr size_t kBustInputs = 9;   // the head's root turn and translation, its neck's turn
constexpr size_t kBustOutputs = 6;  // the bust's turn (axis-angle, radians) and shift (metres)

// How the bust follows the head where nothing else gives its pose (avatar/model/bust.h): a linear
// map from the head's pose, softly limited to what training showed.
struct BustFollow {
  std::array<float, kBustInputs> head_mean{};
  std::array<float, kBustOutputs * kBustInputs> matrix{};  // row-major
  std::array<float, kBustOutputs> mean{};
  std::array<float, kBustOutputs> min{}, max{};  // in the training frames
};

// Shoulders and clothes, which FLAME does not cover: a sheet below the neck
// (avatar/model/avatar_mesh.h), a rigid body that does not turn with the head.
struct Bust {
  // world_from_canonical: p = rotation * p_canonical + translation; metres.
  std::array<float, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row-major
  std::array<float, 3> translation{};
  std::optional<BustFollow> follow{};  // not set: it stays at this mean place
};

// Follows the mesh by the rule of SplattingAvatar's code release (avatar/math/released.h).
struct ReleasedRule {
  float unit = 0.25f;  // metres per unit of a FLAME mesh enlarged four times (MeshUnit)
};

// Where each Gaussian is on the mesh, and the rule by which it follows the mesh.
struct Embedding {
  Buffer<int32_t> triangle;  // [N] face index
  // [N] (u, v): weights of vertices 0 and 1; that of vertex 2 is 1 - u - v
  Buffer<std::array<float, 2>> barycentric;
  std::optional<ReleasedRule> released{};  // if neither is set: avatar/math/embed.h
  // Gaussians turn and grow with their face, wherever beside it they are, as GaussianAvatars' do
  // (avatar/math/rigid_embed.h). `barycentric` is not used.
  bool rigid = false;

  // `barycentric` as an array [N, 2].
  float* barycentric_data() { return reinterpret_cast<float*>(barycentric.data()); }
  const float* barycentric_data() const {
    return reinterpret_cast<const float*>(barycentric.data());
  }
};

// The range of the training frames' parameters; the avatar was never seen beyond it.
struct TrainedRange {
  std::vector<float> expression_least, expression_most;  // [E] each
  std::array<float, kFlameJoints> angle{};               // radians, the largest per joint
};

// From where the training frames show the head, in its own axes: yaw, to its left, and pitch,
// upwards.
struct FilmedFrom {
  // Radians, least and most; one frame in fifty may be beyond either.
  std::array<float, 2> yaw{}, pitch{};
  // Share of the mesh's surface, without the bust, that no frame shows; unknown where nothing was
  // guessed (avatar/train/virtual_views.h).
  std::optional<float> guessed;
};

// Whether `eye` sees the head from more than 12 degrees beyond that, where it is a guess. face: the
// parameters that it is posed by; center: the head's. Metres, world.
bool IsBeyondFilm(const FilmedFrom& filmed,
                  const FlameParams& face,
                  const math::Vec3<float>& center,
                  const math::Vec3<float>& eye);

// How a frame's parameters choose the weights of the Gaussians' corrections
// (avatar/model/corrections.h). Inputs z: the expression coefficients, then the axis-angles of
// neck, jaw, left and right eye. weight_k = matrix_k (z - mean), softly limited to [least_k,
// most_k].
struct CorrectionMap {
  std::vector<float> mean;      // [Z]
  std::vector<float> matrix;    // [K, Z]
  std::vector<float> min, max;  // [K] in the training frames

  size_t count() const { return min.size(); }
};

// Light that stands still in the world (avatar/math/light.h): [kLightTerms, 3] coefficients.
using Light = std::array<float, 3 * math::kLightTerms>;

struct AvatarModel {
  CanonicalMesh mesh;
  // The frame that `mesh` is posed by, if it is not at rest; only expression, pose and translation
  // are used.
  std::optional<FlameParams> canonical_frame;
  Embedding embedding;
  // kPosition: [N, 3] (delta_u, delta_v, d): offsets from `embedding.barycentric`, d along the
  // normal in metres. kRotation and kScaleLog: in the canonical (rest) frame, before the posed
  // rotation q and the area ratio are applied. With Embedding::rigid all three are in the face's
  // frame and unit.
  Gaussians gaussians;
  ColorFrame color_frame = ColorFrame::kSurface;
  std::optional<Light> light;  // if set, by which base colours are multiplied
  std::optional<Bust> bust;    // if set, `mesh` ends with its sheet

  // The FLAME model it was trained with, and where its licence allows it the model's file itself
  // (FlameModel::file).
  std::string flame_name;
  std::string flame_sha256;
  std::vector<char> flame_file;
  // What was added to that model for the training (flame/mouth.h, flame/eyelids.h,
  // flame/vhap_teeth.h).
  bool has_mouth = false, has_eyelids = false, has_vhap_teeth = false;
  std::vector<float> shape;                  // the subject's coefficients
  std::vector<float> static_offset;          // [V, 3] metres, of all of FLAME's vertices, or empty
  std::array<float, 3> background{1, 1, 1};  // sRGB, used in its evaluation
  std::optional<TrainedRange> trained_range;
  std::optional<FilmedFrom> filmed;
  // From blendshape scores to this head's parameters, if its video had scores.
  std::optional<BlendshapeMap> blendshapes;
  CorrectionMap correction_map;  // for gaussians.corrections bases

  size_t size() const { return gaussians.size(); }
};

// The range of a training track. It is stored in the avatar file, so that live faces can be limited
// to it (avatar/live/soft_range.h). Missing coefficients count as zero; joint angles are those of
// the shorter rotation.
TrainedRange RangeOf(const std::vector<FlameParams>& frames);

}  // namespace cosplat
