// The viewer's window: GLFW, Dear ImGui and an OpenGL 3.3 texture of what the render thread drew.
//
// Session + Stage -> ViewerWindow -> Step, over and over. GLFW and ImGui have one state per
// process: one window at a time, on the main thread.
#pragma once

#include <memory>
#include <string>

#include "apps/viewer/session.h"
#include "splat/render/device_texture.h"

struct GLFWwindow;

namespace cosplat::viewer {

struct WindowSettings {
  float scale = 0;           // of letters and panels; 0: as the screen says
  std::string folder = ".";  // where screenshots and videos go
  // Shows what a device drew without the host's memory between; empty, or where it cannot: through
  // that memory.
  DeviceTextureMaker make_device_texture{};
};

class ViewerWindow {
 public:
  // Keeps references. Throws Error when there is no display, or none with OpenGL 3.3.
  ViewerWindow(Session& session, Stage& stage, const WindowSettings& settings);
  ~ViewerWindow();

  // One turn: what came in, what was drawn, the screen. Waits a while where nothing happens. False
  // once the window is to close.
  bool Step();
  // Steps until it is closed.
  void Run();

  // For tests: GLFW's window, the line of notice, whether what is on the screen is what the session
  // asks for, and the whole window as it would be shown now (RGB).
  GLFWwindow* handle() const;
  const std::string& notice() const;
  bool UpToDate() const;
  Image8 ReadPixels();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosplat::viewer
