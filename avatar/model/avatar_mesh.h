// The mesh that an avatar's Gaussians are embedded on: FLAME's head and, where the subject needs
// it, a bust.
//
// FlameModel + shape -> MakeCanonicalMesh -> Surface; FlameParams -> AvatarPoser -> posed vertices
// -> Surface::Pose. FLAME ends at the neck and rotates as a whole with the head's root joint;
// shoulders bound to it would swing with every nod (GaussianAvatars issue 97). The bust is a
// separate sheet and a rigid body of its own.
#pragma once

#include <optional>
#include <vector>

#include "avatar/model/avatar_model.h"
#include "flame/model.h"
#include "flame/pose.h"

namespace cosplat {

// `flame`, as its file has it, as the avatar was trained on it: with what was added to it. Throws
// Error if that cannot be added to this model.
FlameModel FlameOf(const AvatarModel& avatar, FlameModel flame);

// The subject's shape at zero expression and pose or, if given, as `frame` poses it. The bust's
// vertices and faces come last.
CanonicalMesh MakeCanonicalMesh(const FlameModel& flame,
                                const std::vector<float>& shape,
                                const std::vector<float>& static_offset,
                                const std::optional<Bust>& bust,
                                const std::optional<FlameParams>& frame = {});

class AvatarPoser {
 public:
  struct Parameters : FlamePoser<float>::Parameters {
    BustPose bust = kMeanBustPose;
  };

  // Keeps a reference to `flame`.
  AvatarPoser(const FlameModel& flame,
              const std::vector<float>& shape,
              const std::vector<float>& static_offset,
              const std::optional<Bust>& bust);

  // Converts parameters; expression coefficients that the model does not have are ignored. The bust
  // follows the head if it has learned to, else it is at its mean place.
  Parameters ParametersFor(const FlameParams& params) const;
  // The same, reusing the memory of `parameters`.
  void ParametersFor(const FlameParams& params, Parameters& parameters) const;
  // vertices: [vertex_count, 3] metres. Throws Error when a parameter is not finite, without
  // writing anything. Parts that have not changed since the last call are not recomputed.
  void Forward(const Parameters& parameters, std::vector<float>& vertices);
  // Cheaper right after Forward of the same frame.
  Parameters Backward(const Parameters& parameters, View<const float> d_vertices);
  // The head's poser.
  const FlamePoser<float>& flame() const { return poser_; }
  // The bust's vertices at its mean place, [K, 3] metres, and the middle of its collar.
  const std::vector<float>& bust() const { return mean_bust_; }
  const math::Vec3<float>& bust_pivot() const { return bust_pivot_; }
  size_t vertex_count() const { return flame_vertices_ + mean_bust_.size() / 3; }

 private:
  FlamePoser<float> poser_;
  FlamePoser<float>::Cache cache_;
  size_t flame_vertices_;
  std::optional<Bust> bust_;
  std::vector<float> mean_bust_;
  math::Vec3<float> bust_pivot_{0, 0, 0};
};

// Where a posed head is.
struct HeadPlace {
  math::Mat3<float> world_from_head;  // in its own axes y is up and the face looks along +z
  math::Vec3<float> center;           // of its box in these axes; in the world, metres
  float extent;                       // metres, that box's larger side seen from the front
};
// vertices: [V, 3], without the bust's; root: axis-angle of the root joint.
HeadPlace PlaceOfHead(View<const float> vertices, const std::array<float, 3>& root);
// A portrait of it: the lens's focal length in sides of the image, for 28 degrees across, and the
// share of the side that the head fills.
constexpr float kPortraitFocal = 2, kPortraitShare = 0.7f;

// The frames' mean root rotation and translation, everything else zero.
FlameParams MeanRoot(const std::vector<FlameParams>& frames);
// By how much each frame's head, root and neck together, is turned from their mean: radians.
std::vector<float> HeadTurns(const std::vector<FlameParams>& frames);

// Transfers another subject's motion: the frames' root moves about `rest` as it did about its own
// mean; expression, neck, jaw and eyes are kept. rest: the avatar's root at rest.
std::vector<FlameParams> Retarget(std::vector<FlameParams> frames, const FlameParams& rest);

// Turns a root relative to the avatar's rest into an absolute one: its rotation is applied after
// that of `rest`, its translation is added.
void PutOnRest(const FlameParams& rest, FlameParams& frame);

// The placement of the bust: the frames' mean root transform.
Bust MeanBust(const FlameModel& flame,
              const std::vector<float>& shape,
              const std::vector<float>& static_offset,
              const std::vector<FlameParams>& frames);

// Root pose and translation of the head when nothing drives it: on its bust (the inverse of
// MeanBust) or, without one, as in the canonical mesh.
FlameParams RestRoot(const AvatarModel& avatar, const FlameModel& flame);

}  // namespace cosplat
