// What the viewer keeps from one run to the next: the window's size, and what drove last.
#pragma once

#include <string>

namespace cosplat::viewer {

struct ViewerState {
  int width = 0, height = 0;  // of the window, in the screen's units; 0: the usual
  bool panels_open = true;
  std::string drive;  // as it stands in the panel; it is not opened by itself
};

// $XDG_STATE_HOME/cosplat/viewer.json, or in ~/.local/state; "" where there is neither.
std::string ViewerStatePath();
// The usual state where there is no file. Throws Error naming file and field if it is damaged.
ViewerState ReadViewerState(const std::string& path);
void WriteViewerState(const ViewerState& state, const std::string& path);

}  // namespace cosplat::viewer
