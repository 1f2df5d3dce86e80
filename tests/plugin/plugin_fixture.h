// An avatar of the made head as files, as a host has it.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "apps/study/avatar_stability/painted_avatar.h"
#include "avatar/io/avatar_file.h"
#include "avatar/plugin/cosplat.h"
#include "flame/model.h"
#include "splat/base/camera.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {

// A structure of cosplat.h, all zero but for its size.
template <class T>
T Zeroed() {
  T value;
  std::memset(&value, 0, sizeof(value));
  value.struct_size = sizeof(value);
  return value;
}

class PluginFiles {
 public:
  // Made once per process.
  static const PluginFiles& Get() {
    static const PluginFiles files;
    return files;
  }

  // Writes `avatar` under this name; returns its path.
  std::string Write(const std::string& name, AvatarModel avatar) const {
    avatar.flame_name = flame.name;
    avatar.flame_sha256 = flame.sha256;
    WriteAvatarGlb(folder / name, avatar, nullptr);
    return folder / name;
  }

  TemporaryFolder folder;
  ProceduralHead head = MakeProceduralHeadParts();
  std::string flame_path = folder / "head.npz";
  FlameModel flame;  // as read
  std::string avatar_path;
  AvatarModel avatar;  // as read

 private:
  PluginFiles() {
    WriteFlameModelNpz(flame_path, head.model);
    flame = LoadFlameModel(flame_path);
    AvatarModel painted = PaintedAvatar(head, 1500);
    painted.background = {0.2f, 0.4f, 0.6f};
    avatar_path = Write("avatar.glb", painted);
    avatar = ReadAvatarGlb(avatar_path);
    AttachMesh(avatar, flame);
  }
};

inline cosplat_open_options OpenOptions() {
  cosplat_open_options options = Zeroed<cosplat_open_options>();
  options.flame_path = PluginFiles::Get().flame_path.c_str();
  return options;
}

// An avatar that is open as long as this is there.
class OpenAvatar {
 public:
  explicit OpenAvatar(const std::string& path = PluginFiles::Get().avatar_path) {
    const cosplat_open_options options = OpenOptions();
    EXPECT_EQ(cosplat_open(path.c_str(), &options, &handle_), COSPLAT_OK)
        << cosplat_last_error(nullptr);
  }
  ~OpenAvatar() { cosplat_close(handle_); }
  OpenAvatar(const OpenAvatar&) = delete;
  OpenAvatar& operator=(const OpenAvatar&) = delete;
  operator cosplat_avatar*() const { return handle_; }  // NOLINT: it stands for the handle

 private:
  cosplat_avatar* handle_ = nullptr;
};

// `params`, which must outlive it.
inline cosplat_parameters ParametersOf(const FlameParams& params, int64_t time_ns = 0) {
  cosplat_parameters p = Zeroed<cosplat_parameters>();
  p.expression_count = uint32_t(params.expression.size());
  p.expression = params.expression.data();
  p.time_ns = time_ns;
  for (size_t j = 0; j < COSPLAT_JOINT_COUNT; ++j)
    for (size_t k = 0; k < 3; ++k) p.joints[j][k] = params.pose[j][k];
  for (size_t k = 0; k < 3; ++k) p.translation[k] = params.translation[k];
  return p;
}

// Both ways without a change of bits, for rotations that are exactly orthonormal or came out of the
// library.
inline Camera CameraOf(const cosplat_camera& c) {
  Camera camera;
  camera.width = int(c.width);
  camera.height = int(c.height);
  camera.fx = c.fx;
  camera.fy = c.fy;
  camera.cx = c.cx;
  camera.cy = c.cy;
  for (size_t i = 0; i < 3; ++i) {
    for (size_t k = 0; k < 3; ++k) camera.rotation[3 * i + k] = c.cam_from_world[4 * i + k];
    camera.translation[i] = c.cam_from_world[4 * i + 3];
  }
  return camera;
}

// Sets an orbit's camera; returns the one that is then set.
inline cosplat_camera SetOrbit(
    cosplat_avatar* avatar, uint32_t width, uint32_t height, float azimuth, float elevation = 0) {
  cosplat_camera camera = Zeroed<cosplat_camera>();
  EXPECT_EQ(cosplat_orbit_camera(avatar, width, height, azimuth, elevation, 1, &camera),
            COSPLAT_OK);
  EXPECT_EQ(cosplat_set_camera(avatar, &camera), COSPLAT_OK);
  EXPECT_EQ(cosplat_get_camera(avatar, &camera), COSPLAT_OK);
  return camera;
}

// A picture into `bytes`, which is sized for it: rows one after the other.
inline cosplat_picture PictureInto(std::vector<uint8_t>& bytes, uint32_t width, uint32_t height) {
  bytes.assign(size_t(4) * width * height, 0);
  cosplat_picture picture = Zeroed<cosplat_picture>();
  picture.width = width;
  picture.height = height;
  picture.pixels = bytes.data();
  return picture;
}

}  // namespace cosplat::test
