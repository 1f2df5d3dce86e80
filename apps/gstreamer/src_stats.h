// What cosplatsrc says of itself in its property "stats".
#pragma once

#include <cosplat.h>
#include <gst/gst.h>

#include <string>

namespace cosplat::gstreamer {

struct SrcStats {
  guint64 frames = 0;     // made
  guint64 left_out = 0;   // live, because they would have been late
  cosplat_health face{};  // its texts are the ones below
  std::string drive, drive_problem;
};

// True if the drive dropped something for another reason than before.
bool Update(SrcStats& stats, const cosplat_health& face);
// The caller's to free.
GstStructure* ToStructure(const SrcStats& stats);

}  // namespace cosplat::gstreamer
