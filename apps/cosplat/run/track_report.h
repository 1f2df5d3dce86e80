// What a track looks like: the mesh over the video, and its distance from the landmarks.
#pragma once

#include "apps/cosplat/run/track_run.h"

namespace cosplat {

// The frame with the fitted mesh shaded over it; landmarks as seen in green, as fitted in red.
Image8 DrawOverlay(const TrackRun& run, size_t frame, const Image8& image);

// Writes <out>/track.json (figures per frame), <out>/track.html (the same to look at),
// <out>/skipped_frames.json if there are some, and, if asked for, the overlay of every frame that
// is kept.
void WriteTrackReport(const TrackRunOptions& options,
                      const TrackRun& run,
                      const FrameSource& frames);

}  // namespace cosplat
