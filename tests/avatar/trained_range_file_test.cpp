// The range of faces seen in training, as avatar files hold it.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "avatar/io/avatar_file.h"
#include "splat/base/files.h"
#include "tests/avatar/meshes.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_gaussians.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

class TrainedRangeFile : public testing::Test {
 protected:
  const test::TemporaryFolder folder_;
  const std::string path_ = folder_ / "avatar.glb";

  AvatarModel Avatar() const {
    AvatarModel model = test::RandomAvatar(test::SphereMesh(1, 0.1f), 3, 3);
    model.gaussians = test::RandomGaussians(3, 0, Basis::kSh, 4);
    model.trained_range = TrainedRange{{-1.1f, 0.1f}, {2.3f, 0.1f}, {0, 0.1f, 0.2f, 0.3f, 0.4f}};
    return model;
  }
  AvatarModel Written(const AvatarModel& model) const {
    WriteAvatarGlb(path_, model, nullptr);
    return ReadAvatarGlb(path_);
  }
  // With one text in the file's JSON replaced by another of the same length.
  void Change(const std::string& from, const std::string& to) const {
    const std::vector<char> bytes = ReadFile(path_);
    std::string text(bytes.begin(), bytes.end());
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    ASSERT_EQ(from.size(), to.size());
    WriteFileAtomically(path_, text.replace(at, from.size(), to));
  }
};

TEST_F(TrainedRangeFile, ComesBack) {
  const AvatarModel model = Avatar(), read = Written(model);
  ASSERT_TRUE(read.trained_range);
  EXPECT_EQ(read.trained_range->expression_least, model.trained_range->expression_least);
  EXPECT_EQ(read.trained_range->expression_most, model.trained_range->expression_most);
  EXPECT_EQ(read.trained_range->angle, model.trained_range->angle);
}

TEST_F(TrainedRangeFile, SaysFromWhereTheHeadWasFilmed) {
  AvatarModel model = Avatar();
  EXPECT_FALSE(Written(model).filmed);
  model.filmed = FilmedFrom{{-0.25f, 0.5f}, {0, 0.125f}, {}};
  EXPECT_FALSE(Written(model).filmed->guessed);
  EXPECT_NE(ToString(SummarizeGlb(path_)).find("from -14 to 29 degrees to its left, 0 to 7 up\n"),
            std::string::npos);
  model.filmed->guessed = 0.375f;
  const AvatarModel read = Written(model);
  ASSERT_TRUE(read.filmed);
  EXPECT_EQ(read.filmed->yaw, model.filmed->yaw);
  EXPECT_EQ(read.filmed->pitch, model.filmed->pitch);
  EXPECT_EQ(read.filmed->guessed, model.filmed->guessed);
  EXPECT_NE(ToString(SummarizeGlb(path_)).find("; 38 % of its surface"), std::string::npos);
  Change("\"guessed\":0.375", "\"guessed\":1.375");
  test::ExpectError([&] { ReadAvatarGlb(path_); }, {path_, "filmed.guessed", "share"});
  Written(model);
  Change("\"yaw\":[-0.25,", "\"yaw\":[ 0.75,");
  test::ExpectError([&] { ReadAvatarGlb(path_); }, {path_, "filmed.yaw", "range"});
}

TEST_F(TrainedRangeFile, FilesWithoutItHaveNone) {
  AvatarModel model = Avatar();
  model.trained_range.reset();
  EXPECT_FALSE(Written(model).trained_range);
}

TEST_F(TrainedRangeFile, BadOnesAreNotWritten) {
  const auto refused = [&](const std::function<void(TrainedRange&)>& spoil) {
    AvatarModel model = Avatar();
    spoil(*model.trained_range);
    test::ExpectError([&] { WriteAvatarGlb(path_, model, nullptr); }, {path_, "trained"});
  };
  refused([](TrainedRange& r) { r.expression_least[1] = NAN; });
  refused([](TrainedRange& r) { r.expression_most.pop_back(); });
  refused([](TrainedRange& r) { r.angle[3] = INFINITY; });
}

TEST_F(TrainedRangeFile, BadOnesAreErrorsThatNameTheField) {
  const auto refused = [&](const char* from, const char* to, const char* field) {
    Written(Avatar());
    Change(from, to);
    test::ExpectError([&] { ReadAvatarGlb(path_); }, {path_, field});
  };
  refused("\"angle\":[0.0,", "\"angel\":[0.0,", "trainedRange.angle");
  refused("\"angle\":[0.0,", "\"angle\":[    ", "trainedRange.angle");
  refused("\"expressionLeast\":[-", "\"expressionLeast\":[9", "trainedRange.expressionMost");
  refused("\"expressionMost\":[2", "\"expressionMost\":2[", "JSON");
}

}  // namespace
}  // namespace cosplat
