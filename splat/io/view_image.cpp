#include <cmath>
#include <string>
#include <utility>

#include "splat/base/error.h"
#include "splat/io/dataset.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

// What is at least as bright counts as white.
constexpr uint8_t kWhite = 128;

// 255 where the mask, brought to the image's size, is black anywhere in a pixel.
Image8 IgnoredIn(Image8 kept) {
  for (uint8_t& value : kept.data) value = value < 255 ? 255 : 0;
  return kept;
}

Image8 ReadMask(const std::string& path, const Camera& camera) {
  const Image8 image = MatteOf(ReadUpright(path));
  const double expected = double(camera.width) * image.height / camera.height;
  if (std::abs(expected - image.width) > 1)
    throw Error(path,
                "mask is " + SizeText(image.width, image.height) + ", its image " +
                    SizeText(camera.width, camera.height));
  Image8 mask(image.width, image.height, 1);
  for (size_t i = 0; i < mask.pixels(); ++i) mask.data[i] = image.data[i] < kWhite ? 0 : 255;
  return mask;
}

Image8 Straight(Image8 image, const SceneView& view) {
  if (view.distortion.model != Distortion::Model::kNone) {
    const Camera pinhole = view.camera.Resized(image.width, image.height);
    image = Undistort(image, view.file_camera, view.distortion, pinhole);
  }
  return ResizeByArea(image, view.camera.width, view.camera.height);
}

}  // namespace

Image8 LoadViewImage(const SceneView& view) {
  Image8 image = Upright(ReadImage(view.image_path), view.orientation);
  if (image.width != view.file_camera.width || image.height != view.file_camera.height)
    throw Error(view.image_path,
                "image is " + SizeText(image.width, image.height) + ", expected " +
                    SizeText(view.file_camera.width, view.file_camera.height));
  if (image.channels == 1) image = RgbOf(image);
  return Straight(std::move(image), view);
}

Image8 LoadIgnored(const SceneView& view) {
  if (view.mask_path.empty()) return {};
  Image8 kept = ReadMask(view.mask_path, view.file_camera);
  kept = ResizeByArea(kept, view.file_camera.width, view.file_camera.height);
  return IgnoredIn(Straight(std::move(kept), view));
}

}  // namespace cosplat
