// LoadTrackedImage for the lean build, which decodes no images: those in memory.
#include "flame/track.h"
#include "splat/base/error.h"

namespace cosplat {

Image8 LoadTrackedImage(const TrackedVideo& video, const TrackedFrame& frame) {
  if (!frame.image) throw Error(video.source, "frame " + frame.name, "has no image in memory");
  return *frame.image;
}

}  // namespace cosplat
