#include "avatar/play/rig_poser.h"

#include <utility>

#include "avatar/model/place_bust.h"
#include "flame/kernels/pose.h"
#include "splat/device/for_each.h"

namespace cosplat {

std::shared_ptr<const PosingDirections> DirectionStore::Get(const PosingArrays<float>& flame,
                                                            Stream& stream) {
  const std::lock_guard lock(mutex_);
  std::erase_if(known_, [](const auto& entry) { return entry.second.expired(); });
  std::weak_ptr<const PosingDirections>& known = known_[flame.pose_directions];
  if (auto directions = known.lock()) return directions;
  const size_t rows = 3 * flame.vertex_count;
  const auto directions = std::make_shared<PosingDirections>();
  directions->expression.Upload(flame.expression_directions, flame.expression_count * rows, stream);
  directions->pose.Upload(flame.pose_directions, kFlamePoseFeatures * rows, stream);
  // Other renderers read the directions in their own streams.
  stream.Wait();
  known = directions;
  return directions;
}

RigPoser::RigPoser(const AvatarPosing& posing, DirectionStore& store, Stream& stream)
    : directions_(store.Get(posing.flame, stream)),
      bust_pivot_(posing.bust_pivot),
      arrays_(posing.flame) {
  const size_t vertices = arrays_.vertex_count;
  shaped_.Upload(arrays_.shaped, 3 * vertices, stream);
  weights_.Upload(arrays_.weights, kFlameJoints * vertices, stream);
  unskinned_.Refill(3 * vertices, stream);
  mean_bust_.Upload(posing.bust.data, posing.bust.count, stream);
  vertices_.Refill(3 * vertices + posing.bust.count, stream);
  stream.Wait();
  arrays_.shaped = shaped_.data();
  arrays_.weights = weights_.data();
  arrays_.expression_directions = directions_->expression.data();
  arrays_.pose_directions = directions_->pose.data();
}

const Buffer<float>& RigPoser::Pose(const AvatarRig& avatar_rig, Stream& stream) {
  const FlameRig<float>& rig = avatar_rig.flame;
  terms_.Upload(rig.terms, stream);
  ForEach(3 * arrays_.vertex_count,
          stream,
          flame_math::BlendShapesKernel<float>{arrays_,
                                               terms_.data(),
                                               rig.expression_terms,
                                               rig.terms.size() - rig.expression_terms,
                                               unskinned_.data()});
  ForEach(arrays_.vertex_count,
          stream,
          flame_math::SkinKernel<float>(rig, weights_.data(), unskinned_.data(), vertices_.data()));
  if (mean_bust_.empty()) return vertices_;
  bust_pose_.Upload(&avatar_rig.bust, 1, stream);
  ForEach(mean_bust_.size() / 3,
          stream,
          PlaceBust{std::as_const(mean_bust_).view(),
                    bust_pivot_,
                    bust_pose_.data(),
                    vertices_.data() + 3 * arrays_.vertex_count});
  return vertices_;
}

}  // namespace cosplat
