// cosplat.h: the camera, and the one that circles the resting head.
#include <cmath>
#include <functional>

#include "avatar/model/avatar_mesh.h"
#include "tests/plugin/plugin_fixture.h"

namespace cosplat::test {
namespace {

const FlameModel& Flame() { return PluginFiles::Get().flame; }

cosplat_camera SomeCamera() {
  cosplat_camera c = Zeroed<cosplat_camera>();
  c.width = 40;
  c.height = 30;
  c.fx = 50;
  c.fy = 51;
  c.cx = 20.5f;
  c.cy = -3;
  const float matrix[12] = {1, 0, 0, 0.1f, 0, -1, 0, 0.2f, 0, 0, -1, 0.9f};
  std::copy(matrix, matrix + 12, c.cam_from_world);
  return c;
}

TEST(PluginCamera, ComesBackAsItWasSet) {
  const OpenAvatar avatar;
  cosplat_camera camera = Zeroed<cosplat_camera>();
  EXPECT_EQ(cosplat_get_camera(avatar, &camera), COSPLAT_ERROR_NOT_FOUND);
  const cosplat_camera set = SomeCamera();
  ASSERT_EQ(cosplat_set_camera(avatar, &set), COSPLAT_OK);
  ASSERT_EQ(cosplat_get_camera(avatar, &camera), COSPLAT_OK);
  EXPECT_EQ(std::memcmp(&camera, &set, sizeof(set)), 0);
}

TEST(PluginCamera, WrongOnesAreRefusedAndTheLastStays) {
  const OpenAvatar avatar;
  const cosplat_camera good = SomeCamera();
  ASSERT_EQ(cosplat_set_camera(avatar, &good), COSPLAT_OK);
  const auto refused = [&](cosplat_status status,
                           const std::function<void(cosplat_camera&)>& spoil) {
    cosplat_camera bad = good, kept = Zeroed<cosplat_camera>();
    spoil(bad);
    EXPECT_EQ(cosplat_set_camera(avatar, &bad), status) << cosplat_last_error(avatar);
    ASSERT_EQ(cosplat_get_camera(avatar, &kept), COSPLAT_OK);
    EXPECT_EQ(std::memcmp(&kept, &good, sizeof(good)), 0);
  };
  for (const uint32_t side : {0u, COSPLAT_LARGEST_SIDE + 1u, ~0u}) {
    refused(COSPLAT_ERROR_ARGUMENT, [&](auto& c) { c.width = side; });
    refused(COSPLAT_ERROR_ARGUMENT, [&](auto& c) { c.height = side; });
  }
  refused(COSPLAT_ERROR_ARGUMENT, [](auto& c) { c.width = c.height = COSPLAT_LARGEST_SIDE; });
  for (const float x : {NAN, INFINITY}) {
    refused(COSPLAT_ERROR_NOT_FINITE, [&](auto& c) { c.fx = x; });
    refused(COSPLAT_ERROR_NOT_FINITE, [&](auto& c) { c.fy = x; });
    refused(COSPLAT_ERROR_NOT_FINITE, [&](auto& c) { c.cx = x; });
    refused(COSPLAT_ERROR_NOT_FINITE, [&](auto& c) { c.cy = x; });
    for (int i = 0; i < 12; ++i)
      refused(COSPLAT_ERROR_NOT_FINITE, [&](auto& c) { c.cam_from_world[i] = x; });
  }
  for (const float focal : {0.0f, -1.0f, 1e9f})
    refused(COSPLAT_ERROR_ARGUMENT, [&](auto& c) { c.fx = focal; });
  refused(COSPLAT_ERROR_ARGUMENT, [](auto& c) { c.cam_from_world[0] = 1.1f; });
  refused(COSPLAT_ERROR_ARGUMENT, [](auto& c) { c.cam_from_world[0] = -1; });  // mirrors
  refused(COSPLAT_ERROR_ARGUMENT, [](auto& c) { c.cam_from_world[3] = 1e20f; });
  refused(COSPLAT_ERROR_ARGUMENT, [](auto& c) { c.struct_size = 0; });
  EXPECT_EQ(cosplat_set_camera(avatar, nullptr), COSPLAT_ERROR_ARGUMENT);
  EXPECT_EQ(cosplat_get_camera(avatar, nullptr), COSPLAT_ERROR_ARGUMENT);
}

// Where a point of the world is in the picture, px.
std::array<float, 2> Projected(const cosplat_camera& c, const std::array<float, 3>& p) {
  float q[3];
  for (int i = 0; i < 3; ++i) {
    const float* row = &c.cam_from_world[4 * i];
    q[i] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
  }
  EXPECT_GT(q[2], 0);
  return {c.fx * q[0] / q[2] + c.cx, c.fy * q[1] / q[2] + c.cy};
}

// Rows and columns of the picture that the resting head's vertices reach.
struct Extent {
  float left = INFINITY, right = -INFINITY, top = INFINITY, bottom = -INFINITY;
};
Extent HeadIn(const cosplat_camera& camera, const std::vector<float>& vertices) {
  Extent e;
  for (size_t v = 0; v < size_t(Flame().vertex_count); ++v) {
    const auto p = Projected(camera, {vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]});
    e.left = std::min(e.left, p[0]);
    e.right = std::max(e.right, p[0]);
    e.top = std::min(e.top, p[1]);
    e.bottom = std::max(e.bottom, p[1]);
  }
  return e;
}

cosplat_camera Orbit(cosplat_avatar* avatar, uint32_t w, uint32_t h, float a, float e, float zoom) {
  cosplat_camera camera = Zeroed<cosplat_camera>();
  EXPECT_EQ(cosplat_orbit_camera(avatar, w, h, a, e, zoom, &camera), COSPLAT_OK);
  return camera;
}

TEST(PluginOrbit, ShowsTheHead) {
  const OpenAvatar avatar;
  const std::vector<float>& vertices = Flame().template_vertices;
  for (const auto& [w, h] : {std::pair{200u, 200u}, {320u, 200u}, {200u, 320u}}) {
    const cosplat_camera camera = Orbit(avatar, w, h, 0, 0, 1);
    EXPECT_EQ(camera.width, w);
    EXPECT_EQ(camera.height, h);
    const Extent e = HeadIn(camera, vertices);
    EXPECT_NEAR(0.5f * (e.top + e.bottom), 0.5f * float(h), 10);
    EXPECT_NEAR(0.5f * (e.left + e.right), 0.5f * float(w), 1);
    EXPECT_NEAR(e.bottom - e.top, 140, 14);  // seven tenths of 200, but for perspective
    EXPECT_EQ(Orbit(avatar, w, h, 0, 0, 2).fx, 2 * camera.fx);
  }
  for (const float azimuth : {-2.0f, 0.7f, 1.5f})
    for (const float elevation : {-1.4f, 0.5f}) {
      const Extent e = HeadIn(Orbit(avatar, 200, 200, azimuth, elevation, 1), vertices);
      EXPECT_TRUE(e.left > 0 && e.right < 200 && e.top > 0 && e.bottom < 200)
          << azimuth << " " << elevation << ": " << e.left << " " << e.right << " " << e.top << " "
          << e.bottom;
    }
}

TEST(PluginOrbit, TurnsAsItSays) {
  const OpenAvatar avatar;
  const auto center = [](const cosplat_camera& c) { return CameraOf(c).Center(); };
  const auto front = center(Orbit(avatar, 64, 64, 0, 0, 1));
  EXPECT_NEAR(front[0], 0, 0.01f);
  EXPECT_GT(front[2], 0.4f);                                            // the face looks along +z
  EXPECT_GT(center(Orbit(avatar, 64, 64, 1.5707963f, 0, 1))[0], 0.4f);  // the subject's left is +x
  EXPECT_GT(center(Orbit(avatar, 64, 64, 0, 1.5f, 1))[1], 0.4f);
}

TEST(PluginOrbit, RefusesWhatItCannotDo) {
  const OpenAvatar avatar;
  cosplat_camera camera = Zeroed<cosplat_camera>();
  const auto orbit = [&](uint32_t w, uint32_t h, float azimuth, float elevation, float zoom) {
    return cosplat_orbit_camera(avatar, w, h, azimuth, elevation, zoom, &camera);
  };
  EXPECT_EQ(orbit(0, 5, 0, 0, 1), COSPLAT_ERROR_ARGUMENT);
  EXPECT_EQ(orbit(5, ~0u, 0, 0, 1), COSPLAT_ERROR_ARGUMENT);
  EXPECT_EQ(orbit(5, 5, NAN, 0, 1), COSPLAT_ERROR_NOT_FINITE);
  EXPECT_EQ(orbit(5, 5, 0, INFINITY, 1), COSPLAT_ERROR_NOT_FINITE);
  EXPECT_EQ(orbit(5, 5, 0, 1.6f, 1), COSPLAT_ERROR_ARGUMENT);
  EXPECT_EQ(orbit(5, 5, 1e30f, 0, 1), COSPLAT_ERROR_ARGUMENT);
  for (const float zoom : {0.0f, -1.0f, 1000.0f})
    EXPECT_EQ(orbit(5, 5, 0, 0, zoom), COSPLAT_ERROR_ARGUMENT);
  EXPECT_EQ(cosplat_orbit_camera(avatar, 5, 5, 0, 0, 1, nullptr), COSPLAT_ERROR_ARGUMENT);
}

// An avatar that was trained upside down before its camera, with a bust: it opens with its head on
// its shoulders, and the orbit goes around it as around any other.
TEST(PluginRest, TheHeadSitsOnItsBust) {
  const PluginFiles& files = PluginFiles::Get();
  AvatarModel model = files.avatar;
  FlameParams root;
  root.pose[0] = {3.0f, 0.2f, 0.1f};
  root.translation = {0.1f, -0.2f, 1.5f};
  model.bust = MeanBust(files.flame, model.shape, model.static_offset, {root});
  model.mesh = {};
  AttachMesh(model, files.flame);
  const OpenAvatar avatar(files.Write("bust.glb", model));
  cosplat_parameters rest = Zeroed<cosplat_parameters>();
  ASSERT_EQ(cosplat_get_parameters(avatar, &rest), COSPLAT_OK);
  std::vector<float> posed, expected;
  AvatarPoser poser(files.flame, {}, {}, model.bust);
  poser.Forward(poser.ParametersFor(root), expected);
  FlameParams opened;
  for (size_t k = 0; k < 3; ++k) {
    opened.pose[0][k] = rest.joints[COSPLAT_JOINT_ROOT][k];
    opened.translation[k] = rest.translation[k];
  }
  poser.Forward(poser.ParametersFor(opened), posed);
  for (size_t i = 0; i < posed.size(); ++i) ASSERT_NEAR(posed[i], expected[i], 1e-5f);
  const Extent turned = HeadIn(Orbit(avatar, 200, 200, 0.4f, 0.2f, 1), posed);
  const OpenAvatar plain;
  const Extent upright =
      HeadIn(Orbit(plain, 200, 200, 0.4f, 0.2f, 1), files.flame.template_vertices);
  EXPECT_NEAR(turned.left, upright.left, 0.1f);
  EXPECT_NEAR(turned.bottom, upright.bottom, 0.1f);
}

}  // namespace
}  // namespace cosplat::test
