// PlayCanvas' compressed splats: a packer of our own, its file read back, and what is wrong with
// it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "splat/base/files.h"
#include "splat/basis_constants.h"
#include "splat/config.h"
#include "splat/io/ply.h"
#include "tests/splat/ply_packer.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_gaussians.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

Gaussians ReadBack(const std::vector<Unpacked>& splats, const PackedLayout& options) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "a.ply", PackedFile(splats, options));
  return ReadPly(folder / "a.ply");
}

float Opacity(const Gaussians& g, size_t i) { return 1 / (1 + std::exp(-*g.at(kOpacityLogit, i))); }

// Each tolerance is half a step of the packing, and what a float leaves of it.
TEST(CompressedPly, ReadsBackWithinItsSteps) {
  const std::vector<Unpacked> splats = RandomSplats(2 * kChunk + 88);
  const Gaussians read = ReadBack(splats, {});
  ASSERT_EQ(read.size(), splats.size());
  EXPECT_EQ(read.degree, 0);
  EXPECT_EQ(read.basis, Basis::kSh);
  constexpr float kStep[3] = {1 / 2047.0f, 1 / 1023.0f, 1 / 2047.0f}, kRound = 0.501f;
  for (size_t i = 0; i < splats.size(); ++i) {
    const Unpacked& s = splats[i];
    const size_t begin = i / kChunk * kChunk;
    const Box p = ChunkBox(splats, begin, [](const Unpacked& u) { return u.position; });
    const Box l = ChunkBox(splats, begin, [](const Unpacked& u) { return u.scale_log; });
    const Box c = ChunkBox(splats, begin, [](const Unpacked& u) { return u.color; });
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(
          read.at(kPosition, i)[k], s.position[k], kRound * kStep[k] * (p.high[k] - p.low[k]));
      EXPECT_NEAR(
          read.at(kScaleLog, i)[k], s.scale_log[k], kRound * kStep[k] * (l.high[k] - l.low[k]));
      EXPECT_NEAR(0.5f + read.at(kColorDc, i)[k] * BasisConstants(Basis::kSh)[0],
                  s.color[k],
                  kRound / 255 * (c.high[k] - c.low[k]));
    }
    EXPECT_NEAR(Opacity(read, i), s.opacity, kRound / 255);
    float dot = 0, norm = 0;
    for (int k = 0; k < 4; ++k) {
      dot += read.at(kRotation, i)[k] * s.rotation[k];
      norm += read.at(kRotation, i)[k] * read.at(kRotation, i)[k];
    }
    EXPECT_NEAR(norm, 1, 1e-6f);
    // Three components within 0.5 sqrt2 / 1023, the largest within three times that.
    EXPECT_GT(std::abs(dot), 1 - 6 * std::pow(kRound * kSqrt2 / 1023, 2)) << i;
  }
}

// Bit by bit: a known value of each packing.
TEST(CompressedPly, KnownBits) {
  const TemporaryFolder folder;
  const uint32_t packed[4] = {2047u << 21 | 0u << 11 | 2047u,
                              2u << 30 | 1023u << 20 | 0u << 10 | 1023u,
                              0u << 21 | 1023u << 11 | 0u,
                              0xff003300u};
  const float bounds[12] = {1, 2, 3, 11, 12, 13, -4, -5, -6, 4, 5, 6};
  std::string bytes = PackedHeader(1, {.color_bounds = false});
  bytes.append(reinterpret_cast<const char*>(bounds), sizeof(bounds));
  bytes.append(reinterpret_cast<const char*>(packed), sizeof(packed));
  WriteFileAtomically(folder / "a.ply", bytes);
  const Gaussians g = ReadPly(folder / "a.ply");
  EXPECT_EQ(g.values[kPosition], (Buffer<float>{11, 2, 13}));
  EXPECT_EQ(g.values[kScaleLog], (Buffer<float>{-4, 5, -6}));
  // w, x and z are at their ends, which leaves nothing for y, the largest.
  const float end = kSqrt2 / 2;
  EXPECT_NEAR(g.at(kRotation, 0)[0], end, 1e-6);
  EXPECT_NEAR(g.at(kRotation, 0)[1], -end, 1e-6);
  EXPECT_EQ(g.at(kRotation, 0)[2], 0);
  EXPECT_NEAR(g.at(kRotation, 0)[3], end, 1e-6);
  const float k0 = BasisConstants(Basis::kSh)[0];
  EXPECT_NEAR(g.at(kColorDc, 0)[0], 0.5f / k0, 1e-6);
  EXPECT_NEAR(g.at(kColorDc, 0)[1], -0.5f / k0, 1e-6);
  EXPECT_NEAR(g.at(kColorDc, 0)[2], -0.3f / k0, 1e-6);
  EXPECT_TRUE(IsCompressedPly(folder / "a.ply"));
}

TEST(CompressedPly, ReadsColorBandsByChannel) {
  for (int degree = 1; degree <= 3; ++degree) {
    const int coefficients = CoefficientCount(degree) - 1;
    const std::vector<Unpacked> splats = RandomSplats(7);
    const Gaussians read = ReadBack(splats, {.rest = 3 * coefficients});
    ASSERT_EQ(read.degree, degree);
    for (size_t i = 0; i < splats.size(); ++i)
      for (int k = 0; k < coefficients; ++k)
        for (int c = 0; c < 3; ++c) {
          const int byte = int(i * 3 * coefficients + c * coefficients + k) % 256;
          const float expected = byte == 0 ? -4 : byte == 255 ? 4 : (float(byte) + 0.5f) / 32 - 4;
          EXPECT_FLOAT_EQ(read.at(kColorRest, i)[3 * k + c], expected);
        }
  }
}

TEST(CompressedPly, OpacitiesAtTheEndsAreFinite) {
  std::vector<Unpacked> splats = RandomSplats(3);
  splats[0].opacity = 0;
  splats[1].opacity = 1;
  const Gaussians read = ReadBack(splats, {});
  for (size_t i = 0; i < read.size(); ++i) EXPECT_TRUE(std::isfinite(*read.at(kOpacityLogit, i)));
  EXPECT_LT(Opacity(read, 0), kMinAlpha);
  EXPECT_GT(Opacity(read, 1), kMaxAlpha);
}

TEST(CompressedPly, NoSplats) { EXPECT_EQ(ReadBack({}, {}).size(), 0u); }

TEST(CompressedPly, OtherFilesAreNot) {
  const TemporaryFolder folder;
  WritePly(folder / "a.ply", RandomGaussians(2, 1, Basis::kSh, 1));
  EXPECT_FALSE(IsCompressedPly(folder / "a.ply"));
}

TEST(CompressedPly, CutFilesAreRefused) {
  const TemporaryFolder folder;
  const PackedLayout options{.rest = 9};
  const std::string whole = PackedFile(RandomSplats(3), options);
  const size_t header = PackedHeader(3, options).size();
  const auto cut_at = [&](size_t bytes) {
    WriteFileAtomically(folder / "cut.ply", whole.substr(0, bytes));
    return [&] { ReadPly(folder / "cut.ply"); };
  };
  for (size_t bytes = 0; bytes < whole.size(); bytes += 7) ExpectError(cut_at(bytes), {"cut.ply"});
  constexpr size_t kChunkBytes = 18 * 4, kVertexBytes = 4 * 4;
  ExpectError(cut_at(header + 30), {"cut.ply", "chunk 0", "at min_scale_y", "expected 1"});
  ExpectError(cut_at(header + kChunkBytes + kVertexBytes + 6),
              {"cut.ply", "vertex 1", "packed_rotation", "expected 3"});
  ExpectError(cut_at(header + kChunkBytes + 3 * kVertexBytes + 9 * 3 - 1),
              {"cut.ply", "sh 2", "at f_rest_8", "expected 3"});
}

TEST(CompressedPly, BadHeadersSayWhatIsWrong) {
  const TemporaryFolder folder;
  const std::string whole = PackedFile(RandomSplats(3), {.rest = 9});
  const struct {
    const char *from, *to;
    std::vector<std::string> parts;
  } cases[] = {{"element chunk 1", "element chunk 9999999999", {"chunk", "9999999999"}},
               {"element chunk 1", "element chunk 0", {"vertex", "3 rows", "need 1 chunks, not 0"}},
               {"element chunk", "element chunks", {"no element chunk"}},
               {"element vertex 3", "element vertex 9999999999", {"vertex", "9999999999"}},
               {"element sh 3", "element sh 2", {"sh", "2 rows", "3 vertices"}},
               {"float min_scale_y", "float minscale_y", {"chunk", "no property min_scale_y"}},
               {"float max_b", "float max_c", {"chunk", "no property max_b"}},
               {"uint packed_rotation", "uint rotation", {"vertex", "no property packed_rotation"}},
               {"uchar f_rest_8", "uchar g_rest_8", {"sh", "8 properties f_rest_*"}},
               {"uchar f_rest_8", "uchar f_rest_9", {"sh", "no property f_rest_8"}}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.to);
    std::string changed = whole;
    changed.replace(changed.find(c.from), std::string(c.from).size(), c.to);
    WriteFileAtomically(folder / "bad.ply", changed);
    std::vector<std::string> parts = c.parts;
    parts.push_back("bad.ply");
    ExpectError([&] { ReadPly(folder / "bad.ply"); }, parts);
  }
}

TEST(CompressedPly, BadValuesNameRowAndProperty) {
  const TemporaryFolder folder;
  const std::string whole = PackedFile(RandomSplats(kChunk + 1), {});
  const size_t second_chunk = PackedHeader(kChunk + 1, {}).size() + 18 * 4;
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), -INFINITY}) {
    std::string changed = whole;
    changed.replace(second_chunk + 4 * 10, 4, reinterpret_cast<const char*>(&bad), 4);
    WriteFileAtomically(folder / "bad.ply", changed);
    ExpectError([&] { ReadPly(folder / "bad.ply"); },
                {"bad.ply", "chunk 1, max_scale_y", "not finite"});
  }
  const float large = 3e38f;  // finite, but not as a coefficient
  std::string colourful = whole;
  colourful.replace(second_chunk + 4 * 12, 4, reinterpret_cast<const char*>(&large), 4);
  WriteFileAtomically(folder / "bad.ply", colourful);
  ExpectError([&] { ReadPly(folder / "bad.ply"); }, {"bad.ply", "chunk", "bound of colours"});
  std::string ascii = PackedHeader(1, {.color_bounds = false});
  ascii.replace(ascii.find("binary_little_endian"), 20, "ascii");
  for (const std::string bad : {"-1", "0.5", "4294967296", "nan"}) {
    WriteFileAtomically(folder / "bad.ply",
                        ascii + "0 0 0 1 1 1 0 0 0 1 1 1\n4294967295 0 " + bad + " 0\n");
    ExpectError([&] { ReadPly(folder / "bad.ply"); },
                {"bad.ply", "vertex 0, packed_scale", bad.substr(0, 3)});
  }
}

TEST(CompressedPly, Biker) {
  const std::string path = COSPLAT_SOURCE_DIR "/../shared/data/splats/biker.compressed.ply";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "biker.compressed.ply is not here";
  const Gaussians g = ReadPly(path);
  EXPECT_EQ(g.size(), 152746u);
  EXPECT_EQ(g.degree, 0);
  for (int a = 0; a < kAttributeCount; ++a)
    EXPECT_TRUE(std::all_of(
        g.values[a].begin(), g.values[a].end(), [](float x) { return std::isfinite(x); }));
}

}  // namespace
}  // namespace cosplat::test
