// An OS window with OpenGL 3.3 and ImGui in it. One per process.
//
// ViewerWindow -> GlWindow; with ImageTexture the only code that calls GLFW and OpenGL.
#pragma once

#include <string>

#include "splat/base/image.h"

struct GLFWwindow;

namespace cosplat::viewer {

class GlWindow {
 public:
  // scale: 0: the screen's. Throws Error when there is no display, or none with OpenGL 3.3.
  GlWindow(const std::string& title, float scale);
  ~GlWindow();
  GlWindow(const GlWindow&) = delete;
  GlWindow& operator=(const GlWindow&) = delete;

  GLFWwindow* handle() const { return window_; }
  float scale() const { return scale_; }

  // Waits for an event, at most so long; then begins ImGui's frame.
  void BeginFrame(double seconds);
  // Draws it; shows it, or leaves it to be read.
  void EndFrame();
  void Show();
  Image8 Read() const;  // RGB, after EndFrame and before Show

  // Wakes BeginFrame; for any thread.
  static void Wake();

 private:
  GLFWwindow* window_ = nullptr;
  float scale_ = 1;
};

}  // namespace cosplat::viewer
