// The parts of DrawScreen (apps/viewer/screen.h), each in a source file.
#pragma once

#include "apps/viewer/screen.h"

namespace cosplat::viewer {

// Of the window; units of ImGui.
struct Place {
  float x = 0, y = 0, width = 0, height = 0;
};

// The panels on the right.
void DrawPanels(Session& session, const ScreenState& state, Place place, ScreenResult& result);
// The bar of a recorded sequence.
void DrawTimeline(Session& session, Place place);
// The image under the mouse, with what stands over it.
void DrawImage(Session& session, const ScreenState& state, Place place, ScreenResult& result);
void DrawHelp(bool& open, float scale);

}  // namespace cosplat::viewer
