// Figures that cannot be right are not printed: of images that show nothing, of masks without a
// pixel, of no views.
#include <gtest/gtest.h>

#include "tests/integration/command.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

Image8 Stripes(int period) {
  Image8 image(16, 12, 3);
  for (size_t i = 0; i < image.data.size(); ++i) image.data[i] = uint8_t(i * 37 % period);
  return image;
}

// A run that is made of pairs of images.
class Figures : public testing::Test {
 protected:
  Figures() {
    WriteFile("run.json",
              Json{{"iterations", 60},
                   {"kind", "scene"},
                   {"source", "photos"},
                   {"degree", 3},
                   {"basis", "sh"},
                   {"seed", 0}}
                  .dump());
    WriteFile("point_cloud/iteration_60/point_cloud.ply", "");
    WriteFile("stats.json",
              Json{{"gaussians", 1},
                   {"iterations", 60},
                   {"seconds", 1},
                   {"ms_per_step", 1},
                   {"peak_mb", 1},
                   {"phases_ms", {{"blend", 1}}}}
                  .dump());
  }

  void WriteFile(const std::string& name, const std::string& bytes) const {
    fs::create_directories(fs::path(run_ + "/" + name).parent_path());
    std::ofstream(run_ + "/" + name, std::ios::binary) << bytes;
  }

  void Add(const Image8& rendered, const Image8& truth, const Image8& mask = {}) {
    const std::string name = "0000" + std::to_string(views_++) + ".png";
    const auto write = [&](const std::string& folder, const Image8& image) {
      fs::create_directories(test_ + folder);
      WriteImage(test_ + folder + "/" + name, image);
    };
    write("renders", rendered);
    write("gt", truth);
    if (!mask.empty()) write("masks", mask);
  }

  std::string Measured() const {
    const CommandResult result = Cosplat({"metrics", "-m", run_});
    EXPECT_EQ(result.code, 0) << result.err;
    return result.out;
  }

  Json Results() const { return ReadJson(run_ + "/results.json")["ours_60"]; }

  const TemporaryFolder folder_;
  const std::string run_ = folder_ / "run", test_ = run_ + "/test/ours_60/";
  int views_ = 0;
};

TEST_F(Figures, ImagesThatShowNothingAreInNoMean) {
  Add(Stripes(150), Stripes(220));
  Measured();
  const Json alone = Results();
  Image8 noisy(16, 12, 3, 250);
  noisy.data[7] = 246;
  Add(Image8(16, 12, 3, 255), Image8(16, 12, 3, 255));  // nothing on white
  Add(Image8(16, 12, 3, 3), Image8(16, 12, 3, 0));      // nearly nothing on black
  Add(Stripes(90), noisy);                              // one colour as JPEG keeps it
  EXPECT_TRUE(Contains(Measured(), "  (1 views; 3 of one colour are not measured)")) << Measured();
  EXPECT_EQ(Results(), alone);
  EXPECT_EQ(Cosplat({"report", "-m", run_, "--quiet"}).code, 0);
}

TEST_F(Figures, WithoutAnyContentThereIsNone) {
  for (const uint8_t black : {0, 1}) Add(Image8(16, 12, 3, black), Image8(16, 12, 3, 0));
  const std::string line = Measured();
  EXPECT_TRUE(Contains(line, "no figures") && Contains(line, "2 test images")) << line;
  EXPECT_FALSE(Contains(line, "dB")) << line;
  EXPECT_TRUE(Results().is_object() && Results().empty()) << Results();
  EXPECT_FALSE(Contains(Measured(), "dB")) << "measured again";
  EXPECT_EQ(Cosplat({"info", run_}).code, 0);
  const CommandResult report = Cosplat({"report", "-m", run_});
  EXPECT_EQ(report.code, 2);
  EXPECT_TRUE(Contains(report.err, "one colour")) << report.err;
}

TEST_F(Figures, MasksWithoutAPixelHaveNoFigure) {
  Add(Stripes(150), Stripes(220), Image8(16, 12, 1, 0));
  EXPECT_FALSE(Contains(Measured(), "inside the mask")) << Measured();
  EXPECT_EQ(Results().count("PSNR_mask"), 0u);
  Add(Stripes(150), Stripes(220), Image8(16, 12, 1, 255));
  EXPECT_TRUE(Contains(Measured(), "inside the mask"));
  EXPECT_NEAR(Results()["PSNR_mask"], Results()["PSNR"], 1e-3) << "the mean is of the second alone";
}

}  // namespace
}  // namespace cosplat::test
