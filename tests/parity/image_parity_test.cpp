// Scenes that a device keeps, and images that stay there.
#include <gtest/gtest.h>

#include <limits>

#include "splat/render/device.h"
#include "tests/parity/compare.h"
#include "tests/parity/device_fixture.h"
#include "tests/parity/image_bytes.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

class ImageParity : public test::DeviceTest {
 protected:
  test::ParityCase picture = test::RandomCase("kept", 200, 45, 38, Basis::kDcsh, 2);
};

std::unique_ptr<SceneRenderer> KeptScene(const Gaussians& scene) {
  return SceneRendererOn(Device::kCuda)(scene);
}

RenderedImage OnCpu(const test::ParityCase& c) {
  const auto cpu = MakeCpuRasterizer();
  const auto tape = cpu->MakeTape();
  RenderedImage image;
  cpu->Forward(ViewOf(c), c.gaussians.basis, c.camera, c.settings, image, *tape);
  return image;
}

TEST_F(ImageParity, AKeptSceneIsDrawnAsTheCpuDrawsIt) {
  const auto renderer = KeptScene(picture.gaussians);
  for (const int width : {45, 20, 45}) {
    picture.camera.width = width;
    const RenderedImage expected = OnCpu(picture);
    RenderedImage image;
    renderer->Draw(picture.camera, picture.settings, image);
    EXPECT_EQ(image.width, width);
    test::ExpectSameImage(expected.color, image.color, {}, "colour");
    test::ExpectSameImage(expected.transmittance, image.transmittance, {}, "transmittance");
  }
  EXPECT_GT(renderer->times.seconds[size_t(Phase::kBlend)], 0);
}

TEST_F(ImageParity, EverySceneCanBeKept) {
  Gaussians none = picture.gaussians;
  none.Resize(0);
  RenderedImage image;
  KeptScene(none)->Draw(picture.camera, {{0.5f, 0, 0}, 0}, image);
  EXPECT_EQ(image.color[0], 0.5f);
  EXPECT_EQ(image.transmittance[0], 1);
  const auto renderer = KeptScene(picture.gaussians);
  picture.camera.width = 0;
  test::ExpectError([&] { renderer->Draw(picture.camera, {}, image); }, {"camera"});
}

TEST_F(ImageParity, ImagesThatStayHaveTheHostsBytes) {
  const auto renderer = KeptScene(picture.gaussians);
  RenderedImage image;
  std::unique_ptr<DeviceImage> stays;
  picture.settings.background = {0.2f, 1.5f, -1};  // clamped
  renderer->Draw(picture.camera, picture.settings, image);
  renderer->DrawToStay(picture.camera, picture.settings, AlphaMode::kOpaque, stays);
  test::ExpectBytesOf<AlphaMode::kOpaque>(image, *stays);
  picture.settings.background = {0, 0, 0};
  picture.camera.width = 31;
  renderer->Draw(picture.camera, picture.settings, image);
  renderer->DrawToStay(picture.camera, picture.settings, AlphaMode::kStraight, stays);
  test::ExpectBytesOf<AlphaMode::kStraight>(image, *stays);
  renderer->DrawToStay(picture.camera, picture.settings, AlphaMode::kPremultiplied, stays);
  test::ExpectBytesOf<AlphaMode::kPremultiplied>(image, *stays);
}

// One by one: what is clamped, what is not a number, and what is not seen at all.
TEST(PixelBytes, AreRoundedAndClamped) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(math::ToByte(nan), 0);
  EXPECT_EQ(math::ToByte(-1), 0);
  EXPECT_EQ(math::ToByte(0.5f), 128);
  EXPECT_EQ(math::ToByte(std::numeric_limits<float>::infinity()), 255);
  EXPECT_EQ(math::ColorByte<AlphaMode::kStraight>(0.25f, 0.5f), 128);
  EXPECT_EQ(math::ColorByte<AlphaMode::kStraight>(0.25f, 0), 0);
  EXPECT_EQ(math::ColorByte<AlphaMode::kPremultiplied>(0.6f, 0.5f), 128);
  EXPECT_EQ(math::ColorByte<AlphaMode::kPremultiplied>(nan, 0.5f), 0);
  EXPECT_EQ(math::ColorByte<AlphaMode::kOpaque>(0.5f, 0), 128);
}

}  // namespace
}  // namespace cosplat
