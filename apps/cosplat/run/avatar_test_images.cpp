#include "apps/cosplat/run/avatar_test_images.h"

#include "avatar/surface/silhouette.h"

namespace cosplat {

AvatarTestImages::AvatarTestImages(AvatarModel model,
                                   const FlameModel& flame,
                                   PlayerSettings settings)
    : player_(std::move(model), flame, settings),
      topology_(BuildTopology(
          "avatar", player_.avatar().mesh.faces, int(player_.avatar().mesh.vertices.size() / 3))) {}

void AvatarTestImages::WriteTestImage(const TrackedFrame& frame,
                                      const Image8& truth,
                                      TestImageWriter& writer) {
  player_.RenderOver(frame.params, frame.camera, writer.background(), image_);
  const std::array<int, 4> box =
      MouthBox(player_.vertices(), player_.avatar().mesh.vertices, topology_, frame.camera);
  const Rectangle mouth{box[0], box[1], box[2], box[3]};
  writer.Write(image_, truth, mouth.width > 0 ? &mouth : nullptr);
}

}  // namespace cosplat
