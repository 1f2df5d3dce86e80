// Numbers in splat files that are no ordinary ones: quaternions of zero, infinite opacities, scales
// of zero, and what is no number at all. Every layout follows one rule (splat/io/splat_values.h).
#include "splat/io/splat_values.h"

#include <gtest/gtest.h>

#include "splat/base/json.h"
#include "tests/street/splat_fixture.h"
#include "tests/support/expect_error.h"
#include "tests/support/glb_bytes.h"

namespace cosplat {
namespace {

using namespace test;

// Lossy layouts keep this much of the pictures here (35 dB and more); splats that only one of them
// drew cost all but some 10 dB.
constexpr double kSamePicture = 30;

Gaussians Scene(size_t count) { return RandomGaussians(count, 1, Basis::kSh, 5); }

void MakeRotationZero(Gaussians& g, size_t i) { std::fill_n(g.at(kRotation, i), 4, 0.0f); }

// Every third without a direction; and the others alone.
struct Undirected {
  Gaussians all = Scene(90), drawn;
  Undirected() {
    std::vector<uint32_t> kept;
    for (uint32_t i = 0; i < all.size(); ++i)
      if (i % 3 == 0)
        MakeRotationZero(all, i);
      else
        kept.push_back(i);
    drawn = all;
    drawn.Gather(kept);
  }
};

TEST(ZeroQuaternions, AreLeftOutOfAPlyAndOfWhatIsMadeOfIt) {
  const TemporaryFolder folder;
  const Undirected scene;
  std::vector<std::string> notes;
  const Gaussians read = ReadSplats(SavedPly(folder, scene.all), &notes);
  EXPECT_EQ(read.values, scene.drawn.values);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0],
            "30 of 90 splats cannot be drawn and are left out: 30 have a quaternion of zero");
  for (const std::string& file : Exported(folder, read))
    EXPECT_GT(PsnrOf(ReadSplats(file), read), kSamePicture) << file;
}

TEST(ZeroQuaternions, AreNotDrawnFromFilesOfGaussiansInMemory) {
  const TemporaryFolder folder;
  const Undirected scene;
  for (const std::string& file : Exported(folder, scene.all)) {
    const Gaussians read = ReadSplats(file);
    EXPECT_GT(PsnrOf(read, scene.drawn), kSamePicture) << file;
    // Nor by programs that know no such rule.
    for (size_t i = 0; i < read.size(); ++i) {
      const float* r = read.at(kRotation, i);
      EXPECT_GT(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3], 0.01f) << file;
    }
  }
}

TEST(ZeroQuaternions, AreLeftOutOfSplatAndGlb) {
  const TemporaryFolder folder;
  std::string records;
  for (const char* rotation : {"\xff\x80\x80\x80", "\x80\x80\x80\x80"}) {
    const float numbers[6] = {1, 2, 3, 0.1f, 0.1f, 0.1f};
    records.append(reinterpret_cast<const char*>(numbers), sizeof numbers);
    records.append("\xff\xff\xff\xff", 4).append(rotation, 4);
  }
  WriteFileAtomically(folder / "two.splat", records);
  std::vector<std::string> notes;
  EXPECT_EQ(ReadSplats(folder / "two.splat", &notes).size(), 1u);
  EXPECT_TRUE(Mentions(notes, "1 of 2 splats cannot be drawn"));

  WriteSceneGlb(folder / "a.glb", Scene(4));
  GlbBytes glb = SplitGlb(BytesOf(folder / "a.glb"));
  const Json& attributes = glb.json["meshes"][0]["primitives"][0]["attributes"];
  const size_t view =
      glb.json["accessors"][size_t(attributes["KHR_gaussian_splatting:ROTATION"])]["bufferView"];
  const size_t offset = glb.json["bufferViews"][view]["byteOffset"];
  std::fill_n(&glb.binary[offset + 2 * 16], 16, '\0');
  WriteFileAtomically(folder / "b.glb", JoinGlb(glb));
  notes.clear();
  EXPECT_EQ(ReadSplats(folder / "b.glb", &notes).size(), 3u);
  EXPECT_TRUE(Mentions(notes, "1 of 4 splats cannot be drawn"));
}

TEST(ZeroQuaternions, AFileOfNothingElseIsRefused) {
  const TemporaryFolder folder;
  Gaussians g = Scene(5);
  for (size_t i = 0; i < 5; ++i) MakeRotationZero(g, i);
  const std::string file = SavedPly(folder, g);
  ExpectError([&] { ReadSplats(file); }, {"theirs.ply", "all of 5 splats", "quaternion of zero"});
}

// A direction is one whatever the length, as in 3DGS, which normalises.
TEST(Quaternions, OfAnyLengthTurnTheSameWay) {
  const TemporaryFolder folder;
  const Gaussians g = Scene(60);
  for (const float length : {1e-10f, 1e-5f, 1e18f, 1e30f}) {
    Gaussians scaled = g;
    for (float& x : scaled.values[kRotation]) x *= length;
    const Gaussians read = ReadSplats(SavedPly(folder, scaled));
    ASSERT_EQ(read.size(), g.size()) << length;
    EXPECT_GT(PsnrOf(read, g), 80) << length;
  }
}

TEST(InfiniteNumbers, OfOpacitiesAndScalesAreValid) {
  const TemporaryFolder folder;
  Gaussians theirs = Scene(60), meant = theirs;
  for (size_t i = 0; i < 60; ++i) {
    if (i % 5 < 2) {
      *theirs.at(kOpacityLogit, i) = i % 5 == 0 ? INFINITY : -INFINITY;
      *meant.at(kOpacityLogit, i) = i % 5 == 0 ? 30 : -30;
    }
    if (i % 7 == 0) {
      theirs.at(kScaleLog, i)[i % 3] = -INFINITY;
      meant.at(kScaleLog, i)[i % 3] = -15;
    }
  }
  std::vector<std::string> notes;
  const Gaussians read = ReadSplats(SavedPly(folder, theirs), &notes);
  EXPECT_TRUE(AllAreFinite(read));
  EXPECT_GT(PsnrOf(read, meant), 60);
  EXPECT_TRUE(Mentions(notes, "24 opacities are infinite"));
  EXPECT_TRUE(Mentions(notes, "9 scales are 0"));
  for (const std::string& file : Exported(folder, read)) {
    const Gaussians again = ReadSplats(file);
    EXPECT_TRUE(AllAreFinite(again)) << file;
    EXPECT_GT(PsnrOf(again, meant), kSamePicture) << file;
  }
}

TEST(InfiniteNumbers, APointIsAPointInEveryLayout) {
  const TemporaryFolder folder;
  float numbers[6] = {1, 2, 3, 0, 0, 0};
  WriteFileAtomically(folder / "a.splat",
                      std::string(reinterpret_cast<char*>(numbers), sizeof numbers) +
                          "\xff\xff\xff\xff\xff\x80\x80\x80");
  std::vector<std::string> notes;
  const Gaussians records = ReadSplats(folder / "a.splat", &notes);
  EXPECT_EQ(records.at(kScaleLog, 0)[0], -kLargestScaleLog);
  EXPECT_TRUE(Mentions(notes, "3 scales are 0"));
  // Our own glTF file of a scale that no float has.
  Gaussians g = Scene(3);
  g.at(kScaleLog, 1)[2] = -200;
  WriteSceneGlb(folder / "a.glb", g);
  EXPECT_EQ(ReadSplats(folder / "a.glb").at(kScaleLog, 1)[2], -kLargestScaleLog);
  EXPECT_EQ(ReadSplats(SavedPly(folder, g)).at(kScaleLog, 1)[2], -kLargestScaleLog);
}

TEST(InfiniteNumbers, SizesWithoutAnEndAreLeftOut) {
  const TemporaryFolder folder;
  Gaussians g = Scene(10);
  g.at(kScaleLog, 4)[1] = 50;  // e^50: hidden here, a fog that SPZ's largest size would make
  std::vector<std::string> notes;
  EXPECT_EQ(ReadSplats(SavedPly(folder, g), &notes).size(), 9u);
  EXPECT_TRUE(
      Mentions(notes, "1 of 10 splats cannot be drawn and are left out: 1 are of infinite"));
}

// As other programs' splats have them under 3DGS's names.
TEST(OtherUnits, AreSaid) {
  const TemporaryFolder folder;
  const Gaussians good = RandomGaussians(200, 0, Basis::kSh, 3);
  std::vector<std::string> notes;
  ReadSplats(SavedPly(folder, good), &notes);
  EXPECT_TRUE(notes.empty()) << notes[0];
  const auto said = [&](Attribute attribute, float low, float high) {
    Gaussians g = good;
    Buffer<float>& values = g.values[attribute];
    for (size_t i = 0; i < values.size(); ++i)
      values[i] = low + (high - low) * float(i) / float(values.size() - 1);
    notes.clear();
    ReadSplats(SavedPly(folder, g), &notes);
    return notes.size() == 1 ? notes[0] : std::to_string(notes.size()) + " notes";
  };
  EXPECT_NE(said(kOpacityLogit, 0, 1).find("are they logits"), std::string::npos);
  EXPECT_NE(said(kOpacityLogit, 0, 255).find("from 0 to 255"), std::string::npos);
  EXPECT_NE(said(kScaleLog, 0.001f, 0.2f).find("logarithms"), std::string::npos);
  EXPECT_NE(said(kColorDc, 0.1f, 0.9f).find("are they coefficients"), std::string::npos);
}

TEST(NumbersThatAreNone, AreRefusedInEveryProperty) {
  const TemporaryFolder folder;
  for (int a = 0; a <= kColorRest; ++a)
    for (const float bad : {NAN, INFINITY, -INFINITY}) {
      if (a == kOpacityLogit && std::isinf(bad)) continue;
      if (a == kScaleLog && bad < 0) continue;
      Gaussians g = Scene(3);
      g.at(Attribute(a), 1)[0] = bad;
      const std::string file = SavedPly(folder, g);
      ExpectError([&] { ReadSplats(file); }, {"theirs.ply", "vertex 1", "is not finite"});
      for (const char* ours : {"no.ply", "no.glb"})
        ExpectError(
            [&] { ours[3] == 'p' ? WritePly(folder / ours, g) : WriteSceneGlb(folder / ours, g); },
            {ours, "not finite"});
    }
}

}  // namespace
}  // namespace cosplat
