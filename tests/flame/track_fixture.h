// The same tracked video in IMavatar's and in VHAP's layout.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "flame/track.h"
#include "splat/base/files.h"
#include "splat/base/npz.h"
#include "splat/media/image_io.h"
#include "tests/flame/all_frames.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {

constexpr int kWidth = 32, kHeight = 24;

// A pose of the test's camera: cam_from_world with OpenGL's axes.
struct GlPose {
  double angle;  // about y
  std::array<double, 3> translation;
};
inline GlPose PoseOf(int i) { return {0.1 * i, {0.01 * i, -0.02, -1.2 - 0.01 * i}}; }

inline Image8 TestImage(int index, int channels) {
  Image8 image(kWidth, kHeight, channels, uint8_t(10 * index));
  if (channels == 4)
    for (size_t i = 0; i < image.pixels(); ++i) image.data[4 * i + 3] = i % 2 ? 255 : 0;
  return image;
}

inline Image8 TestMask() {
  Image8 mask(kWidth, kHeight, 1);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth / 2; ++x) mask.at(x, y, 0) = 255;
  return mask;
}

struct Imavatar {
  TemporaryFolder folder;
  nlohmann::json json;

  explicit Imavatar(int count = 10) {
    json = {{"intrinsics", {-2.0, 3.0, 0.5, 0.45}},
            {"shape_params", {0.5, -0.25}},
            {"frames", nlohmann::json::array()}};
    for (int i = 0; i < count; ++i) {
      const auto [angle, t] = PoseOf(i);
      const double c = std::cos(angle), s = std::sin(angle);
      nlohmann::json pose = nlohmann::json::array();
      for (int k = 0; k < 15; ++k) pose.push_back(0.01 * k + 0.1 * i);
      json["frames"].push_back(
          {{"file_path", "./image/" + std::to_string(i + 1)},
           {"world_mat", {{c, 0, s, 4 * t[0]}, {0, 1, 0, 4 * t[1]}, {-s, 0, c, 4 * t[2]}}},
           {"expression", {0.1 * i, 0.2, 0.3}},
           {"pose", pose}});
    }
  }

  void WriteImages(int channels, const std::string& name = "image") const {
    MakeDirectories(folder / name);
    for (size_t i = 1; i <= json["frames"].size(); ++i)
      WriteImage(folder / (name + "/" + std::to_string(i) + ".png"), TestImage(int(i), channels));
  }

  void WriteMasks() const {
    MakeDirectories(folder / "mask");
    for (size_t i = 1; i <= json["frames"].size(); ++i)
      WriteImage(folder / ("mask/" + std::to_string(i) + ".png"), TestMask());
  }

  const std::string& Write() const {
    WriteFileAtomically(folder / "flame_params.json", json.dump());
    return folder.path();
  }
  TrackedVideo Load(const TrackOptions& options = {}) const {
    return LoadTrackedVideo(Write(), options);
  }
};

// The same track in VHAP's layout; frames from `first_test` on are the test split.
struct Vhap {
  TemporaryFolder folder;
  nlohmann::json train, test;
  std::map<int, Npz> params;

  explicit Vhap(int count = 10, int first_test = 8) {
    train = {{"w", kWidth},
             {"h", kHeight},
             {"fl_x", 2.0 * kWidth},
             {"fl_y", 3.0 * kHeight},
             {"cx", 0.5 * kWidth},
             {"cy", 0.45 * kHeight},
             {"frames", nlohmann::json::array()}};
    test = train;
    MakeDirectories(folder / "images");
    MakeDirectories(folder / "flame_param");
    for (int i = 0; i < count; ++i) {
      const auto [angle, t] = PoseOf(i);
      const double c = std::cos(angle), s = std::sin(angle);
      // world_from_cam: [R^T, -R^T t].
      const nlohmann::json matrix = {{c, 0, -s, -(c * t[0] - s * t[2])},
                                     {0, 1, 0, -t[1]},
                                     {s, 0, c, -(s * t[0] + c * t[2])},
                                     {0, 0, 0, 1}};
      const std::string stem = std::to_string(i);
      (i < first_test ? train : test)["frames"].push_back(
          {{"file_path", "images/" + stem + ".png"},
           {"fg_mask_path", "masks/" + stem + ".png"},
           {"flame_param_path", "flame_param/" + stem + ".npz"},
           {"timestep_index", i},
           {"camera_index", 0},
           {"transform_matrix", matrix}});
      WriteImage(folder / ("images/" + stem + ".png"), TestImage(i + 1, 4));
      FillParams(i);
    }
  }

  void FillParams(int i) {
    const auto vector = [&](int first, int count) {
      std::vector<float> v;
      for (int k = 0; k < count; ++k) v.push_back(float(0.01 * (first + k) + 0.1 * i));
      return v;
    };
    Npz& npz = params[i];
    npz.Add("rotation", {1, 3}, vector(0, 3));
    npz.Add("neck_pose", {1, 3}, vector(3, 3));
    npz.Add("jaw_pose", {1, 3}, vector(6, 3));
    npz.Add("eyes_pose", {1, 6}, vector(9, 6));
    npz.Add("translation", {1, 3}, std::vector<float>{0, 0, 0});
    npz.Add("expr", {1, 3}, std::vector<float>{float(0.1 * i), 0.2f, 0.3f});
    npz.Add("shape", {2}, std::vector<float>{0.5f, -0.25f});
    npz.Add("static_offset", {1, 5143, 3}, std::vector<float>(5143 * 3, 0.f));
  }

  const std::string& Write() const {
    WriteFileAtomically(folder / "transforms_train.json", train.dump());
    WriteFileAtomically(folder / "transforms_test.json", test.dump());
    for (const auto& [i, npz] : params)
      npz.Write(folder / ("flame_param/" + std::to_string(i) + ".npz"));
    return folder.path();
  }
  TrackedVideo Load(const TrackOptions& options = {}) const {
    return LoadTrackedVideo(Write(), options);
  }
};

}  // namespace cosplat::test
