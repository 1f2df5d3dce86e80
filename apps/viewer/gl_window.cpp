#include "apps/viewer/gl_window.h"

// ImGui's backends can be included in any order; GLFW includes OpenGL's own header.
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>

#include "apps/viewer/screen.h"
#include "splat/base/error.h"

namespace cosplat::viewer {
namespace {

constexpr int kWidth = 1280, kHeight = 800;  // at scale 1
constexpr float kMaxOfScreen = 0.92f;

[[noreturn]] void ThrowNoWindow(const char* what) {
  const char* reason = nullptr;
  glfwGetError(&reason);
  throw Error(what,
              std::string(reason ? reason : "cannot be had") +
                  "; --headless -o OUT draws to files without a window");
}

GLFWwindow* Open(const std::string& title, float& scale, int wanted_width, int wanted_height) {
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  int width = kWidth, height = kHeight;
  if (GLFWmonitor* monitor = glfwGetPrimaryMonitor()) {
    float across = 1, down = 1;
    glfwGetMonitorContentScale(monitor, &across, &down);
    if (scale <= 0) scale = across;
    int x = 0, y = 0, max_width = 0, max_height = 0;
    glfwGetMonitorWorkarea(monitor, &x, &y, &max_width, &max_height);
    width = std::min(wanted_width > 0 ? wanted_width : int(kWidth * scale),
                     int(kMaxOfScreen * float(max_width)));
    height = std::min(wanted_height > 0 ? wanted_height : int(kHeight * scale),
                      int(kMaxOfScreen * float(max_height)));
  }
  if (scale <= 0) scale = 1;
  return glfwCreateWindow(
      std::max(width, 320), std::max(height, 240), title.c_str(), nullptr, nullptr);
}

// Below 1 if the system already enlarges windows (Wayland), so that text is not scaled twice.
float UnitsPerPixel(GLFWwindow* window) {
  int units = 0, pixels = 0, unused = 0;
  glfwGetWindowSize(window, &units, &unused);
  glfwGetFramebufferSize(window, &pixels, &unused);
  return units > 0 && pixels > 0 ? float(units) / float(pixels) : 1;
}

}  // namespace

GlWindow::GlWindow(const std::string& title, float scale, int width, int height) : scale_(scale) {
  if (!glfwInit()) ThrowNoWindow("display");
  window_ = Open(title, scale_, width, height);
  if (!window_) {
    try {
      ThrowNoWindow("OpenGL 3.3 window");
    } catch (...) {
      glfwTerminate();
      throw;
    }
  }
  if (scale <= 0) scale_ *= UnitsPerPixel(window_);
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // do not write a settings file
  SetUpStyle(scale_);
  glfwSetWindowUserPointer(window_, this);
  glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int) {
    if (action == GLFW_RELEASE) return;
    static_cast<GlWindow*>(glfwGetWindowUserPointer(window))
        ->pressed_.push_back({key, action == GLFW_REPEAT});
  });
  ImGui_ImplGlfw_InitForOpenGL(window_, true);  // calls the callback before its own
  ImGui_ImplOpenGL3_Init("#version 330 core");
}

GlWindow::~GlWindow() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

void GlWindow::BeginFrame(double seconds) {
  glfwWaitEventsTimeout(seconds);
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
}

void GlWindow::EndFrame() {
  ImGui::Render();
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  glViewport(0, 0, width, height);
  glClearColor(0, 0, 0, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void GlWindow::Show() { glfwSwapBuffers(window_); }

Image8 GlWindow::Read() const {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  Image8 bottom_up(width, height, 3), image(width, height, 3);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, bottom_up.data.data());
  const auto row = std::ptrdiff_t(3) * width;
  for (int y = 0; y < height; ++y)
    std::copy_n(bottom_up.data.begin() + row * (height - 1 - y), row, image.data.begin() + row * y);
  return image;
}

void GlWindow::Wake() { glfwPostEmptyEvent(); }

}  // namespace cosplat::viewer
