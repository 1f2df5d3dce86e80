#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <random>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/io/ply.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_gaussians.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::TemporaryFolder;

Gaussians RandomGaussians(size_t count, int degree) {
  Gaussians gaussians;
  gaussians.degree = degree;
  gaussians.basis = Basis::kSh;
  gaussians.Resize(count);
  std::mt19937 rng(5);
  std::normal_distribution<float> normal;
  for (auto& values : gaussians.values)
    for (float& x : values) x = normal(rng);
  return gaussians;
}

std::string Text(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  return {bytes.begin(), bytes.end()};
}

// What a trained scene goes through: own basis -> 3DGS's SH -> file -> image.
TEST(Ply, AFileReadBackGivesTheSameImage) {
  const TemporaryFolder folder;
  Camera camera;
  camera.width = 64;
  camera.height = 48;
  camera.fx = camera.fy = 60;
  camera.cx = 32;
  camera.cy = 24;
  camera.translation = {0.1f, -0.05f, 3};
  for (const Basis basis : {Basis::kDcsh, Basis::kSh})
    for (int degree = 0; degree <= kMaxTrainedDegree; ++degree) {
      const Gaussians trained = test::RandomGaussians(200, degree, basis, 3);
      Gaussians written = trained;
      ConvertBasis(written, Basis::kSh);
      WritePly(folder / "scene.ply", written);
      const Gaussians read = ReadPly(folder / "scene.ply");
      EXPECT_LT(test::LargestDifference(test::Image(read, camera), test::Image(trained, camera)),
                1e-5)
          << ToString(basis) << " of degree " << degree;
    }
}

TEST(Ply, ReadsBackExactlyAtEveryDegree) {
  const TemporaryFolder folder;
  for (int degree = 0; degree <= kMaxTrainedDegree; ++degree) {
    const Gaussians written = RandomGaussians(17, degree);
    WritePly(folder / "a.ply", written);
    const Gaussians read = ReadPly(folder / "a.ply");
    EXPECT_EQ(read.degree, degree);
    EXPECT_EQ(read.basis, Basis::kSh);
    for (int a = 0; a < kAttributeCount; ++a) EXPECT_EQ(read.values[a], written.values[a]);
  }
  WritePly(folder / "none.ply", RandomGaussians(0, 2));
  EXPECT_EQ(ReadPly(folder / "none.ply").size(), 0u);
}

// The layout of 3DGS's files, byte by byte: one Gaussian of degree 1 whose values count up.
TEST(Ply, GoldenBytes) {
  const TemporaryFolder folder;
  Gaussians one;
  one.degree = 1;
  one.basis = Basis::kSh;
  one.Resize(1);
  float next = 1;
  for (Attribute a : {kPosition, kColorDc, kColorRest, kOpacityLogit, kScaleLog, kRotation})
    for (float& x : one.values[a]) x = next++;
  WritePly(folder / "a.ply", one);
  std::string expected =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\n"
      "property float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\n"
      "property float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\n"
      "property float f_rest_0\nproperty float f_rest_1\nproperty float f_rest_2\n"
      "property float f_rest_3\nproperty float f_rest_4\nproperty float f_rest_5\n"
      "property float f_rest_6\nproperty float f_rest_7\nproperty float f_rest_8\n"
      "property float opacity\nproperty float scale_0\nproperty float scale_1\n"
      "property float scale_2\nproperty float rot_0\nproperty float rot_1\n"
      "property float rot_2\nproperty float rot_3\nend_header\n";
  // Coefficients are stored by channel: red of all three, then green, then blue.
  const float row[] = {1,  2,  3, 0,  0,  0,  4,  5,  6,  7,  10, 13, 8,
                       11, 14, 9, 12, 15, 16, 17, 18, 19, 20, 21, 22, 23};
  expected.append(reinterpret_cast<const char*>(row), sizeof(row));
  EXPECT_EQ(Text(folder / "a.ply"), expected);
}

// Foreign files: other order and types, extra properties and elements, lists, comments, ascii.
TEST(Ply, ReadsForeignFiles) {
  const TemporaryFolder folder;
  const std::string names =
      "property double opacity\nproperty float rot_3\nproperty float rot_2\n"
      "property float rot_1\nproperty float rot_0\nproperty uchar extra\n"
      "property float scale_0\nproperty float scale_1\nproperty float scale_2\n"
      "property list uchar int indices\nproperty float z\nproperty float y\nproperty float x\n"
      "property float f_dc_2\nproperty float f_dc_1\nproperty short f_dc_0\n";
  const std::string head =
      "comment made elsewhere\nobj_info x\nelement camera 1\n"
      "property float fov\nproperty list uchar uchar name\nelement vertex 2\n" +
      names + "element face 9\nproperty list uchar int v\nend_header\n";
  WriteFileAtomically(folder / "ascii.ply",
                      "ply\r\nformat ascii 1.0\r\n" + head +
                          "1.5 3 7 8 9\n"
                          "-1 4 3 2 1 255 .1 .2 .3 2 70 71 30 20 10 3 2 1\n"
                          "-2 8 7 6 5 255 .4 .5 .6 0 60 50 40 6 5 4\n"
                          "faces are never looked at\n");
  const Gaussians read = ReadPly(folder / "ascii.ply");
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read.degree, 0);
  EXPECT_EQ(read.values[kPosition], (Buffer<float>{10, 20, 30, 40, 50, 60}));
  EXPECT_EQ(read.values[kRotation], (Buffer<float>{1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(read.values[kColorDc], (Buffer<float>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(read.values[kOpacityLogit], (Buffer<float>{-1, -2}));
  EXPECT_EQ(read.values[kScaleLog], (Buffer<float>{.1f, .2f, .3f, .4f, .5f, .6f}));

  std::string body;
  const auto put = [&](auto value) { body.append(reinterpret_cast<char*>(&value), sizeof(value)); };
  put(1.5f), put(uint8_t(2)), put(uint8_t(1)), put(uint8_t(2));  // the camera
  for (int i = 0; i < 2; ++i) {
    put(-1.0 - i);
    for (float r : {4, 3, 2, 1}) put(r + 4 * i);
    put(uint8_t(255));
    for (float s : {.1f, .2f, .3f}) put(s);
    put(uint8_t(1)), put(int32_t(5));
    for (float p : {30, 20, 10}) put(p + i);
    put(3.f), put(2.f), put(int16_t(1));
  }
  WriteFileAtomically(folder / "binary.ply",
                      "ply\nformat binary_little_endian 1.0\n" + head + body);
  const Gaussians binary = ReadPly(folder / "binary.ply");
  EXPECT_EQ(binary.values[kPosition], (Buffer<float>{10, 20, 30, 11, 21, 31}));
  EXPECT_EQ(binary.values[kRotation], (Buffer<float>{1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(binary.values[kColorDc], (Buffer<float>{1, 2, 3, 1, 2, 3}));
}

TEST(Ply, TruncatedFilesNameTheVertex) {
  const TemporaryFolder folder;
  WritePly(folder / "a.ply", RandomGaussians(3, 1));
  const std::string whole = Text(folder / "a.ply");
  const size_t header = whole.find("end_header") + 11;
  for (size_t cut = 0; cut < whole.size(); cut += 5) {
    WriteFileAtomically(folder / "cut.ply", whole.substr(0, cut));
    ExpectError([&] { ReadPly(folder / "cut.ply"); }, {"cut.ply"});
  }
  WriteFileAtomically(folder / "cut.ply", whole.substr(0, header + 26 * 4 + 6));
  ExpectError([&] { ReadPly(folder / "cut.ply"); }, {"cut.ply", "vertex 1", "at y", "expected 3"});
  std::string many = whole;
  many.replace(many.find("vertex 3"), 8, "vertex 99999999999999");
  WriteFileAtomically(folder / "many.ply", many);
  ExpectError([&] { ReadPly(folder / "many.ply"); }, {"many.ply", "vertex", "99999999999999"});
}

TEST(Ply, BadValuesNameVertexAndProperty) {
  const TemporaryFolder folder;
  Gaussians gaussians = RandomGaussians(3, 1);
  WritePly(folder / "a.ply", gaussians);
  const std::string whole = Text(folder / "a.ply");
  const size_t header = whole.find("end_header") + 11;
  for (float bad : {std::numeric_limits<float>::quiet_NaN(), -INFINITY}) {
    std::string changed = whole;
    changed.replace(header + 26 * 4 * 2 + 10 * 4, 4, reinterpret_cast<char*>(&bad), 4);
    WriteFileAtomically(folder / "bad.ply", changed);
    ExpectError([&] { ReadPly(folder / "bad.ply"); }, {"bad.ply", "vertex 2, f_rest_1", "finite"});
    gaussians.at(kScaleLog, 1)[2] = bad;
    ExpectError([&] { WritePly(folder / "no.ply", gaussians); }, {"no.ply", "vertex 1, scale_2"});
    EXPECT_FALSE(std::filesystem::exists(folder / "no.ply"));
  }
}

TEST(Ply, BadHeadersSayWhatIsWrong) {
  const TemporaryFolder folder;
  WritePly(folder / "a.ply", RandomGaussians(1, 1));
  const std::string whole = Text(folder / "a.ply");
  const struct {
    const char *from, *to;
    std::vector<std::string> parts;
  } cases[] = {{"ply\n", "plx\n", {"not a PLY"}},
               {"binary_little_endian", "binary_mixed_endian", {"format", "binary_mixed_endian"}},
               {"format binary_little_endian 1.0\n", "", {"no format line"}},
               {"element vertex 1", "element vertex many", {"element vertex many"}},
               {"element vertex 1", "element vertex -1", {"element vertex -1"}},
               {"element vertex", "element point", {"no element vertex"}},
               {"property float opacity", "property float opaque", {"no property opacity"}},
               {"property float rot_2", "property quad rot_2", {"unknown type 'quad'"}},
               {"float f_rest_8", "float g_rest_8", {"8 properties f_rest_*", "9, 24, 45 or 72"}},
               {"float f_rest_8", "float f_rest_9", {"no property f_rest_8"}},
               {"property float x", "properly float x", {"properly float x"}}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.to);
    std::string changed = whole;
    changed.replace(changed.find(c.from), std::string(c.from).size(), c.to);
    WriteFileAtomically(folder / "bad.ply", changed);
    ExpectError([&] { ReadPly(folder / "bad.ply"); }, c.parts);
  }
  // A message quotes the beginning of a long line.
  WriteFileAtomically(folder / "long.ply", "ply\n" + std::string(4000, 'x') + "\nend_header\n");
  try {
    ReadPly(folder / "long.ply");
    ADD_FAILURE() << "long.ply was read";
  } catch (const Error& error) {
    EXPECT_LT(std::string(error.what()).size(), 300u);
  }
  ExpectError([&] { ReadPly(folder / "none.ply"); }, {"none.ply", "No such file"});
  WriteFileAtomically(folder / "word.ply",
                      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                      "property float y\nproperty float z\nend_header\n1 2 three\n");
  std::vector<double> points;
  std::vector<uint8_t> colors;
  ExpectError([&] { ReadPointsPly(folder / "word.ply", points, colors); },
              {"vertex 0", "z is not a number"});
}

TEST(Ply, OnlyShGoesIntoTheFile) {
  const TemporaryFolder folder;
  Gaussians gaussians = RandomGaussians(2, 1);
  gaussians.basis = Basis::kDcsh;
  ExpectError([&] { WritePly(folder / "a.ply", gaussians); }, {"a.ply", "dcsh"});
}

TEST(Ply, FullDiskIsAnError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  ExpectError([&] { WritePly("/dev/full", RandomGaussians(1000, 1)); }, {"/dev/full", "No space"});
}

TEST(PointsPly, ReadsBack) {
  const TemporaryFolder folder;
  const std::vector<float> points{1, 2, 3, -4, 5, 6.5f};
  const std::vector<uint8_t> colors{0, 128, 255, 7, 8, 9};
  WritePointsPly(folder / "p.ply", points, colors);
  std::vector<double> read_points;
  std::vector<uint8_t> read_colors;
  ReadPointsPly(folder / "p.ply", read_points, read_colors);
  EXPECT_EQ(read_points, (std::vector<double>{1, 2, 3, -4, 5, 6.5}));
  EXPECT_EQ(read_colors, colors);
  ExpectError([&] { WritePointsPly(folder / "q.ply", points, {1, 2, 3}); }, {"q.ply", "6", "3"});
}

}  // namespace
}  // namespace cosplat
