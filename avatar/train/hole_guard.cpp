#include "avatar/train/hole_guard.h"

#include "avatar/surface/kernels/holes.h"
#include "splat/device/for_each.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

bool HoleGuard::Begin(const Gaussians& gaussians,
                      FaceListArrays by_face,
                      size_t face_count,
                      View<const uint8_t> unwanted,
                      Stream& stream) {
  const size_t n = gaussians.size();
  last_.Refill(n, stream);
  any_.Refill(face_count + 1, stream);
  logits_.Refill(n, stream);
  ForEach(face_count + 1, stream, FindLast{by_face, unwanted, last_.view(), any_.view()});
  ForEach(n, stream, ThinOut{gaussians.values[kOpacityLogit].view(), unwanted, logits_.view()});
  stream.ExclusiveSum(any_);
  uint64_t faces = 0;
  stream.Download(&faces, any_.data() + face_count, sizeof(faces));
  stream.Wait();
  return faces > 0;
}

void HoleGuard::Spare(const Canvas& canvas,
                      const WorldGaussians& world,
                      Basis basis,
                      const Camera& camera,
                      const Buffer<uint8_t>& silhouette,
                      View<uint8_t> unwanted) {
  Stream& stream = canvas.rasterizer.stream();
  const RenderSettings black{{0, 0, 0}, 0};
  WorldGaussians thinned = world;
  thinned.opacity_logit = logits_.data();
  canvas.rasterizer.Forward(thinned, basis, camera, black, canvas.image, canvas.tape);
  after_.swap(canvas.image.transmittance);
  canvas.rasterizer.Forward(world, basis, camera, black, canvas.image, canvas.tape);
  holes_.Refill(silhouette.size(), stream);
  ForEach(silhouette.size(),
          stream,
          FindHoles{
              silhouette.view(), canvas.image.transmittance.view(), after_.view(), holes_.view()});
  ForEach(world.count,
          stream,
          SpareOne{{holes_.data(), camera.width, camera.height},
                   ViewOfCamera(camera, basis, 0),
                   world.position,
                   last_.view(),
                   canvas.tape.radii(),
                   unwanted});
}

}  // namespace cosplat
