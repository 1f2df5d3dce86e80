// The properties of cosplatsrc: their table and their values.
#pragma once

#include <cosplat.h>
#include <gst/gst.h>

#include <string>

#include "apps/hosts/avatar_view.h"

namespace cosplat::gstreamer {

struct Fraction {
  int numerator = 0;
  int denominator = 1;
};

// Accessed under the element's object lock.
struct SrcSettings {
  hosts::ViewSettings view;
  std::string background = "avatar";
  hosts::Orbit orbit;
  int width = 512;  // px, if downstream caps leave a choice
  int height = 512;
  Fraction fps = {30, 1};  // frames per second, likewise
  bool is_live = false;
};

void InstallProperties(GObjectClass* object_class);
// Both return false if there is no property with that number.
bool SetSetting(SrcSettings& settings, guint property, const GValue* value);
bool GetSetting(SrcSettings& settings, guint property, GValue* value);

// Values of cosplatsrc's property "stats".
struct SrcStats {
  guint64 frames = 0;     // produced
  guint64 left_out = 0;   // skipped in live mode because they would have been late
  cosplat_health face{};  // its strings point to the ones below
  std::string drive, drive_problem, drive_notes;
};

// Returns true if the drive reports a new problem.
bool Update(SrcStats& stats, const cosplat_health& face);
// The caller owns the result.
GstStructure* ToStructure(const SrcStats& stats);

}  // namespace cosplat::gstreamer
