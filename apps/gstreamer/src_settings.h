// The properties of cosplatsrc: their table, and what they are set to.
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

// Read and written under the element's object lock.
struct SrcSettings {
  hosts::ViewSettings view;
  std::string background = "avatar";
  hosts::Orbit orbit;
  int width = 512;  // px, where the caps downstream leave the choice
  int height = 512;
  Fraction fps = {30, 1};  // pictures per second, likewise
  bool is_live = false;
};

void InstallProperties(GObjectClass* object_class);
// False if there is no property of that number.
bool SetSetting(SrcSettings& settings, guint property, const GValue* value);
bool GetSetting(SrcSettings& settings, guint property, GValue* value);

// What cosplatsrc says of itself in its property "stats".

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
