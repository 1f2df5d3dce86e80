// The mesh that an avatar's Gaussians live on: FLAME's head and, where the subject needs it, a
// bust.
//
// FlameModel + shape -> MakeCanonicalMesh -> Surface; FlameParams -> AvatarPoser -> posed vertices
// -> Surface::Pose. FLAME ends at the neck and turns as a whole with the head's root joint;
// shoulders bound to it would swing with every nod (GaussianAvatars issue 97). The bust is a sheet
// of its own that keeps still in the world.
#pragma once

#include <optional>
#include <vector>

#include "avatar/model/avatar_model.h"
#include "flame/model.h"
#include "flame/pose.h"

namespace cosplat {

// The subject's shape at zero expression and pose, or as `frame` poses it; the bust's vertices and
// faces come last.
CanonicalMesh MakeCanonicalMesh(const FlameModel& flame,
                                const std::vector<float>& shape,
                                const std::vector<float>& static_offset,
                                const std::optional<Bust>& bust,
                                const std::optional<FlameParams>& frame = {});

class AvatarPoser {
 public:
  using Frame = FlamePoser<float>::Frame;

  // Keeps a reference to `flame`.
  AvatarPoser(const FlameModel& flame,
              const std::vector<float>& shape,
              const std::vector<float>& static_offset,
              const std::optional<Bust>& bust);

  // The frame's parameters; expression coefficients beyond the model's are left out.
  Frame FrameFor(const FlameParams& params) const;
  // The same, keeping the memory of `frame`.
  void FrameFor(const FlameParams& params, Frame& frame) const;
  // vertices: [vertex_count, 3] metres. Throws Error when a parameter is not finite; nothing is
  // written then. What did not change since the last call is not computed again.
  void Forward(const Frame& frame, std::vector<float>& vertices);
  // Cheaper right after the Forward of the same frame.
  Frame Backward(const Frame& frame, View<const float> d_vertices);
  // The head's part, and the bust's vertices, which are the same in every frame: [K, 3] metres.
  const FlamePoser<float>& flame() const { return poser_; }
  const std::vector<float>& bust() const { return posed_bust_; }
  size_t vertex_count() const { return flame_vertices_ + posed_bust_.size() / 3; }

 private:
  FlamePoser<float> poser_;
  FlamePoser<float>::Cache cache_;
  size_t flame_vertices_;
  std::vector<float> posed_bust_;
};

// The frames' mean root rotation and translation, everything else zero.
FlameParams MeanRoot(const std::vector<FlameParams>& frames);

// Somebody else's motion for this avatar: the frames' root turns and moves about `rest` as it did
// about its own mean; expression, neck, jaw and eyes stay. rest: the avatar's mean root.
std::vector<FlameParams> Retarget(std::vector<FlameParams> frames, const FlameParams& rest);

// A root that is counted from the avatar's rest, on that rest: its turn comes after the rest's, its
// translation is added.
void PutOnRest(const FlameParams& rest, FlameParams& frame);

// Where the bust stands: the frames' mean root transform.
Bust MeanBust(const FlameModel& flame,
              const std::vector<float>& shape,
              const std::vector<float>& static_offset,
              const std::vector<FlameParams>& frames);

// Where the head sits when nothing drives it, as root pose and translation: on its bust (the
// inverse of MeanBust); without one, where the canonical mesh has it.
FlameParams RestRoot(const AvatarModel& avatar, const FlameModel& flame);

}  // namespace cosplat
