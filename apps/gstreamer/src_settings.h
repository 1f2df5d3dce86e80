// The properties of cosplatsrc: their table, and what they are set to.
#pragma once

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

}  // namespace cosplat::gstreamer
