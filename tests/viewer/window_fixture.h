// The viewer's window on a virtual display, with hands on its keys and its mouse.
#pragma once

#include <GLFW/glfw3.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "apps/viewer/window.h"
#include "tests/support/temporary_folder.h"
#include "tests/viewer/viewer_fixture.h"
#include "tests/viewer/virtual_display.h"

namespace cosplat::test {

constexpr int kPanelWidth = 330;  // at scale 1; kPanelWidth in apps/viewer/screen.cpp

// Of the process.
inline const VirtualDisplay& Display() {
  static const VirtualDisplay display;
  return display;
}

class Window : public testing::Test {
 protected:
  explicit Window(const viewer::SplatRenderers& renderers = {},
                  viewer::WindowSettings window_settings = {})
      : stage(viewer::Content(PaintedHead()), renderers), settings(std::move(window_settings)) {
    settings.folder = folder / "captures";
  }
  void SetUp() override {
    if (!Display().there_is()) GTEST_SKIP() << "Xvfb is not installed";
  }
  void Open(float scale = 1) {
    settings.scale = scale;
    window = std::make_unique<viewer::ViewerWindow>(session, stage, settings);
    glfwFocusWindow(window->handle());
    Settle();
  }
  // Until what is asked for is on the screen, and some more for what follows from it.
  void Settle() {
    int turns = 0;
    for (int rest = 2; rest > 0; ++turns) {
      ASSERT_TRUE(window->Step());
      ASSERT_LT(turns, 1000);
      rest = window->UpToDate() ? rest - 1 : 2;
    }
  }
  void Press(int key) {
    GLFWwindow* handle = window->handle();
    const GLFWkeyfun on_key = glfwSetKeyCallback(handle, nullptr);
    glfwSetKeyCallback(handle, on_key);
    on_key(handle, key, 0, GLFW_PRESS, 0);
    window->Step();
    on_key(handle, key, 0, GLFW_RELEASE, 0);
    window->Step();
  }
  void Drag(int button, double dx, double dy) {
    GLFWwindow* handle = window->handle();
    const GLFWmousebuttonfun on_button = glfwSetMouseButtonCallback(handle, nullptr);
    glfwSetMouseButtonCallback(handle, on_button);
    // ImGui asks for the place before 1.87, and is told since.
    const GLFWcursorposfun on_move = glfwSetCursorPosCallback(handle, nullptr);
    glfwSetCursorPosCallback(handle, on_move);
    for (int i = 0; i <= 5; ++i) {
      const double x = 300 + i * dx / 5, y = 300 + i * dy / 5;
      glfwSetCursorPos(handle, x, y);
      if (on_move) on_move(handle, x, y);
      // GLFW's own state is not pressed, so that ImGui has to be told in every turn.
      if (i > 0) on_button(handle, button, GLFW_PRESS, 0);
      window->Step();
    }
    on_button(handle, button, GLFW_RELEASE, 0);
    window->Step();
  }
  void Scroll(double steps) {
    GLFWwindow* handle = window->handle();
    const GLFWscrollfun on_scroll = glfwSetScrollCallback(handle, nullptr);
    glfwSetScrollCallback(handle, on_scroll);
    on_scroll(handle, 0, steps);
    window->Step();
  }
  // How far the window's left part is from what the stage draws of the session, in grey levels,
  // from a row on.
  int DifferenceFromStage(int first_row = 0) {
    const Image8 pixels = window->ReadPixels();
    const int width = pixels.width - (session.panels_open ? kPanelWidth : 0);
    viewer::Stage own{viewer::Content(PaintedHead())};
    Image8 image;
    own.Draw(session.ShotFor(width, pixels.height), image);
    int max = 0;
    for (int y = first_row; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        for (int c = 0; c < 3; ++c)
          max = std::max(max, std::abs(pixels.at(x, y, c) - image.at(x, y, c)));
    return max;
  }
  std::vector<std::string> Captures() const {
    std::vector<std::string> paths;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "captures"))
      if (entry.path().string().find("tmp.") == std::string::npos)  // not while it is written
        paths.push_back(entry.path().string());
    return paths;
  }

  TemporaryFolder folder;
  viewer::Session session{PaintedHead()};
  viewer::Stage stage;
  viewer::WindowSettings settings;
  std::unique_ptr<viewer::ViewerWindow> window;
};

}  // namespace cosplat::test
