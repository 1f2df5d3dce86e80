// What a host must show: the library's own pictures.
#pragma once

#include <numbers>

#include "splat/base/npz.h"
#include "tests/plugin/plugin_fixture.h"

namespace cosplat::test {

// A recording of `count` frames in which the mouth opens and an expression comes; returns its path.
inline std::string WriteRecording(size_t count, float frames_per_second) {
  const std::string path = PluginFiles::Get().folder / "talk.npz";
  std::vector<float> expression, jaw;
  for (size_t n = 0; n < count; ++n) {
    const float at = float(n) / float(count);
    expression.insert(expression.end(), {2 * at, 0, -at});
    jaw.insert(jaw.end(), {0.3f * at, 0, 0});
  }
  Npz npz(path);
  npz.Add("expr", {count, 3}, expression);
  npz.Add("jaw_rot", {count, 3}, jaw);
  npz.Add("fps", {}, std::vector<float>{frames_per_second});
  npz.Write(path);
  return path;
}

// How the library itself draws what an element is asked for.
struct Wanted {
  uint32_t width = 512, height = 512;
  float azimuth = 0, elevation = 0, zoom = 1;  // degrees
  uint32_t format = COSPLAT_FORMAT_RGBA8;
  uint32_t alpha = COSPLAT_ALPHA_OPAQUE;
  std::array<float, 3> background = {0.2f, 0.4f, 0.6f};  // the avatar's own
};

inline std::vector<uint8_t> Draw(cosplat_avatar* avatar, const Wanted& wanted) {
  const auto radians = [](float degrees) {
    return float(double(degrees) * std::numbers::pi / 180);
  };
  cosplat_camera camera = Zeroed<cosplat_camera>();
  EXPECT_EQ(cosplat_orbit_camera(avatar,
                                 wanted.width,
                                 wanted.height,
                                 radians(wanted.azimuth),
                                 radians(wanted.elevation),
                                 wanted.zoom,
                                 &camera),
            COSPLAT_OK);
  EXPECT_EQ(cosplat_set_camera(avatar, &camera), COSPLAT_OK);
  std::vector<uint8_t> bytes;
  cosplat_picture picture = PictureInto(bytes, wanted.width, wanted.height);
  picture.format = wanted.format;
  picture.alpha = wanted.alpha;
  std::copy(wanted.background.begin(), wanted.background.end(), picture.background);
  EXPECT_EQ(cosplat_render(avatar, &picture), COSPLAT_OK) << cosplat_last_error(avatar);
  return bytes;
}

inline std::vector<uint8_t> Draw(const Wanted& wanted) { return Draw(OpenAvatar(), wanted); }

}  // namespace cosplat::test
