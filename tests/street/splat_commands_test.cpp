// What the commands say of odd splat files.
#include <gtest/gtest.h>

#include "splat/base/compression.h"
#include "tests/integration/command.h"
#include "tests/street/splat_fixture.h"

namespace cosplat {
namespace {

using namespace test;

TEST(SplatCommands, SayWhatWasLeftOut) {
  const TemporaryFolder folder;
  Gaussians g = RandomGaussians(40, 1, Basis::kSh, 5);
  for (size_t i = 0; i < 10; ++i) std::fill_n(g.at(kRotation, i), 4, 0.0f);
  *g.at(kOpacityLogit, 20) = INFINITY;
  const std::string file = folder / "THEIRS.PLY.GZ";
  WriteFileAtomically(file, Gzip(PlyBytes(ColumnsOfPly(g), {"comment SplatRenderMode: mip\n"})));
  const CommandResult info = Cosplat({"info", file});
  EXPECT_EQ(info.code, 0) << info.err;
  EXPECT_NE(info.err.find(file + ": 10 of 40 splats cannot be drawn"), std::string::npos)
      << info.err;
  EXPECT_NE(info.err.find("1 opacities are infinite"), std::string::npos) << info.err;
  EXPECT_NE(info.out.find("30 Gaussians"), std::string::npos) << info.out;
  EXPECT_NE(info.out.find("low-pass filter of 0.3 px^2"), std::string::npos) << info.out;
  const CommandResult made =
      Cosplat({"export", "--splats", file, "--spz", folder / "a.spz", "--ply", folder / "a.ply"});
  EXPECT_EQ(made.code, 0) << made.err;
  EXPECT_NE(made.err.find("10 of 40 splats cannot be drawn"), std::string::npos) << made.err;
  for (const char* name : {"a.spz", "a.ply"}) {
    const Gaussians read = ReadSplats(folder / name);
    EXPECT_EQ(read.size(), 30u);
    EXPECT_EQ(read.low_pass_variance, kBlurVariance);
  }
}

}  // namespace
}  // namespace cosplat
