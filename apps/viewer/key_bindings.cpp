#include "apps/viewer/key_bindings.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace cosplat::viewer {

const std::vector<KeyBinding>& KeyBindings() {
  static const std::vector<KeyBinding> bindings = {
      {GLFW_KEY_SPACE, "Space", "play, pause", Action::kTogglePlay, false},
      {GLFW_KEY_LEFT, "Left", "a frame back", Action::kStepBack, true},
      {GLFW_KEY_RIGHT, "Right", "a frame on", Action::kStepForward, true},
      {GLFW_KEY_HOME, "Home", "to the first frame", Action::kToStart, false},
      {GLFW_KEY_L, "L", "loop", Action::kToggleLoop, false},
      {GLFW_KEY_R, "R", "reset the camera", Action::kResetView, false},
      {GLFW_KEY_N, "N", "neutral face", Action::kNeutralFace, false},
      {GLFW_KEY_F, "F", "random face", Action::kRandomFace, false},
      {GLFW_KEY_C, "C", "live: you look straight ahead", Action::kCalibrate, false},
      {GLFW_KEY_D, "D", "start, stop the drive in the panel", Action::kToggleDrive, false},
      {GLFW_KEY_1, "1", "splats", Action::kViewSplats, false},
      {GLFW_KEY_2, "2", "ellipsoids", Action::kViewEllipsoids, false},
      {GLFW_KEY_3, "3", "triangles by count", Action::kViewTriangles, false},
      {GLFW_KEY_4, "4", "wire mesh", Action::kViewWire, false},
      {GLFW_KEY_T, "T", "transparent background", Action::kToggleTransparent, false},
      {GLFW_KEY_S, "S", "screenshot", Action::kScreenshot, false},
      {GLFW_KEY_V, "V", "start, stop a video", Action::kToggleRecording, false},
      {GLFW_KEY_TAB, "Tab", "hide, show the panels", Action::kTogglePanels, false},
      {GLFW_KEY_H, "H", "this help", Action::kToggleHelp, false},
      {GLFW_KEY_Q, "Q", "quit", Action::kQuit, false}};
  return bindings;
}

}  // namespace cosplat::viewer
