// Images from the emulated device in the viewer's OpenGL texture (Mesa's, on a virtual display):
// what is in it, what is registered of it, and what happens where it cannot be shared.
#include <gtest/gtest.h>

#include "apps/viewer/gl_window.h"
#include "apps/viewer/image_texture.h"
#include "avatar/play/avatar_renderer.h"
#include "splat/media/image_io.h"
#include "tests/support/cuda_on_host/cuda_gl_interop.h"
#include "tests/support/expect_error.h"
#include "tests/viewer/window_fixture.h"

namespace cosplat::test {
namespace {

using cuda_on_host::CountsOfGl;
using cuda_on_host::GlKind;
using viewer::ImageTexture;
using viewer::Shot;
using viewer::Stage;

constexpr float kSmall = 0.3f;  // of the window: emulated kernels are slow

viewer::SplatRenderers OnDevice() {
  return {AvatarRendererOn(Device::kCuda), SceneRendererOn(Device::kCuda)};
}

Shot ShotOf(const viewer::Content& content, int width, int height, bool transparent) {
  Shot shot;
  shot.camera = viewer::OrbitCamera(content.start).At(width, height);
  shot.background = {0.9f, 0.3f, 0.1f};
  shot.transparent = transparent;
  return shot;
}

Image8 PixelsOf(unsigned texture) {
  int width = 0, height = 0;
  glBindTexture(GL_TEXTURE_2D, texture);
  glGetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_WIDTH, &width);
  glGetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_HEIGHT, &height);
  Image8 image(width, height, 4);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glGetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_UNSIGNED_BYTE, image.data.data());
  return image;
}

class GlTexture : public testing::Test {
 protected:
  void SetUp() override {
    if (!Display().there_is()) GTEST_SKIP() << "Xvfb is not installed";
    cuda_on_host::ResetGl();
    window = std::make_unique<viewer::GlWindow>("test", kSmall);
    texture = std::make_unique<ImageTexture>(DeviceTextureOn(Device::kCuda));
  }
  void TearDown() override {
    if (!texture) return;
    texture.reset();
    EXPECT_EQ(CountsOfGl().registered, 0);
    EXPECT_EQ(CountsOfGl().faults, 0);
    EXPECT_TRUE(cuda_on_host::HasFinished());
  }
  // What Show puts into the texture is the image that the stage draws for the host.
  void ExpectShown(Stage& stage, const Shot& shot) {
    ASSERT_TRUE(stage.DrawsOnDevice(shot));
    stage.DrawToStay(shot, stays);
    EXPECT_TRUE(cuda_on_host::HasFinished());  // before another thread gets it
    texture->Show(*stays);
    EXPECT_TRUE(cuda_on_host::HasFinished());  // before it is drawn over
    Image8 expected;
    stage.Draw(shot, expected);
    const Image8 shown = PixelsOf(texture->name());
    EXPECT_EQ(shown.width, shot.camera.width);
    EXPECT_EQ(shown.data, expected.data);
  }

  std::unique_ptr<viewer::GlWindow> window;
  std::unique_ptr<ImageTexture> texture;
  std::unique_ptr<DeviceImage> stays;
};

TEST_F(GlTexture, HasTheHostsImage) {
  for (const viewer::Content& content : {SmallScene(), PaintedHead()}) {
    Stage stage(viewer::Content(content), OnDevice());
    stays.reset();
    for (const bool transparent : {false, true})
      ExpectShown(stage, ShotOf(content, 61, 47, transparent));
  }
  EXPECT_EQ(CountsOfGl().registrations, 1);
  EXPECT_EQ(CountsOfGl().copies, 4);
}

TEST_F(GlTexture, IsRegisteredAnewWhereItsSizeChanges) {
  Stage stage(SmallScene(), OnDevice());
  for (const auto& [width, height] : {std::pair(40, 30), {80, 60}, {80, 60}, {30, 40}, {40, 30}})
    ExpectShown(stage, ShotOf(SmallScene(), width, height, false));
  EXPECT_EQ(CountsOfGl().registrations, 4);
  EXPECT_EQ(CountsOfGl().registered, 1);
}

// As where another view than the splats is shown in between.
TEST_F(GlTexture, TakesTurnsWithUploads) {
  Stage stage(SmallScene(), OnDevice());
  const Shot shot = ShotOf(SmallScene(), 40, 30, false);
  ExpectShown(stage, shot);
  for (const int width : {40, 22}) {
    Image8 image(width, 30, 4, uint8_t(width));
    image.at(width - 1, 0, 1) = 200;
    texture->Upload(image);
    EXPECT_EQ(PixelsOf(texture->name()).data, image.data);
    ExpectShown(stage, shot);
  }
  EXPECT_EQ(CountsOfGl().registrations, 2);
}

TEST_F(GlTexture, SaysWhyItCannotBeShared) {
  Stage stage(SmallScene(), OnDevice());
  const Shot shot = ShotOf(SmallScene(), 40, 30, false);
  stage.DrawToStay(shot, stays);
  const auto show = [&] { texture->Show(*stays); };
  cuda_on_host::SetGlKind(GlKind::kOfAnother);
  ExpectError(show, {"OpenGL", "runs on a different GPU", "invalid argument"});
  cuda_on_host::SetGlKind(GlKind::kNotShared);
  ExpectError(show, {"CUDA", "cudaGraphicsGLRegisterImage"});
  cuda_on_host::SetGlKind(GlKind::kBreaksOff);
  ExpectError(show, {"CUDA", "copying to the texture"});
  EXPECT_EQ(CountsOfGl().registered, 0);
  Image8 image;
  stays->Download(image);
  texture->Upload(image);
  EXPECT_EQ(PixelsOf(texture->name()).data, image.data);
  cuda_on_host::SetGlKind(GlKind::kOfDevice);
  ExpectShown(stage, shot);
}

TEST(DeviceTexture, IsOfDevicesAlone) { EXPECT_FALSE(DeviceTextureOn(Device::kCpu)); }

TEST(DeviceStage, DrawsSplatsAlone) {
  Stage device(SmallScene(), OnDevice()), cpu(SmallScene());
  Shot shot = ShotOf(SmallScene(), 40, 30, false);
  EXPECT_FALSE(cpu.DrawsOnDevice(shot));
  EXPECT_TRUE(device.DrawsOnDevice(shot));
  shot.view = viewer::View::kEllipsoids;
  EXPECT_FALSE(device.DrawsOnDevice(shot));
  std::unique_ptr<DeviceImage> stays;
  shot = ShotOf(SmallScene(), 0, 30, false);
  ExpectError([&] { device.DrawToStay(shot, stays); }, {"no pixels"});
}

// The whole window, whose images are drawn in another thread.
class DeviceWindow : public Window {
 protected:
  DeviceWindow() : Window(OnDevice(), {kSmall, "", DeviceTextureOn(Device::kCuda)}) {
    cuda_on_host::ResetGl();
    session.panels_open = false;
  }
  void Close() {
    window.reset();
    EXPECT_EQ(CountsOfGl().registered, 0);
    EXPECT_EQ(CountsOfGl().faults, 0);
  }
  // Within what the CPU's stage may round otherwise, below the line of notice.
  void ExpectShown() {
    Settle();
    EXPECT_LE(DifferenceFromStage(40), 2);
  }
};

TEST_F(DeviceWindow, ShowsWhatStayedOnTheDevice) {
  Open(kSmall);
  ExpectShown();
  EXPECT_EQ(window->notice(), "");
  EXPECT_GT(CountsOfGl().copies, 0);
  Press(GLFW_KEY_4);
  ExpectShown();
  const int copies = CountsOfGl().copies;
  Press(GLFW_KEY_1);
  Press(GLFW_KEY_T);
  Settle();
  EXPECT_GT(CountsOfGl().copies, copies);
  EXPECT_EQ(CountsOfGl().registrations, 1);
  EXPECT_EQ(window->notice(), "");
  Close();
}

TEST_F(DeviceWindow, CapturesWhatStayedOnTheDevice) {
  session.SetSequence(OpeningMouth(3), 25);
  session.timeline.Pause();
  Open(kSmall);
  Press(GLFW_KEY_S);
  Settle();
  ASSERT_EQ(Captures().size(), 1u);
  const Image8 screenshot = ReadImage(Captures()[0]);
  Stage own{viewer::Content(PaintedHead()), OnDevice()};
  Image8 picture;
  own.Draw(session.ShotFor(screenshot.width, screenshot.height), picture);
  EXPECT_EQ(screenshot.data, picture.data);
  std::filesystem::remove(Captures()[0]);
  Press(GLFW_KEY_V);
  Press(GLFW_KEY_RIGHT);  // what is recorded is drawn for the host
  Settle();
  Press(GLFW_KEY_V);
  for (int i = 0; i < 500 && Captures().empty(); ++i) window->Step();
  ASSERT_EQ(Captures().size(), 1u);
  EXPECT_GE(VideoReader(Captures()[0]).frame_count(), 1);
  Close();
}

TEST_F(DeviceWindow, GoesThroughTheHostWhereItMust) {
  for (const GlKind kind : {GlKind::kOfAnother, GlKind::kNotShared, GlKind::kBreaksOff}) {
    cuda_on_host::ResetGl();
    cuda_on_host::SetGlKind(kind);
    Open(kSmall);
    EXPECT_EQ(window->notice().find("Images pass through the host's memory: "), 0u)
        << window->notice();
    ExpectShown();
    Press(GLFW_KEY_N);
    const int registrations = CountsOfGl().registrations;
    Press(GLFW_KEY_F);
    ExpectShown();
    EXPECT_EQ(CountsOfGl().registrations, registrations);  // it is not tried again
    EXPECT_EQ(CountsOfGl().copies, 0);
    Close();
  }
}

// In the middle of drawing.
TEST_F(DeviceWindow, ClosesAtOnce) {
  Open(kSmall);
  Press(GLFW_KEY_F);
  Close();
}

}  // namespace
}  // namespace cosplat::test
