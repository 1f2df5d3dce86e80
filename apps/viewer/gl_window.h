// An OS window with an OpenGL 3.3 context and ImGui. One per process.
//
// ViewerWindow -> GlWindow; apart from ImageTexture the only code that calls GLFW and OpenGL.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/viewer/key_bindings.h"
#include "splat/base/image.h"

struct GLFWwindow;

namespace cosplat::viewer {

class GlWindow {
 public:
  // scale: 0: the screen's. width, height: of the window; 0: the usual. Throws Error if there is no
  // display or no OpenGL 3.3.
  GlWindow(const std::string& title, float scale, int width = 0, int height = 0);
  ~GlWindow();
  GlWindow(const GlWindow&) = delete;
  GlWindow& operator=(const GlWindow&) = delete;

  GLFWwindow* handle() const { return window_; }
  float scale() const { return scale_; }

  // Waits for an event, at most `seconds`; then begins ImGui's frame.
  void BeginFrame(double seconds);
  // What was pressed since the last call. ImGui's numbers for keys differ from version to version.
  std::vector<KeyPress> TakePressed() { return std::exchange(pressed_, {}); }
  // Draws the ImGui frame. Show presents it; Read may be called first.
  void EndFrame();
  void Show();
  Image8 Read() const;  // RGB, after EndFrame and before Show

  // Wakes BeginFrame; thread-safe.
  static void Wake();

 private:
  GLFWwindow* window_ = nullptr;
  float scale_ = 1;
  std::vector<KeyPress> pressed_;
};

}  // namespace cosplat::viewer
