#include "splat/io/vq_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>

#include "splat/base/files.h"
#include "splat/base/npz.h"
#include "splat/io/ply.h"
#include "splat/io/splat_file.h"
#include "splat/io/vq.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_gaussians.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::TemporaryFolder;

// Of degree 2; every third splat of degree 1.
QuantisedSplats Splats(size_t count) {
  Gaussians g = test::RandomGaussians(count, 2, Basis::kSh, 6);
  for (size_t i = 0; i < count; i += 3)
    for (int k = 9; k < 24; ++k) g.at(kColorRest, i)[k] = 0;
  return Quantise(g, SizeSignificance(g), {32, 0.4, 0});
}

std::string Bytes(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  return {bytes.begin(), bytes.end()};
}

// Of numbers that 16 bits hold: a splat of degree 1 that is kept, one of degree 0, which has no
// bands, and two of degree 1 that are quantised.
QuantisedSplats GoldenSplats() {
  const auto numbers = [](size_t count) {
    std::vector<float> values(count);
    for (size_t i = 0; i < count; ++i) values[i] = 0.0625f * float(i + 1);
    return values;
  };
  QuantisedSplats s;
  s.degree = 2;
  s.position = numbers(12);
  s.rotation = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.5f, 0.5f, 0.5f, 0.5f};
  s.scale_log = numbers(12);
  s.opacity_logit = {-2, 0, 0.5f, 3};
  s.color_dc = numbers(12);
  s.own_degree = {1, 0, 1, 1};
  s.quantised = {0, 0, 1, 1};
  s.bands[1] = {numbers(9), {1, 0}, numbers(18)};
  s.more.Add("face", {2}, std::vector<int32_t>{7, -1});
  return s;
}

// tests/golden/splats_v1.zip pins version 1 of the format. When the format changes on purpose, keep
// it (old files must still be read), add splats_v2.zip beside it, and write that one by running
//   COSPLAT_WRITE_GOLDEN=1 cosplat_test_vq --gtest_filter=*Golden*
// Its numbers are compared, not its bytes: releases of zlib deflate differently.
TEST(VqFile, GoldenNumbers) {
  const std::string golden = std::string(COSPLAT_SOURCE_DIR) + "/tests/golden/splats_v1.zip";
  const QuantisedSplats splats = GoldenSplats();
  if (std::getenv("COSPLAT_WRITE_GOLDEN")) WriteVqFile(golden, splats);
  ASSERT_TRUE(IsVqFile(golden));
  const TemporaryFolder folder;
  WriteVqFile(folder / "a.zip", splats);
  const Npz written = Npz::Read(folder / "a.zip"), pinned = Npz::Read(golden);
  EXPECT_EQ(written.Text("splats.json"), pinned.Text("splats.json"));
  ASSERT_EQ(written.arrays().size(), pinned.arrays().size());
  for (const auto& [name, array] : written.arrays()) {
    EXPECT_EQ(pinned.Get(name).dtype, array.dtype) << name;
    EXPECT_EQ(pinned.Get(name).shape, array.shape) << name;
    EXPECT_EQ(pinned.Get(name).values, array.values) << name;
  }
  const QuantisedSplats read = ReadVqFile(golden);
  EXPECT_EQ(read.position, splats.position);
  EXPECT_EQ(read.rotation, splats.rotation);
  EXPECT_EQ(read.color_dc, splats.color_dc);
  EXPECT_EQ(read.bands[1].codebook, splats.bands[1].codebook);
  const Gaussians g = ReadSplats(golden);
  EXPECT_EQ(g.degrees, splats.own_degree);
  EXPECT_EQ(g.at(kColorDc, 1)[2], splats.color_dc[5]);
  EXPECT_EQ(g.at(kColorRest, 2)[0], splats.bands[1].codebook[9]);  // row 1
  EXPECT_EQ(g.at(kColorRest, 3)[8], splats.bands[1].codebook[8]);
}

// docs/vq-file.md, member by member.
TEST(VqFile, HasTheMembersThatAreDocumented) {
  const TemporaryFolder folder;
  WriteVqFile(folder / "a.zip", Splats(300));
  const Npz npz = Npz::Read(folder / "a.zip");
  EXPECT_EQ(npz.Text("splats.json"),
            "{\"basis\":\"sh\",\"count\":300,\"degree\":2,\"kind\":\"scene\","
            "\"layout\":\"cosplat-splats\",\"version\":1}\n");
  const struct {
    const char *name, *dtype;
    std::vector<long> shape;
  } members[] = {{"position", "<f4", {300, 3}},
                 {"rotation", "<f2", {300, 4}},
                 {"scale_log", "<f2", {300, 3}},
                 {"opacity_logit", "<f2", {300}},
                 {"color_dc", "<f2", {300, 3}},
                 {"degree", "|u1", {300}},
                 {"quantised", "|u1", {300}},
                 {"kept_1", "<f2", {-1, 3, 3}},
                 {"index_1", "<u2", {-1}},
                 {"codebook_1", "<f2", {-1, 3, 3}},
                 {"kept_2", "<f2", {-1, 8, 3}},
                 {"index_2", "<u2", {-1}},
                 {"codebook_2", "<f2", {31, 8, 3}}};
  EXPECT_EQ(npz.arrays().size(), std::size(members));
  for (const auto& member : members)
    EXPECT_EQ(npz.Get(member.name, member.shape).dtype, member.dtype) << member.name;
  EXPECT_EQ(npz.Get("kept_1").shape[0] + npz.Get("kept_2").shape[0], 120u);
  EXPECT_EQ(npz.Get("index_1").shape[0] + npz.Get("index_2").shape[0], 180u);
}

TEST(VqFile, ReadsBackWhatSixteenBitsHold) {
  const TemporaryFolder folder;
  const QuantisedSplats written = Splats(300);
  WriteVqFile(folder / "a.zip", written);
  const QuantisedSplats read = ReadVqFile(folder / "a.zip");
  EXPECT_EQ(read.degree, 2);
  EXPECT_EQ(read.position, written.position);
  EXPECT_EQ(read.own_degree, written.own_degree);
  EXPECT_EQ(read.quantised, written.quantised);
  const auto expect_half = [](const std::vector<float>& a, const std::vector<float>& b) {
    ASSERT_EQ(a.size(), b.size());
    // Half a unit in the last of 11 places; what is below 2^-14 has fewer.
    for (size_t i = 0; i < a.size(); ++i)
      EXPECT_NEAR(a[i], b[i], std::max(0x1p-11f * std::abs(b[i]), 0x1p-25f));
  };
  expect_half(read.rotation, written.rotation);
  expect_half(read.scale_log, written.scale_log);
  expect_half(read.opacity_logit, written.opacity_logit);
  expect_half(read.color_dc, written.color_dc);
  for (int degree = 0; degree <= kMaxTrainedDegree; ++degree) {
    EXPECT_EQ(read.bands[degree].index, written.bands[degree].index);
    expect_half(read.bands[degree].kept, written.bands[degree].kept);
    expect_half(read.bands[degree].codebook, written.bands[degree].codebook);
  }
  WriteVqFile(folder / "b.zip", read);
  EXPECT_EQ(Bytes(folder / "a.zip"), Bytes(folder / "b.zip"));
}

// What 16 bits and the codebook make of an image, apart.
TEST(VqFile, KeepsTheImage) {
  const TemporaryFolder folder;
  Camera camera;
  camera.width = camera.height = 64;
  camera.fx = camera.fy = 60;
  camera.cx = camera.cy = 32;
  camera.translation = {0, 0, 3};
  for (int degree = 0; degree <= kMaxTrainedDegree; ++degree) {
    const Gaussians g = test::RandomGaussians(400, degree, Basis::kSh, 8);
    WriteVqFile(folder / "a.zip", Quantise(g, SizeSignificance(g), {8192, 1, 0}));
    const Gaussians read = ReadSplats(folder / "a.zip");
    EXPECT_EQ(read.degree, degree);
    // Measured 0.4 of 255 grey levels.
    EXPECT_LT(test::LargestDifference(test::Image(read, camera), test::Image(g, camera)),
              1.0f / 255);
  }
}

TEST(VqFile, IsOfTheDocumentedSize) {
  const TemporaryFolder folder;
  const Gaussians g = test::RandomGaussians(4000, 3, Basis::kSh, 9);
  WriteVqFile(folder / "a.zip", Quantise(g, SizeSignificance(g), {128, 0.4, 0}));
  // Position 12 bytes, rotation, scale and opacity 16, constant colour 6, own bands 90, index,
  // degree, flag 4.
  EXPECT_LT(std::filesystem::file_size(folder / "a.zip"),
            size_t(4000 * (12 + 16 + 6 + 0.4 * 90 + 4) + 128 * 90 + 4096));
}

TEST(VqFile, IsToldByItsFirstBytes) {
  const TemporaryFolder folder;
  WriteVqFile(folder / "named.ply", Splats(20));
  EXPECT_TRUE(IsVqFile(folder / "named.ply"));
  EXPECT_EQ(ReadSplats(folder / "named.ply").size(), 20u);
  WritePly(folder / "named.zip", test::RandomGaussians(7, 1, Basis::kSh, 1));
  EXPECT_FALSE(IsVqFile(folder / "named.zip"));
  EXPECT_EQ(ReadSplats(folder / "named.zip").size(), 7u);
  Npz other;
  other.Add("v_template", {1}, std::vector<float>{1});
  other.Write(folder / "other.npz");
  EXPECT_FALSE(IsVqFile(folder / "other.npz"));
  EXPECT_FALSE(IsVqFile(folder / "none.zip"));
}

// What another kind of splats needs beside its positions.
TEST(VqFile, KeepsFurtherArraysAsTheyAre) {
  const TemporaryFolder folder;
  QuantisedSplats splats = Splats(20);
  splats.kind = "thing";
  splats.more.Add("face", {20}, std::vector<int32_t>(20, 100000000));
  WriteVqFile(folder / "a.zip", splats);
  const QuantisedSplats read = ReadVqFile(folder / "a.zip");
  EXPECT_EQ(read.kind, "thing");
  EXPECT_EQ(read.more.arrays().size(), 1u);
  EXPECT_EQ(read.more.Get("face", {20}).values[19], 100000000);
  ExpectError([&] { ReadSplats(folder / "a.zip"); }, {"a.zip", "kind", "'thing'", "'scene'"});
}

TEST(VqFile, WritesNothingThatDoesNotFit) {
  const TemporaryFolder folder;
  QuantisedSplats splats = Splats(5);
  splats.scale_log[4] = 70000;
  ExpectError([&] { WriteVqFile(folder / "a.zip", splats); },
              {"a.zip", "scale_log", "number 4", "70000"});
  splats = Splats(5);
  splats.position[7] = NAN;
  ExpectError([&] { WriteVqFile(folder / "a.zip", splats); },
              {"a.zip", "position", "number 7", "not finite"});
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(VqFile, CutFilesAreErrors) {
  const TemporaryFolder folder;
  WriteVqFile(folder / "a.zip", Splats(50));
  const std::string whole = Bytes(folder / "a.zip");
  for (size_t cut = 41; cut < whole.size(); cut += 97) {
    WriteFileAtomically(folder / "cut.zip", whole.substr(0, cut));
    ExpectError([&] { ReadSplats(folder / "cut.zip"); }, {"cut.zip"});
  }
  for (size_t at = 60; at < whole.size(); at += 61) {
    std::string changed = whole;
    changed[at] ^= 0x40;
    WriteFileAtomically(folder / "cut.zip", changed);
    try {
      ReadSplats(folder / "cut.zip");  // what no checksum covers may pass
    } catch (const Error& e) {
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    }
  }
}

TEST(VqFile, BadMembersAreNamed) {
  const TemporaryFolder folder;
  WriteVqFile(folder / "a.zip", Splats(60));
  const auto expect = [&](const std::function<void(Npz&)>& change, std::vector<std::string> parts) {
    Npz npz = Npz::Read(folder / "a.zip");
    change(npz);
    npz.Write(folder / "bad.zip");
    parts.push_back("bad.zip");
    ExpectError([&] { ReadVqFile(folder / "bad.zip"); }, parts);
  };
  const auto header = [](const std::string& text) {
    return [text](Npz& npz) { npz.AddText("splats.json", text); };
  };
  const std::string rest = "\"count\": 60, \"degree\": 2, \"kind\": \"scene\"}";
  expect(header("{"), {"splats.json", "not JSON"});
  expect(header("[]"), {"splats.json", "layout"});
  expect(header("{\"layout\": \"x\"}"), {"splats.json", "layout", "'x'", "cosplat-splats"});
  const std::string ours = "{\"layout\": \"cosplat-splats\", ";
  expect(header(ours + "\"version\": 2, " + rest), {"splats.json", "version is 2"});
  expect(header(ours + "\"version\": 1, \"count\": 60, \"degree\": 5}"), {"degree is 5"});
  expect(header(ours + "\"version\": 1, \"count\": -1, \"degree\": 2}"), {"count is -1"});
  expect(header(ours + "\"version\": 1, \"count\": 61, \"degree\": 2, \"kind\": \"scene\"}"),
         {"position", "[60, 3]", "[61, 3]"});
  expect(header(ours + "\"version\": 1, \"count\": 60, \"degree\": 1, \"kind\": \"scene\"}"),
         {"degree", "is 2", "0 to 1"});
  const auto set = [](const std::string& name, size_t at, double value) {
    return [=](Npz& npz) {
      std::vector<float> values(npz.Get(name).values.begin(), npz.Get(name).values.end());
      values[at] = float(value);
      npz.Add(name, npz.Get(name).shape, values);
    };
  };
  expect(set("position", 5, NAN), {"position", "number 5", "not finite"});
  expect(set("rotation", 9, INFINITY), {"rotation", "number 9", "not finite"});
  expect(set("codebook_2", 30, NAN), {"codebook_2", "number 30", "not finite"});
  expect(set("kept_1", 2, NAN), {"kept_1", "number 2", "not finite"});
  expect(set("index_2", 3, 9000), {"index_2", "number 3", "9000", "codebook_2"});
  expect(set("index_2", 3, 0.5), {"index_2", "number 3", "0.5"});
  expect(set("index_2", 3, NAN), {"index_2", "number 3"});
  expect(set("quantised", 4, 2), {"quantised", "number 4", "2", "0 or 1"});
  const auto shape = [](const std::string& name, std::vector<size_t> extents) {
    return [=](Npz& npz) {
      size_t count = 1;
      for (const size_t extent : extents) count *= extent;
      npz.Add(name, extents, std::vector<float>(count, 0.0f));
    };
  };
  expect(shape("opacity_logit", {60, 1}), {"opacity_logit", "[60, 1]", "[60]"});
  expect(shape("codebook_2", {0, 8, 3}), {"index_2", "the 0 of codebook_2"});
  expect(shape("kept_2", {1, 8, 3}), {"kept_2", "[1, 8, 3]"});
  Npz empty;
  empty.AddText("splats.json",
                ours + "\"version\": 1, \"count\": 0, \"degree\": 0, \"kind\": \"scene\"}");
  empty.Write(folder / "bad.zip");
  ExpectError([&] { ReadSplats(folder / "bad.zip"); }, {"bad.zip", "position", "missing"});
}

}  // namespace
}  // namespace cosplat
