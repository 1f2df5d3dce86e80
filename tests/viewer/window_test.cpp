// apps/viewer/window.h on a virtual display: what is on the screen after keys, mouse and time.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fstream>

#include "splat/base/error.h"
#include "splat/media/image_io.h"
#include "tests/support/expect_error.h"
#include "tests/viewer/window_fixture.h"

namespace cosplat::test {
namespace {

using viewer::Content;
using viewer::Driver;
using viewer::Stage;
using viewer::View;
using viewer::ViewerWindow;

TEST_F(Window, ShowsWhatTheStageDraws) {
  Open();
  EXPECT_LE(DifferenceFromStage(), 1);
  Press(GLFW_KEY_4);
  Settle();
  EXPECT_EQ(session.view(), View::kWire);
  EXPECT_LE(DifferenceFromStage(), 1);
  Press(GLFW_KEY_TAB);  // without the panels the image has the whole window
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
  session.SetSequence(OpeningMouth(100), 25);
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
  Image8 image;
  own.Draw(session.ShotFor(screenshot.width, screenshot.height), image);
  EXPECT_EQ(screenshot.data, image.data);
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
  window = std::make_unique<ViewerWindow>(session, stage, settings);
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

TEST_F(Window, TheDriveInThePanelStartsAndStops) {
  FlameParams rest;
  rest.expression.assign(size_t(PaintedHead().avatar->flame.expression_count), 0);
  session.open_drive = [&](viewer::Session& opened, const std::string& drive) {
    if (drive != "udp://:0") throw Error(drive, "cannot be had");
    opened.SetLive(std::make_unique<viewer::LiveFace>(
        OpenLiveSource(drive), rest, std::optional<TrainedRange>()));
  };
  session.drive = "vts://192.168.";
  Open();
  Press(GLFW_KEY_D);
  EXPECT_EQ(window->notice(), "vts://192.168.: cannot be had");
  EXPECT_EQ(session.live(), nullptr);
  session.drive = "udp://:0";
  Press(GLFW_KEY_D);
  ASSERT_NE(session.live(), nullptr);
  EXPECT_EQ(session.driver, Driver::kLive);
  Press(GLFW_KEY_D);
  EXPECT_EQ(session.live(), nullptr);
  EXPECT_EQ(session.driver, Driver::kSliders);
}

TEST_F(Window, KeepsItsSizeAndDriveForTheNextRun) {
  settings.state_file = folder / "state/cosplat/viewer.json";
  session.drive = "vmc://0.0.0.0:39539";
  Open();
  glfwSetWindowSize(window->handle(), 700, 500);
  Settle();
  session.panels_open = false;
  glfwSetWindowShouldClose(window->handle(), 1);
  window->Run();
  window.reset();
  session.drive.clear();
  Open();
  int width = 0, height = 0;
  glfwGetWindowSize(window->handle(), &width, &height);
  EXPECT_EQ(width, 700);
  EXPECT_EQ(height, 500);
  EXPECT_FALSE(session.panels_open);
  EXPECT_EQ(session.drive, "vmc://0.0.0.0:39539");
  EXPECT_EQ(window->notice(), "");
  window.reset();
  // A folder that nobody can write is not worth an error at the end.
  settings.state_file = "/proc/cosplat/viewer.json";
  Open();
  glfwSetWindowShouldClose(window->handle(), 1);
  window->Run();
  window.reset();
  settings.state_file = folder / "state/cosplat/viewer.json";
  std::ofstream(settings.state_file) << R"({"width": -3})";
  Open();
  EXPECT_NE(window->notice().find("viewer.json: width"), std::string::npos) << window->notice();
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
