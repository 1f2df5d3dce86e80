// The window's content, drawn with Dear ImGui: the image, the panels, the timeline, the help.
//
// ViewerWindow -> DrawScreen, once per turn, between ImGui's NewFrame and Render. Applies mouse,
// key and panel input to the session and returns the actions that the window must perform.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/viewer/key_bindings.h"
#include "apps/viewer/session.h"
#include "apps/viewer/time_history.h"

namespace cosplat::viewer {

// Provided by the window.
struct ScreenState {
  float scale = 1;               // of the whole user interface; 1 for 96 dots per inch
  intptr_t texture = 0;          // OpenGL texture name of the image; 0: none yet
  int width = 0, height = 0;     // image size, px
  int divisor = 1;               // the requested sides were divided by this
  TimeHistory drawing, latency;  // milliseconds per image
  double recorded_seconds = -1;  // length of the video being recorded; < 0: none
  std::string notice;            // one user-readable line; "": none
  bool notice_is_problem = false;
  std::vector<KeyPress> pressed;  // since the last turn
};

struct ScreenResult {
  int width = 0, height = 0;  // size of the image area in the window, px of the screen
  bool dragging = false;      // a drag is changing the image
  std::vector<Action> actions;
};

ScreenResult DrawScreen(Session& session, const ScreenState& state);

// Sets sizes, colours and the font for `scale`; call before the first frame.
void SetUpStyle(float scale);

// The parts of DrawScreen, each in its own source file.

// A rectangle of the window, in ImGui units.
struct ScreenRect {
  float x = 0, y = 0, width = 0, height = 0;
};

// The panels on the right.
void DrawPanels(Session& session, const ScreenState& state, ScreenRect place, ScreenResult& result);
// The timeline bar of a recorded sequence.
void DrawTimeline(Session& session, ScreenRect place);
// The image, its mouse controls and its overlays.
void DrawImage(Session& session, const ScreenState& state, ScreenRect place, ScreenResult& result);
void DrawHelp(bool& open, float scale);

}  // namespace cosplat::viewer
