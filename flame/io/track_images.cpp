// The images of tracked videos: the code that reads images and videos.
#include "flame/io/track_layouts.h"
#include "flame/track.h"
#include "splat/base/error.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

Image8 ReadFrameImage(const TrackedVideo& video, const TrackedFrame& frame) {
  if (!frame.image_path.empty()) return Upright(ReadImage(frame.image_path), frame.orientation);
  if (!video.video || frame.video_frame < 0)
    throw Error(video.source, "frame " + frame.name, "has no image");
  return video.video->ReadFrame(frame.video_frame);
}

std::string ImageName(const TrackedVideo& video, const TrackedFrame& frame) {
  return frame.image_path.empty() ? video.video_path : frame.image_path;
}

class ImagesOnDisk : public ImageFiles {
 public:
  ImageInfo Info(const std::string& image) const override { return ReadImageInfo(image); }
  Video OpenVideo(const std::string& path) const override {
    Video video;
    video.reader = std::make_shared<VideoReader>(path);
    video.frame_count = video.reader->frame_count();
    const Image8 first = video.reader->ReadFrame(0);
    video.size = {first.width, first.height, first.channels};
    video.notes = video.reader->notes();
    return video;
  }
};

}  // namespace

TrackedVideo LoadTrackedVideo(const std::string& path, const TrackOptions& options) {
  const ImagesOnDisk images;
  return LoadTrack(path, {options, &images});
}

Image8 LoadTrackedImage(const TrackedVideo& video, const TrackedFrame& frame) {
  if (frame.image) return *frame.image;
  const Image8 image = ReadFrameImage(video, frame);
  const Camera& camera = frame.camera;
  if (ProportionsDiffer(camera.width, camera.height, image.width, image.height))
    throw Error(ImageName(video, frame),
                "image is " + SizeText(image.width, image.height) + ", its camera " +
                    SizeText(camera.width, camera.height));
  Image8 matte = frame.mask_path.empty() ? Image8() : MatteOf(ReadUpright(frame.mask_path));
  if (!matte.empty() && (matte.width != image.width || matte.height != image.height))
    throw Error(frame.mask_path,
                "mask is " + SizeText(matte.width, matte.height) + ", its image " +
                    SizeText(image.width, image.height));
  const bool has_alpha = SaysAlpha(image);  // counts before the mask
  if (matte.empty() && !has_alpha && image.channels != 1)
    return ResizeByArea(RgbOf(image), camera.width, camera.height);
  Image8 rgba(image.width, image.height, 4, 255);
  const int n = image.channels;
  for (size_t i = 0; i < image.pixels(); ++i) {
    for (int c = 0; c < 3; ++c) rgba.data[4 * i + c] = image.data[n * i + (n == 1 ? 0 : c)];
    if (has_alpha) rgba.data[4 * i + 3] = image.data[4 * i + 3];
    if (!has_alpha && !matte.empty()) rgba.data[4 * i + 3] = matte.data[i];
    if (video.masks_inverted && (has_alpha || !matte.empty()))
      rgba.data[4 * i + 3] = uint8_t(255 - rgba.data[4 * i + 3]);
  }
  return ResizeByArea(rgba, camera.width, camera.height);
}

}  // namespace cosplat
