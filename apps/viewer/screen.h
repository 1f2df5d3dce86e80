// What the window shows, drawn with Dear ImGui: the image, the panels, the timeline, the help.
//
// ViewerWindow -> DrawScreen, once per turn, between ImGui's NewFrame and Render. It changes the
// session as the mouse, the keys and the panels say, and returns what is the window's to do.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/viewer/session.h"
#include "apps/viewer/time_history.h"

namespace cosplat::viewer {

// Made by the window.
struct ScreenState {
  float scale = 1;               // of everything; 1 for 96 dots per inch
  intptr_t texture = 0;          // OpenGL's name of the image; 0: none yet
  int width = 0, height = 0;     // of the image, px
  int divisor = 1;               // of the sides that were wanted
  TimeHistory drawing, latency;  // milliseconds per image
  double recorded_seconds = -1;  // of a video that is being made; < 0: none is
  std::string notice;            // one line for people; "": none
  bool notice_is_problem = false;
};

struct ScreenResult {
  int width = 0, height = 0;  // of the image's place in the window, px of the screen
  bool dragging = false;      // the image changes with the hand
  std::vector<Action> actions;
};

ScreenResult DrawScreen(Session& session, const ScreenState& state);

// Sizes and colours, and the letters of `scale`; before the first frame.
void SetUpStyle(float scale);

}  // namespace cosplat::viewer
