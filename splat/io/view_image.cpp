#include <string>

#include "splat/base/error.h"
#include "splat/io/dataset.h"

namespace cosplat {
namespace {

Image8 GreyToRgb(const Image8& grey) {
  Image8 rgb(grey.width, grey.height, 3);
  for (size_t i = 0; i < grey.pixels(); ++i)
    for (int c = 0; c < 3; ++c) rgb.data[3 * i + c] = grey.data[i];
  return rgb;
}

// The image with the mask's first channel as alpha, replacing any alpha of the image.
Image8 WithMask(const Image8& image, const std::string& mask_path) {
  Image8 mask = ReadImage(mask_path);
  const double expected = double(image.width) * mask.height / image.height;
  if (std::abs(expected - mask.width) > 1)
    throw Error(mask_path,
                "mask is " + SizeText(mask.width, mask.height) + ", its image " +
                    SizeText(image.width, image.height));
  mask = ResizeByArea(mask, image.width, image.height);
  Image8 result(image.width, image.height, 4);
  for (size_t i = 0; i < image.pixels(); ++i) {
    for (int c = 0; c < 3; ++c) result.data[4 * i + c] = image.data[i * image.channels + c];
    result.data[4 * i + 3] = mask.data[i * mask.channels];
  }
  return result;
}

}  // namespace

Image8 LoadViewImage(const SceneView& view) {
  Image8 image = ReadImage(view.image_path);
  if (image.width != view.file_camera.width || image.height != view.file_camera.height)
    throw Error(view.image_path,
                "image is " + SizeText(image.width, image.height) + ", expected " +
                    SizeText(view.file_camera.width, view.file_camera.height));
  if (image.channels == 1) image = GreyToRgb(image);
  if (!view.mask_path.empty()) image = WithMask(image, view.mask_path);
  if (view.distortion.model != Distortion::Model::kNone) {
    const Camera pinhole = view.camera.Resized(image.width, image.height);
    image = Undistort(image, view.file_camera, view.distortion, pinhole);
  }
  return ResizeByArea(image, view.camera.width, view.camera.height);
}

}  // namespace cosplat
