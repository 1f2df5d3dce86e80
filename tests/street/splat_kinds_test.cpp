// Splat files that differ from the usual: packed, named or written otherwise, of other methods, and
// what is no splat file at all.
#include <gtest/gtest.h>

#include <algorithm>

#include "splat/base/compression.h"
#include "splat/base/json.h"
#include "tests/street/splat_fixture.h"
#include "tests/support/expect_error.h"
#include "tests/support/glb_bytes.h"

namespace cosplat {
namespace {

using namespace test;

class SplatKinds : public testing::Test {
 protected:
  std::string Saved(const std::string& name, const std::string& bytes) {
    WriteFileAtomically(folder_ / name, bytes);
    return folder_ / name;
  }
  std::string Saved(const std::string& name,
                    const std::vector<PlyColumnData>& columns,
                    const PlyLook& look = {}) {
    return Saved(name, PlyBytes(columns, look));
  }
  void Refused(const std::string& file, const std::vector<std::string>& parts) {
    ExpectError([&] { ReadSplats(file); }, parts);
  }
  PlyColumnData& Column(const std::string& name) {
    for (PlyColumnData& column : columns_)
      if (column.name == name) return column;
    throw Error(name, "no such column");
  }
  void Remove(const std::string& name) {
    std::erase_if(columns_, [&](const PlyColumnData& column) { return column.name == name; });
  }

  TemporaryFolder folder_;
  Gaussians g_ = RandomGaussians(50, 1, Basis::kSh, 9);
  std::vector<PlyColumnData> columns_ = ColumnsOfPly(g_);
  std::vector<std::string> notes_;
};

TEST_F(SplatKinds, PackedByGzip) {
  const std::string ply = PlyBytes(columns_);
  EXPECT_EQ(ReadSplats(Saved("scene.ply.gz", Gzip(ply))).values, g_.values);
  EXPECT_EQ(ReadSplats(Saved("scene.PLY", Gzip(ply))).values, g_.values);
  WriteSceneGlb(folder_ / "a.glb", g_);
  EXPECT_EQ(ReadSplats(Saved("a.glb.gz", Gzip(BytesOf(folder_ / "a.glb")))).values,
            ReadSplats(folder_ / "a.glb").values);
  EXPECT_EQ(
      ReadSplats(Saved("a.splat.gz", Gzip(std::string(16, '\1') + std::string(48, '\2')))).size(),
      2u);
  // Two gzip files in one, as parallel packers write.
  EXPECT_EQ(
      ReadSplats(Saved("parts.ply.gz", Gzip(ply.substr(0, 99)) + Gzip(ply.substr(99)))).values,
      g_.values);
  const std::string packed = Gzip(ply);
  Refused(Saved("cut.ply.gz", packed.substr(0, packed.size() / 2)), {"cut.ply.gz", "truncated"});
  Refused(Saved("bomb.ply.gz", Gzip("ply\n" + std::string(1 << 25, '\0'))),
          {"bomb.ply.gz", "inflates to more than"});
  Refused(Saved("log.gz", Gzip("a log file\n")), {"log.gz", "is not a splat file"});
}

TEST_F(SplatKinds, NamedInCapitals) {
  const std::string record = std::string(16, '\1') + std::string(16, '\2');
  EXPECT_EQ(ReadSplats(Saved("X.SPLAT", record)).size(), 1u);
  EXPECT_EQ(ReadSplats(Saved("X.Ply", columns_)).size(), 50u);
  // A file is what its bytes say.
  EXPECT_EQ(SplatLayoutOf(Saved("renamed.splat", columns_)), SplatLayout::kPly);
}

TEST_F(SplatKinds, HeadersOfAnyLengthOrderAndLineEnding) {
  const std::string settings = "comment " + std::string(20000, 's') + "\n";
  EXPECT_EQ(ReadSplats(Saved("a.ply", columns_, {settings})).values, g_.values);
  std::string many;
  for (int i = 0; i < 400; ++i) many += "comment of a program that says much\nobj_info too\n";
  EXPECT_EQ(ReadSplats(Saved("a.ply", columns_, {many})).values, g_.values);
  EXPECT_EQ(ReadSplats(Saved("a.ply", columns_, {"", "\r\n"})).values, g_.values);
  EXPECT_EQ(ReadSplats(Saved("a.ply", columns_, {"", "\n", true})).values, g_.values);
  std::reverse(columns_.begin(), columns_.end());
  EXPECT_EQ(ReadSplats(Saved("a.ply", columns_)).values, g_.values);
}

TEST_F(SplatKinds, PropertiesThatAreNotReadAreNamed) {
  for (const char* name : {"nx", "motion_0", "trbf_center"})
    columns_.push_back({name, std::vector<float>(50, 1)});
  EXPECT_EQ(ReadSplats(Saved("a.ply", columns_), &notes_).values, g_.values);
  ASSERT_EQ(notes_.size(), 1u);
  EXPECT_TRUE(Mentions(notes_, "2 properties that are not read")) << notes_[0];
  EXPECT_TRUE(Mentions(notes_, ": motion_0, trbf_center")) << notes_[0];
}

TEST_F(SplatKinds, DiscsOf2dgs) {
  Remove("scale_2");
  const Gaussians read = ReadSplats(Saved("a.ply", columns_), &notes_);
  EXPECT_TRUE(Mentions(notes_, "2DGS"));
  EXPECT_EQ(notes_.size(), 1u);
  Gaussians flat = g_;
  for (size_t i = 0; i < flat.size(); ++i) flat.at(kScaleLog, i)[2] = -12;
  EXPECT_GT(PsnrOf(read, flat), 60);
}

TEST_F(SplatKinds, FilterOfMipSplatting) {
  columns_.push_back({"filter_3D", {}});
  Gaussians meant = g_;
  meant.antialiased = true;
  for (size_t i = 0; i < 50; ++i) {
    const float filter = 0.05f + 0.001f * float(i);
    columns_.back().values.push_back(filter);
    meant.smoothing.push_back(filter * filter);
  }
  const Gaussians read = ReadSplats(Saved("a.ply", columns_), &notes_);
  EXPECT_TRUE(Mentions(notes_, "Mip-Splatting"));
  EXPECT_TRUE(read.antialiased);
  EXPECT_GT(PsnrOf(read, meant), 60);
}

TEST_F(SplatKinds, ColoursAsBytes) {
  for (int k = 0; k < 3; ++k) {
    PlyColumnData& column = Column("f_dc_" + std::to_string(k));
    column.name = k == 0 ? "red" : k == 1 ? "green" : "blue";
    std::fill(column.values.begin(), column.values.end(), float(51 * (k + 1)));
  }
  const Gaussians read = ReadSplats(Saved("a.ply", columns_));
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(0.5f + 0.28209479f * read.at(kColorDc, 7)[k], 0.2f * float(k + 1), 1e-6f);
}

TEST_F(SplatKinds, ColoursAsShares) {
  for (int k = 0; k < 3; ++k) {
    PlyColumnData& column = Column("f_dc_" + std::to_string(k));
    column.name = k == 0 ? "red" : k == 1 ? "green" : "blue";
    std::fill(column.values.begin(), column.values.end(), 0.2f * float(k + 1));
  }
  const Gaussians read = ReadSplats(Saved("a.ply", columns_), &notes_);
  EXPECT_TRUE(Mentions(notes_, "read as shares"));
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(0.5f + 0.28209479f * read.at(kColorDc, 7)[k], 0.2f * float(k + 1), 1e-5f);
}

TEST_F(SplatKinds, NamesAsCloudCompareWritesThem) {
  for (PlyColumnData& column : columns_)
    if (column.name.size() > 1) column.name = "scalar_" + column.name;
  EXPECT_EQ(ReadSplats(Saved("a.ply", columns_)).values, g_.values);
}

TEST_F(SplatKinds, GlbOfLogarithmsAndOfTurnedNodes) {
  WriteSceneGlb(folder_ / "a.glb", g_);
  const Gaussians ours = ReadSplats(folder_ / "a.glb", &notes_);
  EXPECT_TRUE(notes_.empty());
  GlbBytes glb = SplitGlb(BytesOf(folder_ / "a.glb"));
  const Json& attributes = glb.json["meshes"][0]["primitives"][0]["attributes"];
  const size_t view =
      glb.json["accessors"][size_t(attributes["KHR_gaussian_splatting:SCALE"])]["bufferView"];
  const size_t offset = glb.json["bufferViews"][view]["byteOffset"];
  std::memcpy(&glb.binary[offset], g_.at(kScaleLog, 0), 50 * 3 * sizeof(float));
  glb.json["nodes"][0]["rotation"] = {1, 0, 0, 0};
  const Gaussians read = ReadSplats(Saved("b.glb", JoinGlb(glb)), &notes_);
  EXPECT_GT(PsnrOf(read, ours), 80);
  EXPECT_TRUE(Mentions(notes_, "read as logarithms"));
  EXPECT_TRUE(Mentions(notes_, "nodes that are moved, turned or scaled"));
}

TEST_F(SplatKinds, SpzWithExtensionsSaysSo) {
  WriteSpz(folder_ / "a.spz", g_, {}, 4);
  std::string bytes = BytesOf(folder_ / "a.spz");
  bytes[14] |= 2;
  EXPECT_EQ(ReadSplats(Saved("b.spz", bytes), &notes_).size(), 50u);
  EXPECT_TRUE(Mentions(notes_, "has extensions"));
}

TEST_F(SplatKinds, WhatHoldsNoSplatsIsNamed) {
  Refused(Saved("points3D.ply", {columns_[0], columns_[1], columns_[2]}),
          {"points3D.ply", "points or a mesh, not splats"});
  columns_.push_back({"f_offset_0", std::vector<float>(50, 1)});
  Refused(Saved("a.ply", columns_), {"a.ply", "Scaffold-GS"});
  const std::string pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:ab\nsize 1\n";
  for (const char* name : {"scene.ply", "scene.splat", "scene.spz"}) {
    Refused(Saved(name, pointer), {name, "Git LFS", "git lfs pull"});
    Refused(Saved(name, "\n<!DOCTYPE html><html><body>Sign in"), {name, "web page"});
  }
  Refused(Saved("a.ksplat", std::string(4096, '\0')), {"a.ksplat", "SplatTransform"});
  Refused(Saved("lod-meta.json", "{}"), {"lod-meta.json", "several levels"});
  Refused(Saved("meta.json", R"({"means": {"shape": [9, 3], "dtype": "float32"}})"),
          {"version", "SOG of version 1"});
}

TEST_F(SplatKinds, EmptyFilesAreNamed) {
  for (PlyColumnData& column : columns_) column.values.clear();
  Refused(Saved("none.ply", columns_), {"none.ply", "has no splats"});
  Refused(Saved("none.spz", Gzip(std::string("NGSP\3\0\0\0\0\0\0\0\0\0\0\0", 16))),
          {"none.spz", "has no splats"});
  Refused(Saved("none.splat", ""), {"none.splat", "is empty"});
  Refused(Saved("nothing.ply", ""), {"nothing.ply", "is empty"});
}

TEST_F(SplatKinds, DegreesThatAreNoneAreNamed) {
  Remove("f_rest_8");
  Refused(Saved("a.ply", columns_), {"8 properties f_rest_*", "9, 24, 45 or 72"});
  for (int k = 0; k < 8; ++k) Remove("f_rest_" + std::to_string(k));
  EXPECT_EQ(ReadSplats(Saved("a.ply", columns_)).degree, 0);
}

TEST_F(SplatKinds, CountsThatDoNotFitAreSaid) {
  Refused(Saved("a.ply", columns_, {.stated_count = 60}), {"vertex 50", "after 50", "expected 60"});
  Refused(Saved("a.ply", columns_, {.stated_count = 4000}), {"says 4000", "ends after 50"});
  EXPECT_EQ(ReadSplats(Saved("a.ply", columns_, {.stated_count = 40}), &notes_).size(), 40u);
  EXPECT_TRUE(Mentions(notes_, "920 bytes that its header does not mention"));
}

// A property that the header lacks shifts all numbers; a conversion of line endings shifts some.
TEST_F(SplatKinds, NumbersThatAreShiftedDoNotPassInSilence) {
  columns_.insert(columns_.begin() + 3, {"nx", std::vector<float>(50, 0.01f)});
  std::string bytes = PlyBytes(columns_);
  bytes.erase(bytes.find("property float nx\n"), 18);
  ReadSplats(Saved("a.ply", bytes), &notes_);
  EXPECT_TRUE(Mentions(notes_, "200 bytes that its header does not mention"));

  std::string converted;  // as are the bytes 10 in the numbers
  for (const char c : PlyBytes(columns_)) converted += c == '\n' ? "\r\n" : std::string(1, c);
  Refused(Saved("b.ply", converted), {"b.ply", "converted as if it were text"});
}

}  // namespace
}  // namespace cosplat
