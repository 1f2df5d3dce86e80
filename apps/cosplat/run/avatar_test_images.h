// Draws tracked frames of an avatar beside their pictures: used while training and by `render`.
#pragma once

#include "apps/cosplat/run/test_images.h"
#include "avatar/play/player.h"
#include "flame/topology.h"
#include "flame/track.h"

namespace cosplat {

class AvatarTestImages {
 public:
  // Keeps a reference to `flame`. The model must have its mesh.
  AvatarTestImages(AvatarModel model, const FlameModel& flame, PlayerSettings settings = {});

  // Renders the frame over the writer's background and writes it beside `truth`, with the mouth's
  // rectangle.
  void WriteTestImage(const TrackedFrame& frame, const Image8& truth, TestImageWriter& writer);

  Player& player() { return player_; }

 private:
  Player player_;
  MeshTopology topology_;
  RenderedImage image_;
};

}  // namespace cosplat
