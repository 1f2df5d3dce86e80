// The viewer's keys, for the window and for its help.
#pragma once

#include <vector>

#include "apps/viewer/session.h"

namespace cosplat::viewer {

struct KeyBinding {
  int key;            // GLFW's code
  const char* label;  // of the key
  const char* text;   // what it does
  Action action;
  bool repeats;  // while it is held
};
const std::vector<KeyBinding>& KeyBindings();

}  // namespace cosplat::viewer
