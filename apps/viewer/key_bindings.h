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

struct KeyPress {
  int key = 0;             // GLFW key code
  bool is_repeat = false;  // of a key that is held
};

}  // namespace cosplat::viewer
