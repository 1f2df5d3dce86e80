// The parts of DrawScreen (apps/viewer/screen.h), each in its own source file.
#pragma once

#include "apps/viewer/screen.h"

namespace cosplat::viewer {

// A rectangle of the window, in ImGui units.
struct Place {
  float x = 0, y = 0, width = 0, height = 0;
};

// The panels on the right.
void DrawPanels(Session& session, const ScreenState& state, Place place, ScreenResult& result);
// The timeline bar of a recorded sequence.
void DrawTimeline(Session& session, Place place);
// The image, its mouse controls and its overlays.
void DrawImage(Session& session, const ScreenState& state, Place place, ScreenResult& result);
void DrawHelp(bool& open, float scale);

}  // namespace cosplat::viewer
