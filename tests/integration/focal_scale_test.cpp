// `train-avatar --focal-scale`: the run keeps its cameras, and what reads it uses them.
#include <gtest/gtest.h>

#include "tests/integration/command.h"

namespace cosplat::test {
namespace {

TEST(Cli, AnotherFocalLengthIsTheRuns) {
  const Workshop& made = Workshop::Get();
  const TemporaryFolder folder;
  // The made head's camera moves. Here it stands still, whatever the images show.
  const std::string head = folder / "head", run = folder / "run";
  std::filesystem::copy(made.head, head, std::filesystem::copy_options::recursive);
  Json track = ReadJson(head + "/flame_params.json");
  for (Json& frame : track["frames"]) frame["world_mat"] = track["frames"][0]["world_mat"];
  std::ofstream(head + "/flame_params.json") << track.dump();
  const auto train = [&](const std::string& out, const std::string& scale) {
    return Cosplat({"train-avatar",
                    "--config",
                    made.avatar + "/config.ini",
                    "-s",
                    head,
                    "-m",
                    out,
                    "--iterations",
                    "20",
                    "--focal-scale",
                    scale});
  };
  const CommandResult trained = train(run, "0.5");
  ASSERT_EQ(trained.code, 0) << trained.err;
  const Json cameras = ReadJson(run + "/cameras.json");
  const std::string plain = folder / "plain";
  ASSERT_EQ(train(plain, "1").code, 0);
  const Json own = ReadJson(plain + "/cameras.json");
  ASSERT_EQ(cameras.size(), own.size());
  EXPECT_FLOAT_EQ(cameras[0]["fx"], 0.5f * float(own[0]["fx"]));
  // Rendered again from the data, the test frames are those of the training.
  const std::string image = run + "/test/ours_20/renders/00000.png";
  const std::string before = Slurp(image);
  std::filesystem::remove(image);
  ASSERT_EQ(Cosplat({"render", "-m", run, "--quiet"}).code, 0);
  EXPECT_EQ(Slurp(image), before);
  // A run of an earlier version does not say what it is.
  Json json = ReadJson(plain + "/run.json");
  EXPECT_EQ(json["split"]["focal_scale"], 1);
  json["split"].erase("focal_scale");
  std::ofstream(plain + "/run.json") << json.dump();
  const std::string plain_image = plain + "/test/ours_20/renders/00000.png";
  const std::string shown = Slurp(plain_image);
  EXPECT_NE(shown, before);
  ASSERT_EQ(Cosplat({"render", "-m", plain, "--quiet"}).code, 0);
  EXPECT_EQ(Slurp(plain_image), shown);
  // The made head itself.
  const CommandResult refused = Cosplat({"train-avatar",
                                         "--config",
                                         made.avatar + "/config.ini",
                                         "-m",
                                         folder / "no",
                                         "--focal-scale",
                                         "0.5"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("--focal-scale: is for one camera"), std::string::npos) << refused.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "no"));
}

}  // namespace
}  // namespace cosplat::test
