#include "apps/gstreamer/src_settings.h"

namespace cosplat::gstreamer {

namespace {

const char* NameOf(uint32_t face) {
  switch (face) {
    case COSPLAT_FACE_LIVE:
      return "live";
    case COSPLAT_FACE_DECAYING:
      return "decaying";
    case COSPLAT_FACE_RETURNING:
      return "returning";
    default:
      return "rest";
  }
}

}  // namespace

bool Update(SrcStats& stats, const cosplat_health& face) {
  stats.face = face;
  stats.drive = face.drive;
  stats.drive_notes = face.drive_notes ? face.drive_notes : "";  // null from 0.2.0
  const bool another = stats.drive_problem != face.drive_problem;
  if (another) stats.drive_problem = face.drive_problem;
  return another && !stats.drive_problem.empty();
}

GstStructure* ToStructure(const SrcStats& stats) {
  const cosplat_health& f = stats.face;
  GstStructure* out = gst_structure_new_empty("cosplat-stats");
  const auto number = [&](const char* name, guint64 value) {
    gst_structure_set(out, name, G_TYPE_UINT64, value, nullptr);
  };
  const auto text = [&](const char* name, const char* value) {
    gst_structure_set(out, name, G_TYPE_STRING, value, nullptr);
  };
  number("frames", stats.frames);
  number("left-out", stats.left_out);
  text("face", NameOf(f.face));
  number("accepted", f.accepted);
  number("refused", f.late + f.not_finite + f.out_of_range + f.wrong_size);
  number("softened", f.softened);
  number("beyond-film", f.beyond_film);
  number("held", f.held);
  number("decayed", f.decayed);
  text("drive", stats.drive.c_str());
  number("drive-packets", f.drive_packets);
  number("drive-unusable", f.drive_unusable);
  number("drive-frames", f.drive_frames);
  number("drive-replaced", f.drive_replaced);
  number("drive-dropped",
         f.drive_reordered + f.drive_malformed + f.drive_oversize + f.drive_flooded);
  text("drive-problem", stats.drive_problem.c_str());
  text("drive-notes", stats.drive_notes.c_str());
  return out;
}

}  // namespace cosplat::gstreamer
