// An avatar: Gaussians embedded on the triangles of a subject's FLAME mesh.
//
// trained by avatar/train/trainer.h, stored by avatar/io/avatar_file.h, played by
// avatar/play/player.h.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "flame/model.h"
#include "splat/gaussians.h"

namespace cosplat {

// Frame in which a Gaussian's colour sees the viewing direction.
enum class ColorFrame {
  kSurface,  // d_local = R(q)^T d, q the blended canonical-to-posed rotation at its place
  kWorld
};

// The subject's shape at zero expression and pose, or as AvatarModel::canonical_frame poses it.
struct CanonicalMesh {
  std::vector<float> vertices;                // [V, 3] metres
  std::vector<std::array<int32_t, 3>> faces;  // [F]
};

// What FLAME does not cover: shoulders and clothes. A sheet below the neck
// (avatar/model/avatar_mesh.h) that stays where the subject sat on average instead of turning with
// the head.
struct Bust {
  // world_from_canonical: p = rotation * p_canonical + translation; metres.
  std::array<float, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row-major
  std::array<float, 3> translation{};
};

// SplattingAvatar's way of following the mesh as its code was released (avatar/math/released.h).
struct ReleasedRule {
  float unit = 0.25f;  // metres per unit of a FLAME mesh enlarged four times (MeshUnit)
};

// Where on the mesh each Gaussian is: what is per Gaussian beside `Gaussians`; and how it follows.
struct Embedding {
  Buffer<int32_t> triangle;  // [N] face index
  // [N] (u, v): weights of vertices 0 and 1; 1-u-v of 2
  Buffer<std::array<float, 2>> barycentric;
  std::optional<ReleasedRule> released{};  // nothing: avatar/math/embed.h

  // `barycentric` as [N, 2] numbers.
  float* barycentric_data() { return reinterpret_cast<float*>(barycentric.data()); }
  const float* barycentric_data() const {
    return reinterpret_cast<const float*>(barycentric.data());
  }
};

// The faces that training frames made: beyond them an avatar was never seen.
struct TrainedRange {
  std::vector<float> expression_least, expression_most;  // [E] each
  std::array<float, kFlameJoints> angle{};               // radians, the largest of each joint
};

struct AvatarModel {
  CanonicalMesh mesh;
  // What `mesh` is posed by where it is not at rest: expression, pose and translation alone count.
  std::optional<FlameParams> canonical_frame;
  Embedding embedding;
  // kPosition: [N, 3] (delta_u, delta_v, d): offsets from `embedding.barycentric`, d along the
  // normal in metres. kRotation and kScaleLog: in the canonical (rest) frame, before the posed
  // rotation q and the area ratio are applied.
  Gaussians gaussians;
  ColorFrame color_frame = ColorFrame::kSurface;
  std::optional<Bust> bust;  // `mesh` ends with its sheet where there is one

  // The FLAME model it was trained with: never embedded unless its licence allows.
  std::string flame_name;
  std::string flame_sha256;
  std::vector<float> shape;                  // the subject's coefficients
  std::vector<float> static_offset;          // [V, 3] metres, or empty
  std::array<float, 3> background{1, 1, 1};  // sRGB that it was evaluated on
  std::optional<TrainedRange> trained_range;

  size_t size() const { return gaussians.size(); }
};

// The range of faces in a training track: recorded in the avatar file, so that a player can bring
// what the avatar was never seen doing back to it (avatar/live/soft_range.h).

// Missing coefficients count as zero. Joints by the shorter way round.
TrainedRange RangeOf(const std::vector<FlameParams>& frames);

}  // namespace cosplat
