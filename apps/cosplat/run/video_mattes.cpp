#include "apps/cosplat/run/video_mattes.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <utility>

#include "flame/io/landmarks.h"
#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// For each frame the matte of its name; in order if one has none and there are as many.
std::vector<int> PlacesOf(const std::string& path,
                          const FrameSource& mattes,
                          const FrameSource& frames) {
  std::map<std::string, int> by_name;
  for (int m = 0; m < mattes.count(); ++m) by_name[mattes.Name(m)] = m;
  std::vector<int> named, ordered;
  std::string missing;
  for (int f = 0; f < frames.count(); ++f) {
    ordered.push_back(f);
    const auto found = by_name.find(frames.Name(f));
    if (found != by_name.end())
      named.push_back(found->second);
    else if (missing.empty())
      missing = frames.Name(f);
  }
  if (missing.empty()) return named;
  if (mattes.count() == frames.count()) return ordered;
  throw Error(path,
              Format("has {} mattes for {} frames, and none for frame '{}'",
                     mattes.count(),
                     frames.count(),
                     missing));
}

}  // namespace

OwnMattes::OwnMattes(const std::string& path, const FrameSource& frames)
    : mattes_(path, Bars::kKeep), is_video_(!std::filesystem::is_directory(path)) {
  const Crop &own = mattes_.in_file(), &filmed = frames.in_file();
  if (own.width == filmed.width && own.height == filmed.height) mattes_.EndAt(frames.picture());
  if (mattes_.width() != frames.width() || mattes_.height() != frames.height())
    throw Error(path,
                Format("mattes are {}, the frames {}",
                       SizeText(mattes_.width(), mattes_.height()),
                       SizeText(frames.width(), frames.height())));
  place_ = PlacesOf(path, mattes_, frames);
}

Image8 OwnMattes::Read(int frame) const {
  const int place = place_.at(size_t(frame));
  if (const std::optional<Image8> alpha = mattes_.Matte(place)) return *alpha;
  const Image8 image = mattes_.Read(place);
  if (!is_video_) return MatteOf(image);
  // A codec's black is not quite 0, which must not be taken for labels.
  return ChannelOf(image, 0);
}

std::optional<FaceBox> FaceBoxOf(const LandmarkFrame& frame) {
  if (frame.faces.empty()) return {};
  return BoxOf(frame.faces[0].points);
}

MatteRefiner RefinerOf(const LandmarkVideo& video,
                       std::function<Image8(int)> image,
                       std::function<Image8(int)> matte) {
  constexpr double kNetwork = 256;  // MediaPipe's selfie segmentation
  std::vector<std::optional<FaceBox>> faces;
  for (const LandmarkFrame& frame : video.frames) faces.push_back(FaceBoxOf(frame));
  return MatteRefiner({int(video.frames.size()),
                       std::move(image),
                       std::move(matte),
                       [faces](int f) { return faces[size_t(f)]; },
                       std::max(1., std::max(video.width, video.height) / kNetwork)});
}

}  // namespace cosplat
