// Layouts of splat files are told apart; .splat and .glb are read.
#include "splat/io/splat_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "splat/base/files.h"
#include "splat/base/zip_archive.h"
#include "splat/io/color_weights.h"
#include "splat/io/ply.h"
#include "splat/io/sog.h"
#include "splat/io/splat_records.h"
#include "splat/io/spz.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_gaussians.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::TemporaryFolder;

TEST(SplatFiles, SayWhetherTheirGaussiansAreAntialiased) {
  const TemporaryFolder folder;
  for (const bool antialiased : {false, true}) {
    Gaussians g = test::RandomGaussians(40, 1, Basis::kSh, 3);
    g.antialiased = antialiased;
    WritePly(folder / "a.ply", g);
    WriteSpz(folder / "a.spz", g, {}, 3);
    WriteSpz(folder / "b.spz", g, {}, 4);
    WriteSog(folder / "a.sog", g, SizeSignificance(g), {});
    WriteSceneGlb(folder / "a.glb", g);
    for (const char* name : {"a.ply", "a.spz", "b.spz", "a.sog", "a.glb"})
      EXPECT_EQ(ReadSplats(folder / name).antialiased, antialiased) << name;
  }
  Gaussians g = test::RandomGaussians(2, 0, Basis::kSh, 3);
  g.smoothing = {0.1f, 0.2f};
  ExpectError([&] { WritePly(folder / "b.ply", g); }, {"b.ply", "smoothing"});
}

struct Record {
  float position[3]{1, 2, 3};
  float scale[3]{0.5f, 1, 2};
  uint8_t color[4]{0, 128, 255, 64};
  uint8_t rotation[4]{255, 128, 128, 128};
};

std::string BytesOf(const Record& record) {
  return {reinterpret_cast<const char*>(&record), sizeof(record)};
}

TEST(SplatRecords, KnownBytes) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "a.splat", BytesOf({}) + BytesOf({}));
  const Gaussians g = ReadSplats(folder / "a.splat");
  ASSERT_EQ(g.size(), 2u);
  EXPECT_EQ(g.degree, 0);
  EXPECT_EQ(g.basis, Basis::kSh);
  EXPECT_EQ(g.at(kPosition, 1)[2], 3);
  EXPECT_NEAR(g.at(kScaleLog, 0)[0], std::log(0.5), 1e-6);
  EXPECT_NEAR(1 / (1 + std::exp(-*g.at(kOpacityLogit, 0))), 64 / 255.0, 1e-6);
  EXPECT_NEAR(0.28209479 * g.at(kColorDc, 0)[2] + 0.5, 1, 1e-6);
  EXPECT_EQ(g.at(kRotation, 0)[0], 1);
}

TEST(SplatRecords, BadFilesNameTheRecord) {
  const TemporaryFolder folder;
  const auto refuse = [&](const std::string& bytes, const std::vector<std::string>& parts) {
    WriteFileAtomically(folder / "bad.splat", bytes);
    ExpectError([&] { ReadSplats(folder / "bad.splat"); }, parts);
  };
  refuse("", {"bad.splat", "is empty"});
  refuse(BytesOf({}).substr(1), {"bad.splat", "31 bytes", "32"});
  Record record;
  record.position[1] = NAN;
  refuse(BytesOf({}) + BytesOf(record), {"record 1, position", "nan"});
  record = {};
  record.scale[2] = -1;
  refuse(BytesOf(record), {"record 0, scale", "-1"});
}

TEST(SplatFile, LayoutsAreToldByTheirFirstBytes) {
  const TemporaryFolder folder;
  const Gaussians g = test::RandomGaussians(20, 2, Basis::kSh, 1);
  WritePly(folder / "a", g);
  WriteSpz(folder / "b", g, {});
  WriteSpz(folder / "c", g, {}, 4);
  WriteSceneGlb(folder / "d", g);
  EXPECT_EQ(SplatLayoutOf(folder / "a"), SplatLayout::kPly);
  EXPECT_EQ(SplatLayoutOf(folder / "b"), SplatLayout::kSpz);
  EXPECT_EQ(SplatLayoutOf(folder / "c"), SplatLayout::kSpz);
  EXPECT_EQ(SplatLayoutOf(folder / "d"), SplatLayout::kGlb);
  EXPECT_EQ(SplatLayoutOf(folder / "none"), SplatLayout::kNone);
  WriteFileAtomically(folder / "e", "text");
  ExpectError([&] { ReadSplats(folder / "e"); }, {"/e", "is not a splat file"});
  WriteZip(folder / "f", {{"splats.json", "{}"}});
  ExpectError([&] { ReadSplats(folder / "f"); }, {"/f", "quantised splats of CoSplat 0.1 and 0.2"});
  ExpectError([&] { ReadSplats(folder / "none"); }, {"/none", "No such file"});
}

// What a scene's .glb holds: degree 3, all else within a float's rounding.
TEST(SplatFile, GlbReadsBack) {
  const TemporaryFolder folder;
  for (int degree = 0; degree <= 3; ++degree) {
    const Gaussians g = test::RandomGaussians(20, degree, Basis::kSh, 2);
    WriteSceneGlb(folder / "a.glb", g);
    const Gaussians read = ReadSplats(folder / "a.glb");
    ASSERT_EQ(read.size(), g.size());
    EXPECT_EQ(read.degree, degree);
    EXPECT_EQ(read.values[kPosition], g.values[kPosition]);
    EXPECT_EQ(read.values[kColorRest], g.values[kColorRest]);
    for (size_t i = 0; i < g.values[kScaleLog].size(); ++i)
      EXPECT_NEAR(read.values[kScaleLog][i], g.values[kScaleLog][i], 1e-6f);
    for (size_t i = 0; i < g.size(); ++i)
      EXPECT_NEAR(*read.at(kOpacityLogit, i), *g.at(kOpacityLogit, i), 1e-5f);
  }
}

TEST(SplatFile, TruncateDegreeDropsBands) {
  Gaussians g = test::RandomGaussians(5, 4, Basis::kSh, 3);
  const Gaussians whole = g;
  TruncateDegree(2, g);
  EXPECT_EQ(g.degree, 2);
  ASSERT_EQ(g.values[kColorRest].size(), 5u * 24);
  for (size_t i = 0; i < 5; ++i)
    for (int k = 0; k < 24; ++k) EXPECT_EQ(g.at(kColorRest, i)[k], whole.at(kColorRest, i)[k]);
  TruncateDegree(3, g);
  EXPECT_EQ(g.degree, 2);
}

}  // namespace
}  // namespace cosplat
