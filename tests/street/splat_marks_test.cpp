// Marks of anti-aliased splats: every program's own is read, and ours are written so that others
// see them; the low-pass filter is the one that the splats were trained with.
#include <gtest/gtest.h>

#include "splat/base/compression.h"
#include "splat/base/json.h"
#include "splat/base/zip_archive.h"
#include "splat/config.h"
#include "tests/street/splat_fixture.h"

namespace cosplat {
namespace {

using namespace test;

Gaussians Scene(bool antialiased, float low_pass = kAntialiasedBlurVariance) {
  Gaussians g = RandomGaussians(40, 1, Basis::kSh, 3);
  g.antialiased = antialiased;
  g.low_pass_variance = low_pass;
  return g;
}

TEST(AntialiasedMarks, OfEveryProgramAreReadFromPly) {
  const TemporaryFolder folder;
  const struct {
    const char* comments;
    bool antialiased;
    float low_pass;
  } cases[] = {
      {"", false, 0},
      {"comment SplatRenderMode: mip\n", true, 0.3f},
      {"comment Exported from Brush\ncomment SplatRenderMode: mip\n", true, 0.1f},
      {"comment Exported from Brush\ncomment SplatRenderMode: default\n", false, 0},
      {"comment SPLATRENDERMODE:  MIP\n", true, 0.3f},
      {"comment SplatRenderMode: default\n", false, 0},
      {"comment SplatRenderMode: 2dgs\n", false, 0},
      {"comment antialiased 1\n", true, 0.3f},
      {"comment antialiased 0\n", false, 0},
      {"comment antialiased 1\ncomment SplatRenderMode: default\n", false, 0},  // the last counts
      {"comment SplatRenderMode: default\ncomment antialiased 1\n", true, 0.3f},
      {"comment not antialiased\n", false, 0},
      {"comment antialiased\n", true, 0.1f},  // ours, at first
      {"comment SplatRenderMode: mip\ncomment low_pass_variance 0.1\n", true, 0.1f}};
  for (const auto& c : cases) {
    const Gaussians read = ReadSplats(SavedPly(folder, Scene(false), {c.comments}));
    EXPECT_EQ(read.antialiased, c.antialiased) << c.comments;
    if (c.antialiased) {
      EXPECT_FLOAT_EQ(read.low_pass_variance, c.low_pass) << c.comments;
    }
  }
}

TEST(AntialiasedMarks, AreReadFromCompressedPly) {
  const TemporaryFolder folder;
  std::string header = "ply\nformat ascii 1.0\ncomment SplatRenderMode: mip\nelement chunk 1\n";
  for (const char* name : {"x", "y", "z", "scale_x", "scale_y", "scale_z"})
    for (const char* end : {"min_", "max_"})
      header += std::string("property float ") + end + name + "\n";
  header += "element vertex 1\n";
  for (const char* name : {"position", "rotation", "scale", "color"})
    header += std::string("property uint packed_") + name + "\n";
  WriteFileAtomically(folder / "a.ply",
                      header + "end_header\n0 1 0 1 0 1 0 1 0 1 0 1\n0 0 0 255\n");
  const Gaussians read = ReadSplats(folder / "a.ply");
  EXPECT_TRUE(read.antialiased);
  EXPECT_EQ(read.low_pass_variance, kBlurVariance);
}

TEST(AntialiasedMarks, KeepTheirFilterThroughEveryLayout) {
  const TemporaryFolder folder;
  for (const float low_pass : {kAntialiasedBlurVariance, kBlurVariance})
    for (const std::string& file : Exported(folder, Scene(true, low_pass))) {
      EXPECT_TRUE(ReadSplats(file).antialiased) << file;
      EXPECT_EQ(ReadSplats(file).low_pass_variance, low_pass) << file;
    }
  for (const std::string& file : Exported(folder, Scene(false)))
    EXPECT_FALSE(ReadSplats(file).antialiased) << file;
}

// What Brush, SplatTransform (hence SuperSplat) and Niantic's library look for.
TEST(AntialiasedMarks, AreWhereOtherProgramsLook) {
  const TemporaryFolder folder;
  for (const bool antialiased : {false, true}) {
    const Gaussians g = Scene(antialiased);
    Exported(folder, g);
    const std::string ply = BytesOf(folder / "ours.ply");
    EXPECT_EQ(ply.find("\ncomment SplatRenderMode: mip\n") != std::string::npos, antialiased);
    const ZipReader zip(folder / "ours.sog", "SOG");
    const std::vector<char> meta = zip.Read(zip.Find("meta.json"), 1 << 20);
    const Json json = Json::parse(meta);
    EXPECT_EQ(json.contains("model"), antialiased);
    if (antialiased) {
      EXPECT_EQ(json["model"], "antialiased");
    }
    EXPECT_EQ(FirstBytes(folder / "ours3.spz", 15)[14] & 1, int(antialiased));
    EXPECT_EQ(FirstBytes(folder / "ours4.spz", 15)[14] & 1, int(antialiased));
  }
}

TEST(AntialiasedMarks, OfOthersInSpzAndSogMeanTheirFilter) {
  const TemporaryFolder folder;
  WriteSpz(folder / "a.spz", Scene(true), {}, 4);
  std::string spz = BytesOf(folder / "a.spz");
  spz[14] = 1;
  WriteFileAtomically(folder / "a.spz", spz);
  EXPECT_EQ(ReadSplats(folder / "a.spz").low_pass_variance, kBlurVariance);

  const Gaussians g = Scene(true);
  WriteSog(folder / "meta.json", g, SizeSignificance(g), {});
  for (const char* key : {"model", "antialias"}) {
    Json meta = Json::parse(BytesOf(folder / "meta.json"));
    for (const char* mark : {"model", "antialias", "low_pass_variance"}) meta.erase(mark);
    meta[key] = key[0] == 'm' ? Json("antialiased") : Json(true);
    WriteFileAtomically(folder / "meta.json", meta.dump());
    const Gaussians read = ReadSplats(folder / "meta.json");
    EXPECT_TRUE(read.antialiased) << key;
    EXPECT_EQ(read.low_pass_variance, kBlurVariance) << key;
  }
}

// A Gaussian far smaller than a pixel keeps its light: a wider filter spreads the same.
TEST(AntialiasedMarks, TheFilterIsTheOneThatIsNamed) {
  Gaussians g = RandomGaussians(1, 0, Basis::kSh, 1);
  std::fill_n(g.at(kPosition, 0), 3, 0.0f);
  std::fill_n(g.at(kScaleLog, 0), 3, std::log(0.02f));
  *g.at(kOpacityLogit, 0) = 2;
  g.antialiased = true;
  const double sharp = std::pow(0.02 * 65 / 3, 2), opacity = 1 / (1 + std::exp(-2.0));
  for (const float low_pass : {kAntialiasedBlurVariance, kBlurVariance}) {
    g.low_pass_variance = low_pass;
    const Camera camera = LookingAt({0, 0, -3}, {0, 0, 0}, 65);  // a pixel's centre is the image's
    const double alpha = 1 - test::Image(g, camera).transmittance[32 * 65 + 32];
    EXPECT_NEAR(alpha, opacity * sharp / (sharp + low_pass), 1e-3) << low_pass;
  }
}

}  // namespace
}  // namespace cosplat
