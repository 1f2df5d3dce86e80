// LoadTrackedImage for the lean build, which decodes no pictures: those in memory.
#include "flame/track.h"
#include "splat/base/error.h"

namespace cosplat {

Image8 LoadTrackedImage(const TrackedVideo& video, const TrackedFrame& frame) {
  if (!frame.picture) throw Error(video.source, "frame " + frame.name, "has no picture in memory");
  return *frame.picture;
}

}  // namespace cosplat
