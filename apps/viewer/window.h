// The viewer's window: GLFW, Dear ImGui and an OpenGL 3.3 texture with the render thread's output.
//
// Session + Stage -> ViewerWindow -> Step, repeatedly. GLFW and ImGui have one state per process:
// one window at a time, on the main thread.
#pragma once

#include <memory>
#include <string>

#include "apps/viewer/session.h"
#include "splat/render/device_texture.h"

struct GLFWwindow;

namespace cosplat::viewer {

struct WindowSettings {
  float scale = 0;           // of text and panels; 0: the screen's
  std::string folder = ".";  // for screenshots and videos
  // Shows device images without a copy through host memory. If empty, or where sharing fails,
  // images are copied through host memory.
  DeviceTextureMaker make_device_texture{};
  std::string state_file{};  // of viewer_state.h; empty: nothing is kept
};

class ViewerWindow {
 public:
  // Keeps references. Throws Error if there is no display or no OpenGL 3.3.
  ViewerWindow(Session& session, Stage& stage, const WindowSettings& settings);
  ~ViewerWindow();

  // One turn: handles input, shows the latest image and draws the screen. Waits a while if nothing
  // happens. Returns false when the window is to close.
  bool Step();
  // Calls Step until the window closes.
  void Run();

  // For tests: GLFW's window, the notice line, whether the screen shows what the session asks for,
  // and the whole window as it would be shown now (RGB).
  GLFWwindow* handle() const;
  const std::string& notice() const;
  bool UpToDate() const;
  Image8 ReadPixels();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosplat::viewer
