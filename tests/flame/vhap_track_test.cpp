// VHAP's files.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "tests/flame/track_fixture.h"
#include "tests/support/expect_error.h"

namespace cosplat::test {
namespace {

using Json = nlohmann::json;

TEST(TrackedVideo, VhapTimeIsInTheNamesWhereNothingElseSaysIt) {
  Vhap set(12, 12);
  for (Json& frame : set.train["frames"]) frame.erase("timestep_index");
  std::swap(set.train["frames"][2], set.train["frames"][10]);
  const TrackedVideo video = set.Load({.test_frames = 2});
  ASSERT_EQ(video.test.size(), 2u);
  EXPECT_EQ(video.test[0].name, "10");
  EXPECT_EQ(video.train[2].name, "2");
}

TEST(TrackedVideo, VhapParameterFiles) {
  Vhap set;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  set.params[1].Add("jaw_pose", {1, 3}, std::vector<float>{0, nan, 0});
  set.params[2].Add("eyes_pose", {1, 3}, std::vector<float>{0, 0, 0});
  set.params[3].Add("dynamic_offset", {1, 2, 3}, std::vector<float>{0, 0, 1, 0, 0, 0});
  set.params[8].Add("dynamic_offset", {1, 2, 3}, std::vector<float>(6, 0.f));  // harmless
  const TrackedVideo video = set.Load();
  ASSERT_EQ(video.skipped.size(), 3u);
  EXPECT_NE(video.skipped[0].reason.find("jaw_pose[1] is not finite"), std::string::npos);
  EXPECT_NE(video.skipped[1].reason.find("eyes_pose has 3 numbers, expected 6"), std::string::npos);
  EXPECT_NE(video.skipped[2].reason.find("dynamic_offset"), std::string::npos);
  std::filesystem::remove(set.folder / "flame_param/4.npz");
  set.params.erase(4);
  ExpectError([&] { set.Load(); }, {"4 of 10", "jaw_pose"});
  Vhap cut;
  cut.Load();
  const std::vector<char> bytes = ReadFile(cut.folder / "flame_param/5.npz");
  cut.params.erase(5);
  WriteFileAtomically(cut.folder / "flame_param/5.npz",
                      std::string(bytes.begin(), bytes.end() - 9));
  const TrackedVideo rest = cut.Load();
  ASSERT_EQ(rest.skipped.size(), 1u);
  EXPECT_NE(rest.skipped[0].reason.find("5.npz"), std::string::npos);
}

TEST(TrackedVideo, VhapSubject) {
  Vhap set;
  EXPECT_TRUE(set.Load().static_offset.empty());  // all zero
  Npz canonical;
  std::vector<float> offsets(5143 * 3, 0.f);
  offsets[3] = 0.01f;
  offsets[5142 * 3] = 7;  // of its own teeth
  canonical.Add("shape", {3}, std::vector<float>{1, 2, 3});
  canonical.Add("static_offset", {1, 5143, 3}, offsets);
  canonical.Write(set.folder / "canonical_flame_param.npz");
  const TrackedVideo video = set.Load();
  EXPECT_EQ(video.shape, (std::vector<float>{1, 2, 3}));
  ASSERT_EQ(video.static_offset.size(), 5143u * 3);  // as it is: see StaticOffsetFor
  EXPECT_FLOAT_EQ(video.static_offset[3], 0.01f);
  canonical.Add("static_offset", {1, 3, 5143}, offsets);
  canonical.Write(set.folder / "canonical_flame_param.npz");
  ExpectError([&] { set.Load(); }, {"canonical_flame_param.npz", "static_offset", "[V, 3]"});
  canonical.Add("static_offset", {1, 5143, 3}, offsets);
  canonical.Add("shape", {1}, std::vector<float>{std::numeric_limits<float>::infinity()});
  canonical.Write(set.folder / "canonical_flame_param.npz");
  ExpectError([&] { set.Load(); }, {"canonical_flame_param.npz", "shape[0]", "not finite"});
}

TEST(TrackedVideo, VhapJsonErrorsNameTheField) {
  const struct {
    const char* pointer;
    Json value;
    std::vector<std::string> parts;
  } cases[] = {
      {"/w", 0, {"transforms_train.json", "frames[0]", "not positive"}},
      {"/fl_x", "x", {"transforms_train.json", "fl_x", "\"x\""}},
      {"/frames/2/transform_matrix", 3, {"frames[2].transform_matrix", "an array"}},
      {"/frames/2/flame_param_path", 3, {"flame_param_path", "a string"}},
      {"/frames", Json::object(), {"frames", "an array"}},
      {"/frames/2/timestep_index", 0.033, {"frames[2].timestep_index", "an integer"}},
      {"/frames/2/timestep_index", 1, {"timestep_index", "is 1 for both 1 and 2"}},
      {"/k1", 0.1, {"k1", "undistort"}},
      {"/frames/2/p2", 0.1, {"frames[2].p2", "undistort"}},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.pointer);
    Vhap set;
    for (int i = 0; i < 8; ++i)  // of a camera that stands still
      set.train["frames"][i]["transform_matrix"] = set.train["frames"][0]["transform_matrix"];
    set.train[Json::json_pointer(c.pointer)] = c.value;
    ExpectError([&] { set.Load(); }, c.parts);
  }
}

}  // namespace
}  // namespace cosplat::test
