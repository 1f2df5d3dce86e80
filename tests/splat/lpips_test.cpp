// LPIPS: the formula on a net of two convolutions, the published net's values, bad files.
#include "splat/eval/lpips.h"

#include <gtest/gtest.h>
#include <omp.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>

#include "splat/base/rng.h"
#include "splat/media/image_io.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_onnx.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

Image8 RandomImage(int width, int height, uint64_t seed) {
  Rng rng(seed);
  Image8 image(width, height, 3);
  for (uint8_t& value : image.data) value = uint8_t(255.999f * rng.Uniform());
  return image;
}

struct Map {
  int channels, height, width;
  std::vector<double> values;
  double& at(int c, int y, int x) { return values[(size_t(c) * height + y) * width + x]; }
};

Map InputMap(const Image8& image) {
  Map map{3, image.height, image.width, std::vector<double>(image.data.size())};
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < map.height; ++y)
      for (int x = 0; x < map.width; ++x) map.at(c, y, x) = image.at(x, y, c) / 127.5 - 1;
  return map;
}

Map Convolve(Map in, const test::TinyConv& conv) {
  const int k = conv.kernel;
  Map out{conv.out_channels, in.height / k, in.width / k, {}};
  for (int o = 0; o < out.channels; ++o)
    for (int y = 0; y < out.height; ++y)
      for (int x = 0; x < out.width; ++x) {
        double sum = 0;
        for (int c = 0; c < in.channels; ++c)
          for (int i = 0; i < k * k; ++i)
            sum += conv.weights[size_t(o * in.channels + c) * k * k + i] *
                   in.at(c, k * y + i / k, k * x + i % k);
        out.values.push_back(sum);
      }
  return out;
}

double MapDistance(Map a, Map b, const std::vector<float>& weights) {
  double sum = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      double square_a = 1e-20, square_b = 1e-20;
      for (int c = 0; c < a.channels; ++c) {
        square_a += a.at(c, y, x) * a.at(c, y, x);
        square_b += b.at(c, y, x) * b.at(c, y, x);
      }
      for (int c = 0; c < a.channels; ++c)
        sum +=
            weights[c] *
            std::pow(a.at(c, y, x) / std::sqrt(square_a) - b.at(c, y, x) / std::sqrt(square_b), 2);
    }
  return sum / (a.height * a.width);
}

double TinyDistance(const Image8& a, const Image8& b) {
  Map map_a = InputMap(a), map_b = InputMap(b);
  double sum = 0;
  for (size_t i = 0; i < 2; ++i) {
    map_a = Convolve(map_a, test::TinyConvs()[i]);
    map_b = Convolve(map_b, test::TinyConvs()[i]);
    sum += MapDistance(map_a, map_b, test::TinyLins()[i]);
  }
  return sum;
}

class LpipsTest : public testing::Test {
 protected:
  LpipsTest() { test::WriteTinyLpips(folder_.path(), "tiny"); }
  // The folder's three files as they were.
  void Mend() const { test::WriteTinyLpips(folder_.path(), "tiny"); }
  void Spill(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }
  void ExpectRefused(const std::vector<std::string>& parts) const {
    test::ExpectError([&] { Lpips(folder_.path()); }, parts);
    Mend();
  }
  const test::TemporaryFolder folder_;
};

TEST_F(LpipsTest, IsTheFormula) {
  Lpips lpips(folder_.path());
  EXPECT_EQ(lpips.net(), "tiny");
  EXPECT_EQ(lpips.min_side(), 4);
  // Measured: 3e-7 apart, what float maps and float sums over the channels leave.
  for (const auto& [width, height] : {std::pair{4, 4}, {12, 8}, {23, 17}}) {
    const Image8 a = RandomImage(width, height, 1), b = RandomImage(width, height, 2);
    EXPECT_NEAR(lpips.Distance(a, b), TinyDistance(a, b), 1e-6);
  }
}

TEST_F(LpipsTest, IsSymmetricAndZeroForEqualImages) {
  Lpips lpips(folder_.path());
  const Image8 a = RandomImage(16, 16, 1), b = RandomImage(16, 16, 2);
  EXPECT_EQ(lpips.Distance(a, a), 0);
  EXPECT_EQ(lpips.Distance(a, b), lpips.Distance(b, a));
  EXPECT_GT(lpips.Distance(a, b), 0.01);
}

TEST_F(LpipsTest, MapsThatAreZeroAreFinite) {
  test::TinyConv conv = test::TinyConvs()[0];
  for (float& weight : conv.weights) weight = 0;
  Spill("tiny_backbone.onnx", test::TinyOnnx({conv, test::TinyConvs()[1]}));
  EXPECT_EQ(Lpips(folder_.path()).Distance(RandomImage(8, 8, 1), RandomImage(8, 8, 2)), 0);
}

TEST_F(LpipsTest, SizesMayChangeFromImageToImage) {
  Lpips lpips(folder_.path());
  const Image8 a = RandomImage(40, 24, 1), b = RandomImage(40, 24, 2);
  const double first = lpips.Distance(a, b);
  lpips.Distance(RandomImage(9, 31, 3), RandomImage(9, 31, 4));
  EXPECT_EQ(lpips.Distance(a, b), first);
}

TEST_F(LpipsTest, ImagesThatDoNotFit) {
  Lpips lpips(folder_.path());
  const Image8 a(8, 8, 3), b(8, 9, 3), rgba(8, 8, 4), small(8, 3, 3);
  test::ExpectError([&] { lpips.Distance(a, b); }, {"images", "8x8", "8x9"});
  test::ExpectError([&] { lpips.Distance(a, rgba); }, {"tiny_backbone.onnx", "8x8x4"});
  test::ExpectError([&] { lpips.Distance(small, small); },
                    {"tiny_backbone.onnx", "at least 4x4", "8x3"});
}

// OpenCV's inference of shapes lets 1x1 through here, where no kernel fits.
TEST_F(LpipsTest, TheLeastSizeIsWhatEveryLayerTakes) {
  std::vector<test::TinyConv> convs = test::TinyConvs();
  convs[0].kernel = 3;
  convs[0].weights.assign(54, 0.1f);
  Spill("tiny_backbone.onnx", test::TinyOnnx(convs));
  Lpips lpips(folder_.path());
  EXPECT_EQ(lpips.min_side(), 12);
  EXPECT_GT(lpips.Distance(RandomImage(12, 12, 1), RandomImage(12, 12, 2)), 0);
}

TEST_F(LpipsTest, FilesThatAreMissing) {
  test::ExpectError([&] { Lpips(folder_ / "absent"); }, {"absent", "_backbone.onnx"});
  for (const std::string file : {"tiny_taps.txt", "tiny_lin.npz"}) {
    fs::remove(folder_ / file);
    ExpectRefused({folder_ / file});
  }
  fs::remove(folder_ / "tiny_backbone.onnx");
  ExpectRefused({folder_.path(), "contains no", "_backbone.onnx"});
  test::WriteTinyLpips(folder_.path(), "other");
  ExpectRefused({folder_.path(), "other_backbone.onnx", "tiny_backbone.onnx"});
}

TEST_F(LpipsTest, NetsThatAreNone) {
  const std::string file = folder_ / "tiny_backbone.onnx";
  const std::string whole = test::TinyOnnx(test::TinyConvs());
  for (const std::string& bytes :
       {std::string("no network"), std::string(), whole.substr(0, 200)}) {
    Spill("tiny_backbone.onnx", bytes);
    ExpectRefused({file});
  }
  test::TinyConv grey = test::TinyConvs()[0];
  grey.in_channels = 1, grey.weights.resize(2);
  Spill("tiny_backbone.onnx", test::TinyOnnx({grey, test::TinyConvs()[1]}));
  ExpectRefused({file, "RGB"});
  test::TinyConv wide = test::TinyConvs()[0];
  wide.weights[1] = std::numeric_limits<float>::quiet_NaN();
  Spill("tiny_backbone.onnx", test::TinyOnnx({wide, test::TinyConvs()[1]}));
  Lpips broken(folder_.path());
  test::ExpectError([&] { broken.Distance(Image8(8, 8, 3), Image8(8, 8, 3, 9)); },
                    {file, "non-finite"});
}

TEST_F(LpipsTest, TapsThatDoNotFit) {
  Spill("tiny_taps.txt", "near\nfarther\n");
  ExpectRefused({"tiny_backbone.onnx", "farther", "near", "far"});
  Spill("tiny_taps.txt", " \n");
  ExpectRefused({"tiny_taps.txt"});
  Spill("tiny_taps.txt", "far\nnear\n");
  ExpectRefused({"tiny_lin.npz", "lin0", "2 weights", "far", "3 channels"});
  Spill("tiny_taps.txt", "near\n");
  ExpectRefused({"tiny_lin.npz", "lin1", "number of taps is 1"});
}

TEST_F(LpipsTest, WeightsThatDoNotFit) {
  Spill("tiny_lin.npz", "no archive");
  ExpectRefused({"tiny_lin.npz"});
  Npz npz;
  npz.Add("lin0", {2}, test::TinyLins()[0]);
  npz.Write(folder_ / "tiny_lin.npz");
  ExpectRefused({"tiny_lin.npz", "lin1", "missing"});
  npz.Add("lin1", {3}, std::vector<float>{1, std::numeric_limits<float>::quiet_NaN(), 1});
  npz.Write(folder_ / "tiny_lin.npz");
  ExpectRefused({"tiny_lin.npz", "lin1[1]", "finite"});
}

std::string DataFolder() { return COSPLAT_SOURCE_DIR "/../shared/data/lpips"; }

// Values of the reference implementation.
TEST(LpipsRealNet, SqueezeNetOnItsExamples) {
  if (!fs::exists(DataFolder())) GTEST_SKIP() << "lpips is not here";
  Lpips lpips(DataFolder());
  EXPECT_EQ(lpips.net(), "squeeze");
  const auto image = [](const char* name) {
    return ReadImage(DataFolder() + "/ex/ex_" + name + ".png");
  };
  EXPECT_EQ(lpips.Distance(image("ref"), image("ref")), 0);
  EXPECT_NEAR(lpips.Distance(image("ref"), image("p0")), 0.71105, 1e-5);
  EXPECT_NEAR(lpips.Distance(image("ref"), image("p1")), 0.14790, 1e-5);
}

TEST(LpipsRealNet, SameBitsForAnyNumberOfThreads) {
  if (!fs::exists(DataFolder())) GTEST_SKIP() << "lpips is not here";
  Lpips lpips(DataFolder());
  const Image8 a = RandomImage(64, 64, 1), b = RandomImage(64, 64, 2);
  const double several = lpips.Distance(a, b);
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(lpips.Distance(a, b), several);
  }
  for (const int threads : {1, 2, 5}) {  // of oneDNN
    omp_set_num_threads(threads);
    EXPECT_EQ(Lpips(DataFolder()).Distance(a, b), several);
    EXPECT_EQ(omp_get_max_threads(), threads);
  }
}

TEST(LpipsRealNet, NamesTheLeastSize) {
  if (!fs::exists(DataFolder())) GTEST_SKIP() << "lpips is not here";
  Lpips lpips(DataFolder());
  ASSERT_EQ(lpips.min_side(), 25);
  EXPECT_GT(lpips.Distance(RandomImage(25, 25, 1), RandomImage(25, 25, 2)), 0);
  test::ExpectError([&] { lpips.Distance(Image8(64, 24, 3), Image8(64, 24, 3)); },
                    {"squeeze_backbone.onnx", "25x25", "64x24"});
}

}  // namespace
}  // namespace cosplat
