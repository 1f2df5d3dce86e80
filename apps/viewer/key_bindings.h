// Key bindings of the viewer, also listed in its help.
#pragma once

#include <vector>

#include "apps/viewer/session.h"

namespace cosplat::viewer {

struct KeyBinding {
  int key;            // GLFW key code
  const char* label;  // name of the key
  const char* text;   // what the key does
  Action action;
  bool repeats;  // while the key is held
};
const std::vector<KeyBinding>& KeyBindings();

}  // namespace cosplat::viewer
