// apps/viewer/window.h on a virtual display: what is on the screen after keys, mouse and time.
#include "apps/viewer/window.h"

#include <GLFW/glfw3.h>
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "splat/base/image_io.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"
#include "tests/viewer/viewer_fixture.h"
#include "tests/viewer/virtual_display.h"

namespace cosplat::test {
namespace {

using viewer::Content;
using viewer::Driver;
using viewer::Session;
using viewer::Stage;
using viewer::View;
using viewer::ViewerWindow;

constexpr int kPanelWidth = 330;  // at scale 1; kPanelWidth in apps/viewer/screen.cpp

class Window : public testing::Test {
 protected:
  static const VirtualDisplay& Display() {
    static const VirtualDisplay display;
    return display;
  }
  void SetUp() override {
    if (!Display().there_is()) GTEST_SKIP() << "Xvfb is not installed";
  }
  void Open(float scale = 1) {
    window = std::make_unique<ViewerWindow>(
        session, stage, viewer::WindowSettings{scale, folder / "captures"});
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
    for (int i = 0; i <= 5; ++i) {
      glfwSetCursorPos(handle, 300 + i * dx / 5, 300 + i * dy / 5);
      // GLFW's own state is not pressed, so that ImGui has to be told in every turn.
      if (i > 0) on_button(handle, button, GLFW_PRESS, 0);
      window->Step();
    }
    window->Step();
  }
  void Scroll(double steps) {
    GLFWwindow* handle = window->handle();
    const GLFWscrollfun on_scroll = glfwSetScrollCallback(handle, nullptr);
    glfwSetScrollCallback(handle, on_scroll);
    on_scroll(handle, 0, steps);
    window->Step();
  }
  // How far the window's left part is from what the stage draws of the session, in grey levels.
  int DifferenceFromStage() {
    const Image8 pixels = window->ReadPixels();
    const int width = pixels.width - (session.panels_open ? kPanelWidth : 0);
    Stage own{Content(PaintedHead())};
    Image8 picture;
    own.Draw(session.ShotFor(width, pixels.height), picture);
    int most = 0;
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x)
        for (int c = 0; c < 3; ++c)
          most = std::max(most, std::abs(pixels.at(x, y, c) - picture.at(x, y, c)));
    return most;
  }
  std::vector<std::string> Captures() const {
    std::vector<std::string> paths;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "captures"))
      if (entry.path().string().find("tmp.") == std::string::npos)  // not while it is written
        paths.push_back(entry.path().string());
    return paths;
  }

  TemporaryFolder folder;
  Session session{PaintedHead()};
  Stage stage{Content(PaintedHead())};
  std::unique_ptr<ViewerWindow> window;
};

TEST_F(Window, ShowsWhatTheStageDraws) {
  Open();
  EXPECT_LE(DifferenceFromStage(), 1);
  Press(GLFW_KEY_4);
  Settle();
  EXPECT_EQ(session.view(), View::kWire);
  EXPECT_LE(DifferenceFromStage(), 1);
  Press(GLFW_KEY_TAB);  // without the panels the picture has the whole window
  Settle();
  EXPECT_LE(DifferenceFromStage(), 1);
}

TEST_F(Window, TheMouseMovesTheCamera) {
  Open();
  const Camera home = session.ShotFor(64, 64).camera;
  Drag(GLFW_MOUSE_BUTTON_LEFT, 100, 0);
  const Camera circled = session.ShotFor(64, 64).camera;
  EXPECT_NE(circled.rotation, home.rotation);
  // The hand takes what it shows along: the camera goes to its left.
  EXPECT_LT(home.rotation[0] * (circled.Center()[0] - home.Center()[0]), 0);
  Drag(GLFW_MOUSE_BUTTON_RIGHT, 0, 60);
  const Camera shifted = session.ShotFor(64, 64).camera;
  EXPECT_EQ(shifted.rotation, circled.rotation);
  EXPECT_NE(shifted.translation, circled.translation);
  Scroll(2);
  EXPECT_LT(session.ShotFor(64, 64).camera.translation[2], shifted.translation[2]);
  Settle();
  EXPECT_LE(DifferenceFromStage(), 1);  // at rest, in full size again
  Press(GLFW_KEY_R);
  EXPECT_EQ(session.ShotFor(64, 64).camera.rotation, home.rotation);
}

TEST_F(Window, PlaysStepsAndCaptures) {
  session.SetSequence("talk", OpeningMouth(100), 25);
  session.timeline.Pause();
  Open();
  Press(GLFW_KEY_SPACE);
  for (int i = 0; i < 200 && session.timeline.frame() < 2; ++i) window->Step();
  EXPECT_GE(session.timeline.frame(), 2);
  Press(GLFW_KEY_V);
  for (int i = 0; i < 10; ++i) window->Step();
  Press(GLFW_KEY_V);
  for (int i = 0; i < 500 && Captures().empty(); ++i) window->Step();
  ASSERT_EQ(Captures().size(), 1u);
  EXPECT_GE(VideoReader(Captures()[0]).frame_count(), 1);
  std::filesystem::remove(Captures()[0]);
  Press(GLFW_KEY_SPACE);
  const int frame = session.timeline.frame();
  Press(GLFW_KEY_RIGHT);
  EXPECT_EQ(session.timeline.frame(), frame + 1);
  Settle();
  Press(GLFW_KEY_S);
  Settle();
  ASSERT_EQ(Captures().size(), 1u);
  const Image8 screenshot = ReadImage(Captures()[0]);
  Stage own{Content(PaintedHead())};
  Image8 picture;
  own.Draw(session.ShotFor(screenshot.width, screenshot.height), picture);
  EXPECT_EQ(screenshot.data, picture.data);
}

// A datagram to the port that a source's description ends with.
void SendTo(const std::string& description, const std::string& text) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(uint16_t(std::stoi(description.substr(description.rfind(':') + 1))));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  const auto* address = reinterpret_cast<const sockaddr*>(&to);
  EXPECT_EQ(sendto(socket, text.data(), text.size(), 0, address, sizeof to), ssize_t(text.size()));
  close(socket);
}

TEST_F(Window, ShowsALiveFace) {
  FlameParams rest;
  rest.expression.assign(size_t(PaintedHead().avatar->flame.expression_count), 0);
  session.SetLive(std::make_unique<viewer::LiveFace>(
      OpenLiveSource("udp://:0"), rest, std::optional<TrainedRange>()));
  const viewer::LiveFace& live = *session.live();
  window = std::make_unique<ViewerWindow>(
      session, stage, viewer::WindowSettings{1, folder / "captures"});
  SendTo(live.Description(), R"({"seq": 1, "jaw": [0.3, 0, 0]})");
  SendTo(live.Description(), "not a frame");
  for (int i = 0; i < 500 && live.Counts().malformed == 0; ++i) window->Step();
  EXPECT_EQ(live.guard().counts().accepted, 1u);
  EXPECT_EQ(live.Counts().malformed, 1u);
  Press(GLFW_KEY_N);  // the sliders take over
  EXPECT_EQ(session.driver, Driver::kSliders);
  Settle();
  EXPECT_LE(DifferenceFromStage(), 1);
}

TEST_F(Window, LettersAndPanelsScale) {
  session.background = {1, 0, 0};
  Open(2);
  const Image8 pixels = window->ReadPixels();
  const int edge = pixels.width - 2 * kPanelWidth;
  EXPECT_GT(pixels.at(edge - 3, 5, 0), 250);
  EXPECT_LT(pixels.at(edge + 3, 5, 0), 60);
}

TEST_F(Window, QuitsByKey) {
  Open();
  Press(GLFW_KEY_H);
  EXPECT_TRUE(session.help_open);
  Press(GLFW_KEY_Q);
  EXPECT_FALSE(window->Step());
}

TEST_F(Window, WithoutADisplayPointsToHeadless) {
  const std::string display = std::getenv("DISPLAY");
  unsetenv("DISPLAY");
  ExpectError([&] { Open(); }, {"display", "--headless"});
  setenv("DISPLAY", display.c_str(), 1);
}

}  // namespace
}  // namespace cosplat::test
