// cosplat_render: the player's own pixels, in every layout a host may ask for; depth.
#include <algorithm>
#include <cmath>
#include <functional>

#include "avatar/play/player.h"
#include "splat/basis_constants.h"
#include "splat/media/image_io.h"
#include "tests/plugin/plugin_fixture.h"
#include "tests/support/restless_params.h"

namespace cosplat::test {
namespace {

constexpr uint32_t kWidth = 61, kHeight = 47;
constexpr std::array<float, 3> kBackground{0.1f, 0.5f, 0.9f};

const FlameModel& Flame() { return PluginFiles::Get().flame; }

// An avatar in some pose before some camera, and a player of the same.
class PluginRender : public testing::Test {
 protected:
  PluginRender()
      : player_(PluginFiles::Get().avatar, Flame()), params_(RestlessParams(Flame(), 2)) {
    const cosplat_parameters set = ParametersOf(params_);
    EXPECT_EQ(cosplat_set_parameters(avatar_, &set), COSPLAT_OK);
    camera_ = CameraOf(SetOrbit(avatar_, kWidth, kHeight, 0.5f, 0.2f));
  }

  // Bytes, row after row from the top.
  std::vector<uint8_t> Render(uint32_t alpha, uint32_t format = COSPLAT_FORMAT_RGBA8) {
    std::vector<uint8_t> bytes;
    cosplat_picture picture = PictureInto(bytes, kWidth, kHeight);
    picture.alpha = alpha;
    picture.format = format;
    std::copy(kBackground.begin(), kBackground.end(), picture.background);
    EXPECT_EQ(cosplat_render(avatar_, &picture), COSPLAT_OK) << cosplat_last_error(avatar_);
    return bytes;
  }

  OpenAvatar avatar_;
  Player player_;
  FlameParams params_;
  Camera camera_;
};

TEST_F(PluginRender, StraightAlphaIsThePlayersOwn) {
  const Image8 expected = player_.Render(params_, camera_);
  EXPECT_EQ(Render(COSPLAT_ALPHA_STRAIGHT), expected.data);
  EXPECT_GT(std::count(expected.data.begin(), expected.data.end(), 0), 100);  // sees past the head
  EXPECT_GT(*std::max_element(expected.data.begin(), expected.data.end()), 200);
}

TEST_F(PluginRender, OpaqueIsThePlayersPictureOverTheBackground) {
  RenderedImage image;
  player_.RenderOver(params_, camera_, kBackground, image);
  const Image8 expected = ToBytes(image.ToImage());
  const std::vector<uint8_t> bytes = Render(COSPLAT_ALPHA_OPAQUE);
  for (size_t p = 0; p < expected.pixels(); ++p) {
    for (size_t c = 0; c < 3; ++c) ASSERT_EQ(bytes[4 * p + c], expected.data[3 * p + c]) << p;
    ASSERT_EQ(bytes[4 * p + 3], 255);
  }
}

TEST_F(PluginRender, PremultipliedIsStraightTimesAlpha) {
  const std::vector<uint8_t> straight = Render(COSPLAT_ALPHA_STRAIGHT);
  const std::vector<uint8_t> bytes = Render(COSPLAT_ALPHA_PREMULTIPLIED);
  int partly = 0;
  for (size_t p = 0; p < bytes.size(); p += 4) {
    const float alpha = float(straight[p + 3]) / 255;
    partly += alpha > 0 && alpha < 0.9f;
    ASSERT_EQ(bytes[p + 3], straight[p + 3]);
    for (size_t c = 0; c < 3; ++c) {
      ASSERT_LE(bytes[p + c], bytes[p + 3]);
      // Straight bytes are rounded once (half), times alpha that is (half of 255ths), once more.
      ASSERT_NEAR(float(bytes[p + c]), float(straight[p + c]) * alpha, 1.5f);
    }
  }
  EXPECT_GT(partly, 50);
}

TEST_F(PluginRender, BgraHasRedAndBlueExchanged) {
  for (const uint32_t alpha :
       {COSPLAT_ALPHA_STRAIGHT, COSPLAT_ALPHA_PREMULTIPLIED, COSPLAT_ALPHA_OPAQUE}) {
    std::vector<uint8_t> bytes = Render(alpha, COSPLAT_FORMAT_BGRA8);
    for (size_t p = 0; p < bytes.size(); p += 4) std::swap(bytes[p], bytes[p + 2]);
    EXPECT_EQ(bytes, Render(alpha)) << alpha;
  }
}

TEST_F(PluginRender, RowsMayBeApartAndBottomUp) {
  const std::vector<uint8_t> expected = Render(COSPLAT_ALPHA_STRAIGHT);
  constexpr size_t kRow = 4 * kWidth, kApart = kRow + 13;
  std::vector<uint8_t> bytes(kApart * kHeight + 1, 0xcd);
  for (const bool bottom_up : {false, true}) {
    std::fill(bytes.begin(), bytes.end(), uint8_t(0xcd));
    cosplat_picture picture = Zeroed<cosplat_picture>();
    picture.width = kWidth;
    picture.height = kHeight;
    picture.stride = bottom_up ? -int64_t(kApart) : int64_t(kApart);
    uint8_t* first = bytes.data() + 1;  // of any alignment
    picture.pixels = bottom_up ? first + (kHeight - 1) * kApart : first;
    ASSERT_EQ(cosplat_render(avatar_, &picture), COSPLAT_OK);
    EXPECT_EQ(bytes[0], 0xcd);
    for (size_t y = 0; y < kHeight; ++y) {
      const uint8_t* row = first + (bottom_up ? kHeight - 1 - y : y) * kApart;
      ASSERT_TRUE(std::equal(row, row + kRow, &expected[y * kRow])) << y;
      for (size_t x = kRow; x < kApart; ++x) ASSERT_EQ(row[x], 0xcd) << "between the rows";
    }
  }
}

TEST_F(PluginRender, WithoutACameraIsTheOrbitsFirst) {
  const OpenAvatar fresh;
  std::vector<uint8_t> bytes, expected;
  cosplat_picture picture = PictureInto(bytes, 48, 64);
  ASSERT_EQ(cosplat_render(fresh, &picture), COSPLAT_OK);
  SetOrbit(fresh, 48, 64, 0);
  picture = PictureInto(expected, 48, 64);
  ASSERT_EQ(cosplat_render(fresh, &picture), COSPLAT_OK);
  EXPECT_EQ(bytes, expected);
  EXPECT_GT(bytes[4 * (32 * 48 + 24) + 3], 200);  // the head is in the middle
  EXPECT_EQ(bytes[3], 0);                         // and not in the corner
}

TEST_F(PluginRender, WhatIsRefusedWritesNothing) {
  std::vector<uint8_t> bytes;
  std::vector<float> depth(kWidth * kHeight + 1, -1.0f);
  const auto refused = [&](const std::function<void(cosplat_picture&)>& spoil) {
    cosplat_picture picture = PictureInto(bytes, kWidth, kHeight);
    picture.depth = depth.data();
    spoil(picture);
    EXPECT_EQ(cosplat_render(avatar_, &picture), COSPLAT_ERROR_ARGUMENT);
    EXPECT_EQ(std::count(bytes.begin(), bytes.end(), 0), ptrdiff_t(bytes.size()));
    EXPECT_EQ(std::count(depth.begin(), depth.end(), -1.0f), ptrdiff_t(depth.size()));
  };
  for (const uint32_t side : {0u, kWidth - 1, 100000u, ~0u}) {
    refused([&](auto& p) { p.width = side; });
    refused([&](auto& p) { p.height = side; });
  }
  refused([](auto& p) { p.format = 2; });
  refused([](auto& p) { p.alpha = 3; });
  refused([](auto& p) { p.pixels = nullptr; });
  refused([](auto& p) { p.struct_size = 3; });
  for (const int64_t stride :
       {int64_t(1), int64_t(4 * kWidth - 1), -int64_t(4 * kWidth - 1), INT64_MIN, INT64_MAX}) {
    refused([&](auto& p) { p.stride = stride; });
    refused([&](auto& p) { p.depth_stride = stride; });
  }
  refused([](auto& p) { p.depth_stride = 4 * kWidth + 2; });
  refused(
      [](auto& p) { p.depth = reinterpret_cast<float*>(reinterpret_cast<char*>(p.depth) + 1); });
  for (const float x : {NAN, INFINITY, -0.1f, 1.1f})
    refused([&](auto& p) {
      p.alpha = COSPLAT_ALPHA_OPAQUE;
      p.background[1] = x;
    });
  EXPECT_EQ(cosplat_render(avatar_, nullptr), COSPLAT_ERROR_ARGUMENT);
  const std::vector<uint8_t> after = Render(COSPLAT_ALPHA_STRAIGHT);
  EXPECT_EQ(after, player_.Render(params_, camera_).data);
}

TEST_F(PluginRender, ParametersAtTheirLimitsDoNoHarm) {
  cosplat_parameters p = ParametersOf(params_);
  const std::vector<float> max(kExpressionCount, COSPLAT_LARGEST_PARAMETER);
  p.expression = max.data();
  for (auto& joint : p.joints)
    for (float& x : joint) x = -COSPLAT_LARGEST_PARAMETER;
  for (const bool near : {false, true}) {
    for (float& x : p.translation) x = near ? 0 : COSPLAT_LARGEST_PARAMETER;
    ASSERT_EQ(cosplat_set_parameters(avatar_, &p), COSPLAT_OK);
    std::vector<uint8_t> bytes;
    std::vector<float> depth(kWidth * kHeight);
    cosplat_picture picture = PictureInto(bytes, kWidth, kHeight);
    picture.depth = depth.data();
    EXPECT_EQ(cosplat_render(avatar_, &picture), COSPLAT_OK) << cosplat_last_error(avatar_);
    for (const float d : depth) ASSERT_FALSE(std::isnan(d));
  }
  const cosplat_parameters good = ParametersOf(params_);
  ASSERT_EQ(cosplat_set_parameters(avatar_, &good), COSPLAT_OK);
  EXPECT_EQ(Render(COSPLAT_ALPHA_STRAIGHT), player_.Render(params_, camera_).data);
}

TEST_F(PluginRender, CamerasAtTheirLimitsDoNoHarm) {
  const std::pair<uint32_t, uint32_t> sizes[] = {
      {1, 1}, {17, 33}, {COSPLAT_LARGEST_SIDE, 1}, {1, COSPLAT_LARGEST_SIDE}};
  std::vector<uint8_t> bytes;
  for (const auto& [width, height] : sizes)
    for (const float focal : {1e-7f, 1e3f, 1e7f})
      for (const float middle : {-1e7f, 0.5f, 1e7f})
        for (const float along : {-1e7f, 0.0f, 1e-3f, 1e7f}) {
          cosplat_camera camera = SetOrbit(avatar_, width, height, 0.3f);
          camera.fx = camera.fy = focal;
          camera.cx = camera.cy = middle;
          camera.cam_from_world[11] = along;
          ASSERT_EQ(cosplat_set_camera(avatar_, &camera), COSPLAT_OK);
          std::vector<float> depth(size_t(width) * height);
          cosplat_picture picture = PictureInto(bytes, width, height);
          picture.depth = depth.data();
          ASSERT_EQ(cosplat_render(avatar_, &picture), COSPLAT_OK) << cosplat_last_error(avatar_);
          for (const float d : depth) ASSERT_FALSE(std::isnan(d));
        }
}

// Depth of a picture with rows `gap` floats longer than it is wide.
std::vector<float> DepthOf(cosplat_avatar* avatar,
                           uint32_t width,
                           uint32_t height,
                           size_t gap = 0) {
  std::vector<uint8_t> bytes;
  std::vector<float> depth((width + gap) * height, -1.0f);
  cosplat_picture picture = PictureInto(bytes, width, height);
  picture.depth = depth.data();
  picture.depth_stride = int64_t(4 * (width + gap));
  EXPECT_EQ(cosplat_render(avatar, &picture), COSPLAT_OK) << cosplat_last_error(avatar);
  return depth;
}

TEST_F(PluginRender, DepthIsThatOfTheHead) {
  PosedAvatar placed;
  player_.Pose(params_, placed);
  const Buffer<float>& position = player_.GaussiansOf(placed).position;
  float nearest = INFINITY, farthest = 0;
  for (size_t i = 0; i < position.size(); i += 3) {
    float z = camera_.translation[2];
    for (size_t k = 0; k < 3; ++k) z += camera_.rotation[6 + k] * position[i + k];
    nearest = std::min(nearest, z);
    farthest = std::max(farthest, z);
  }
  const std::vector<float> depth = DepthOf(avatar_, kWidth, kHeight);
  const std::vector<uint8_t> bytes = Render(COSPLAT_ALPHA_STRAIGHT);
  for (size_t p = 0; p < depth.size(); ++p) {
    if (bytes[4 * p + 3] > 0) {
      ASSERT_GE(depth[p], nearest * (1 - 1e-5f));
      ASSERT_LE(depth[p], farthest * (1 + 1e-5f));
    } else if (std::isfinite(depth[p])) {
      ASSERT_GE(depth[p], nearest * (1 - 1e-3f));  // of next to nothing: rounding counts
    }
  }
  EXPECT_EQ(depth[0], INFINITY);
  // The head's middle is solid: what is seen is its front.
  EXPECT_LT(depth[kWidth * (kHeight / 2) + kWidth / 2], 0.5f * (nearest + farthest));
  // Colours are the same with and without it, and so are rows that are apart.
  const std::vector<float> apart = DepthOf(avatar_, kWidth, kHeight, 3);
  for (size_t y = 0; y < kHeight; ++y) {
    for (size_t x = 0; x < kWidth; ++x)
      ASSERT_EQ(apart[y * (kWidth + 3) + x], depth[y * kWidth + x]);
    for (size_t x = kWidth; x < kWidth + 3; ++x) ASSERT_EQ(apart[y * (kWidth + 3) + x], -1.0f);
  }
  EXPECT_EQ(Render(COSPLAT_ALPHA_STRAIGHT), bytes);
}

// Two Gaussians behind each other: the mean of their depths, weighted by alpha and what is left.
TEST(PluginDepth, IsTheMeanOverWhatIsSeen) {
  const PluginFiles& files = PluginFiles::Get();
  AvatarModel model = files.avatar;
  model.gaussians.degrees.clear();
  model.embedding.triangle = {0, 0};
  model.embedding.barycentric = {{1, 0}, {1, 0}};
  Gaussians& g = model.gaussians;
  g.Resize(0);
  g.Resize(2);
  for (size_t i = 0; i < 2; ++i) {
    g.at(kRotation, i)[0] = 1;
    for (int k = 0; k < 3; ++k) g.at(kScaleLog, i)[k] = std::log(0.05f);
  }
  *g.at(kOpacityLogit, 0) = 0;  // a half
  *g.at(kOpacityLogit, 1) = std::log(0.25f / 0.75f);
  g.at(kPosition, 1)[2] = 0.3f;  // along the normal
  const OpenAvatar avatar(files.Write("two.glb", model));

  Player player(model, files.flame);
  PosedAvatar placed;
  player.Pose({}, placed);
  const float* p = player.GaussiansOf(placed).position.data();
  const float* q = p + 3;
  // A camera that looks from the second to the first, 0.5 m before the second.
  const float length = std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
  EXPECT_NEAR(length, 0.3f, 1e-3f);
  const float z[3] = {(p[0] - q[0]) / length, (p[1] - q[1]) / length, (p[2] - q[2]) / length};
  const float across = std::hypot(z[0], z[2]);
  const float x[3] = {z[2] / across, 0, -z[0] / across};
  const float y[3] = {
      z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]};
  cosplat_camera camera = Zeroed<cosplat_camera>();
  camera.width = camera.height = 33;
  camera.fx = camera.fy = 33;
  camera.cx = camera.cy = 16.5f;
  const float* rows[3] = {x, y, z};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      camera.cam_from_world[4 * i + k] = rows[i][k];
      camera.cam_from_world[4 * i + 3] -= rows[i][k] * q[k];
    }
  }
  camera.cam_from_world[11] += 0.5f;
  ASSERT_EQ(cosplat_set_camera(avatar, &camera), COSPLAT_OK) << cosplat_last_error(avatar);
  const std::vector<float> depth = DepthOf(avatar, 33, 33);
  const float near = 0.25f, far = 0.75f * 0.5f;  // weights
  EXPECT_NEAR(depth[33 * 16 + 16], (near * 0.5f + far * (0.5f + length)) / (near + far), 1e-4f);
}

}  // namespace
}  // namespace cosplat::test
