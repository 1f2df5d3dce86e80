// The map from blendshape scores, as avatar files hold it.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <tuple>

#include "avatar/io/avatar_file.h"
#include "splat/base/files.h"
#include "tests/avatar/meshes.h"
#include "tests/support/expect_error.h"
#include "tests/support/glb_bytes.h"
#include "tests/support/random_gaussians.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using nlohmann::json;

constexpr const char* kPointer =
    "/meshes/0/primitives/0/extensions/KHR_gaussian_splatting/extensions/COSPLAT_mesh_binding";

class BlendshapeMapFile : public testing::Test {
 protected:
  const test::TemporaryFolder folder_;
  const std::string path_ = folder_ / "avatar.glb";

  AvatarModel Avatar() const {
    AvatarModel model = test::RandomAvatar(test::SphereMesh(1, 0.1f), 3, 3);
    model.gaussians = test::RandomGaussians(3, 0, Basis::kSh, 4);
    BlendshapeMap& map = model.blendshapes.emplace();
    map.names = {"jawOpen", "other"};  // a set of one's own
    map.min = {0, 0.1f};
    map.max = {1, 0.4f};
    for (int i = 0; i < 11; ++i) map.offset.push_back(0.1f * float(i));
    for (int i = 0; i < 22; ++i) map.matrix.push_back(float(i) / 7);
    map.fit = {170, 0.875f, 3e-4f, 9e-4f};
    return model;
  }
  std::string Written(const AvatarModel& model) const {
    WriteAvatarGlb(path_, model, nullptr);
    const std::vector<char> bytes = ReadFile(path_);
    return {bytes.begin(), bytes.end()};
  }
};

TEST_F(BlendshapeMapFile, ComesBack) {
  const AvatarModel model = Avatar();
  Written(model);
  const BlendshapeMap &map = *model.blendshapes, read = ReadAvatarGlb(path_).blendshapes.value();
  EXPECT_EQ(read.names, map.names);
  EXPECT_EQ(read.min, map.min);
  EXPECT_EQ(read.max, map.max);
  EXPECT_EQ(read.offset, map.offset);
  EXPECT_EQ(read.matrix, map.matrix);
  EXPECT_EQ(read.fit.frames, 170);
  EXPECT_EQ(read.fit.r2, 0.875f);
  EXPECT_EQ(read.fit.error, 3e-4f);
  EXPECT_EQ(read.fit.mean_face_error, 9e-4f);
  EXPECT_NE(ToString(SummarizeGlb(path_))
                .find("driven by 2 blendshape scores, fitted to 170 frames; held out: R2 0.88"),
            std::string::npos);
}

TEST_F(BlendshapeMapFile, FilesWithoutItHaveTheBytesOfBefore) {
  AvatarModel model = Avatar();
  const json with = test::SplitGlb(Written(model)).json;
  model.blendshapes.reset();
  const std::string bytes = Written(model);
  EXPECT_EQ(bytes.find("blendshape"), std::string::npos);
  EXPECT_FALSE(ReadAvatarGlb(path_).blendshapes);
  EXPECT_EQ(ToString(SummarizeGlb(path_)).find("blendshape"), std::string::npos);
  // Readers that do not know the field can play the avatar: the version stays.
  const json::json_pointer version(std::string(kPointer) + "/version");
  EXPECT_EQ(with[version], test::SplitGlb(bytes).json[version]);
}

TEST_F(BlendshapeMapFile, BadOnesAreNotWritten) {
  const auto refused = [&](const std::function<void(BlendshapeMap&)>& spoil,
                           const std::vector<std::string>& parts) {
    AvatarModel model = Avatar();
    spoil(*model.blendshapes);
    test::ExpectError([&] { WriteAvatarGlb(path_, model, nullptr); }, parts);
  };
  refused([](BlendshapeMap& m) { m.matrix[3] = NAN; }, {"matrix", "number 3 is not finite"});
  refused([](BlendshapeMap& m) { m.matrix.pop_back(); }, {"matrix", "21", "22"});
  refused([](BlendshapeMap& m) { m.offset.resize(8); }, {"offset", "8", "9"});
  refused([](BlendshapeMap& m) { m.offset[2] = INFINITY; }, {"offset", "2"});
  refused([](BlendshapeMap& m) { m.matrix[5] = 101; }, {"matrix", "column 5", "100"});
  refused([](BlendshapeMap& m) { m.min.pop_back(); }, {"least", "1", "2"});
  refused([](BlendshapeMap& m) { m.max[1] = 0.1f; }, {"most", "'other'"});
  refused([](BlendshapeMap& m) { m.max[0] = 1.5f; }, {"most", "'jawOpen'"});
  refused([](BlendshapeMap& m) { m.names[1] = "JawOpen"; }, {"names", "'JawOpen'", "0 and 1"});
  refused([](BlendshapeMap& m) { m.names[1] = ""; }, {"names", "number 1 is empty"});
  refused([](BlendshapeMap& m) { m.fit.r2 = NAN; }, {"fit"});
}

TEST_F(BlendshapeMapFile, DamagedOnesAreOneLineThatNamesTheField) {
  const test::GlbBytes valid = test::SplitGlb(Written(Avatar()));
  const std::vector<std::tuple<const char*, json, const char*>> cases{
      {"", 7, "blendshapes"},
      {"/names", json::array(), "names: has 0 names"},
      {"/names", std::vector<std::string>(2000, "a"), "names: has 2000 names"},
      {"/names", {"jawOpen"}, "least"},
      {"/names", {"jawOpen", "jawopen"}, "'jawopen' is number 0 and 1"},
      {"/names", {"jawOpen", 3}, "names[1]"},
      {"/least", {0, nullptr}, "least[1]"},
      {"/most", {1, 0.05}, "'other'"},
      {"/offset", {1, 2, 3}, "matrix"},
      {"/offset", json::array(), "offset: has 0 numbers"},
      {"/matrix", -1, "matrix"},
      {"/matrix", 0, "matrix"},
      {"/fit", 3, "fit"},
      {"/fit/frames", -1, "fit.frames: is -1"},
      {"/fit/r2", nullptr, "fit.r2"},
  };
  for (const auto& [field, value, named] : cases) {
    test::GlbBytes changed = valid;
    changed.json[json::json_pointer(std::string(kPointer) + "/blendshapes" + field)] = value;
    WriteFileAtomically(path_, test::JoinGlb(changed));
    test::ExpectError([&] { ReadAvatarGlb(path_); }, {path_, "blendshapes", named});
  }
}

}  // namespace
}  // namespace cosplat
