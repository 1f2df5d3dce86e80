// Networks by oneDNN: each layer's result against loops, each layer's gradient against finite
// differences, files that are not supported.
#include "splat/onnx/onnx_net.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "splat/base/error.h"
#include "splat/base/rng.h"
#include "tests/fuzz/mutate.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_onnx.h"

namespace cosplat {
namespace {

using test::OnnxNode;
using test::OnnxParts;
using test::OnnxTensor;

constexpr int kWidth = 11, kHeight = 9;

std::vector<float> Random(size_t n, uint64_t seed) {
  Rng rng{seed};
  std::vector<float> values(n);
  for (float& v : values) v = 2 * rng.Uniform() - 1;
  return values;
}

struct Result {
  std::vector<std::vector<float>> maps;
  std::vector<FeatureMap> shapes;
};

class OnnxNetTest : public testing::Test {
 protected:
  std::string Write(const OnnxParts& parts) const {
    const std::string path = folder_ / "net.onnx";
    std::ofstream(path, std::ios::binary) << test::OnnxBytes(parts);
    return path;
  }
  static std::vector<std::string> Outputs(const OnnxParts& parts) {
    std::vector<std::string> names;
    for (const auto& [name, channels] : parts.outputs) names.push_back(name);
    return names;
  }
  OnnxNet Net(const OnnxParts& parts) const { return OnnxNet(Write(parts), Outputs(parts)); }
  void ExpectRefused(const OnnxParts& parts, const std::vector<std::string>& words) const {
    test::ExpectError([&] { Net(parts); }, words);
  }
  const test::TemporaryFolder folder_;
};

Result RunOn(OnnxNet& net, const std::vector<float>& planes, bool keeps = false) {
  Result result;
  result.shapes = net.Run(planes, kWidth, kHeight, keeps);
  for (const FeatureMap& map : result.shapes)
    result.maps.emplace_back(map.data, map.data + size_t(map.channels) * map.height * map.width);
  return result;
}

double Weighed(const Result& result, const std::vector<std::vector<float>>& weights) {
  double sum = 0;
  for (size_t i = 0; i < weights.size(); ++i)
    for (size_t k = 0; k < weights[i].size(); ++k) sum += double(weights[i][k]) * result.maps[i][k];
  return sum;
}

// Of every number of the image, except where a kink is near: where the differences to either side
// differ. All networks here are linear between kinks, so that only rounding is left: 1e-6 of sums
// of some hundred numbers below 1, by twice a step of 1/64.
void ExpectGradient(OnnxNet net) {
  constexpr float kStep = 1.0f / 64;
  const std::vector<float> image = Random(3 * kWidth * kHeight, 7);
  const Result there = RunOn(net, image, true);
  std::vector<std::vector<float>> d_maps;
  for (const auto& map : there.maps) d_maps.push_back(Random(map.size(), d_maps.size() + 1));
  const std::vector<float> d_image = net.Backward(d_maps);
  ASSERT_EQ(d_image.size(), image.size());
  const double value = Weighed(there, d_maps);
  size_t checked = 0;
  double largest = 0;
  for (size_t i = 0; i < image.size(); ++i) {
    std::vector<float> near = image;
    near[i] = image[i] + kStep;
    const double after = (Weighed(RunOn(net, near), d_maps) - value) / kStep;
    near[i] = image[i] - kStep;
    const double before = (value - Weighed(RunOn(net, near), d_maps)) / kStep;
    if (std::abs(after - before) > 1e-3) continue;
    ++checked;
    largest = std::max(largest, std::abs(after));
    EXPECT_NEAR(d_image[i], (after + before) / 2, 1e-3) << i;
  }
  EXPECT_GT(checked, 2 * image.size() / 3);
  EXPECT_GT(largest, 0.1);
}

// "out": 4 channels of the image's, with kernels of 2x3, uneven padding, strides and dilation.
OnnxParts ConvolutionNet() {
  OnnxParts parts;
  parts.nodes = {OnnxNode("Conv",
                          {"image", "w", "b"},
                          "out",
                          {{"pads", {1, 0, 0, 3}},
                           {"strides", {2, 1}},
                           {"dilations", {1, 2}},
                           {"kernel_shape", {2, 3}},
                           {"group", {1}, false}})};
  parts.tensors = {OnnxTensor("w", {4, 3, 2, 3}, Random(4 * 3 * 2 * 3, 3)),
                   OnnxTensor("b", {4}, Random(4, 4))};
  parts.outputs = {{"out", 4}};
  return parts;
}

TEST_F(OnnxNetTest, AConvolutionIsTheSum) {
  OnnxNet net = Net(ConvolutionNet());
  const std::vector<float> image = Random(3 * kWidth * kHeight, 1), weights = Random(72, 3),
                           bias = Random(4, 4);
  const Result result = RunOn(net, image);
  ASSERT_EQ(result.shapes[0].height, (kHeight + 1 - 2) / 2 + 1);
  ASSERT_EQ(result.shapes[0].width, kWidth + 3 - 5 + 1);
  size_t at = 0;
  for (int o = 0; o < 4; ++o)
    for (int y = 0; y < result.shapes[0].height; ++y)
      for (int x = 0; x < result.shapes[0].width; ++x) {
        double sum = bias[o];
        for (int i = 0; i < 18; ++i) {
          const int row = 2 * y - 1 + i / 3 % 2, column = x + 2 * (i % 3), c = i / 6;
          if (row >= 0 && row < kHeight && column < kWidth)
            sum += weights[18 * o + i] * image[(c * kHeight + row) * kWidth + column];
        }
        EXPECT_NEAR(result.maps[0][at++], sum, 1e-5);
      }
}

TEST_F(OnnxNetTest, AConvolutionsGradient) { ExpectGradient(Net(ConvolutionNet())); }

TEST_F(OnnxNetTest, AGroupedConvolutionsGradient) {
  OnnxParts parts;
  parts.nodes = {OnnxNode("Conv", {"image", "w"}, "out", {{"group", {3}, false}})};
  parts.tensors = {OnnxTensor("w", {6, 1, 3, 2}, Random(36, 3))};
  parts.outputs = {{"out", 6}};
  ExpectGradient(Net(parts));
}

// (2 - (image - c) / d) * 3 + e, with constants per channel and single ones.
TEST_F(OnnxNetTest, ScalingIsTheFormulaWithItsGradient) {
  OnnxParts parts;
  const auto two = OnnxTensor("", {}, {2});  // 5: a tensor, 4: that it is one
  parts.nodes = {test::ProtoBytes()
                     .Add(2, "two")
                     .Add(4, "Constant")
                     .Add(5, test::ProtoBytes().Add(1, "value").Add(5, two).Add(20, 4)),
                 OnnxNode("Sub", {"image", "c"}, "v0"),
                 OnnxNode("Div", {"v0", "d"}, "v1"),
                 OnnxNode("Sub", {"two", "v1"}, "v2"),
                 OnnxNode("Mul", {"v2", "three"}, "v3"),
                 OnnxNode("Add", {"e", "v3"}, "out")};
  const std::vector<float> c{0.1f, 0.2f, -0.3f}, d{0.5f, 2, -1}, e{1, -1, 0};
  parts.tensors = {OnnxTensor("c", {1, 3, 1, 1}, c),
                   OnnxTensor("d", {3, 1, 1}, d),
                   OnnxTensor("three", {1}, {3}),
                   OnnxTensor("e", {1, 3, 1, 1}, e)};
  parts.outputs = {{"out", 3}};
  OnnxNet net = Net(parts);
  const std::vector<float> image = Random(3 * kWidth * kHeight, 1);
  const Result result = RunOn(net, image);
  for (size_t i = 0; i < image.size(); ++i) {
    const size_t k = i / (kWidth * kHeight);
    EXPECT_NEAR(result.maps[0][i], (2 - (image[i] - c[k]) / d[k]) * 3 + e[k], 1e-5);
  }
  ExpectGradient(std::move(net));
}

TEST_F(OnnxNetTest, ReluAndItsGradient) {
  OnnxParts parts;
  parts.nodes = {OnnxNode("Relu", {"image"}, "out")};
  parts.outputs = {{"out", 3}};
  OnnxNet net = Net(parts);
  const std::vector<float> image = Random(3 * kWidth * kHeight, 1);
  const Result result = RunOn(net, image);
  for (size_t i = 0; i < image.size(); ++i) EXPECT_EQ(result.maps[0][i], std::max(0.0f, image[i]));
  ExpectGradient(std::move(net));
}

TEST_F(OnnxNetTest, PoolingIsTheMaximumWithItsGradient) {
  for (const bool ceil : {false, true}) {
    OnnxParts parts;
    parts.nodes = {OnnxNode("MaxPool",
                            {"image"},
                            "out",
                            {{"kernel_shape", {3, 2}},
                             {"strides", {2, 3}},
                             {"pads", {1, 0, 0, 1}},
                             {"ceil_mode", {ceil}, false}})};
    parts.outputs = {{"out", 3}};
    OnnxNet net = Net(parts);
    const std::vector<float> image = Random(3 * kWidth * kHeight, 1);
    const Result result = RunOn(net, image);
    ASSERT_EQ(result.shapes[0].height, ceil ? 5 : 4);
    ASSERT_EQ(result.shapes[0].width, 4);  // a fifth window would begin beyond the image
    size_t at = 0;
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < result.shapes[0].height; ++y)
        for (int x = 0; x < 4; ++x) {
          float max = -2;
          for (int row = std::max(0, 2 * y - 1); row < std::min(kHeight, 2 * y + 2); ++row)
            for (int column = 3 * x; column < std::min(kWidth, 3 * x + 2); ++column)
              max = std::max(max, image[(c * kHeight + row) * kWidth + column]);
          EXPECT_EQ(result.maps[0][at++], max);
        }
    ExpectGradient(std::move(net));
  }
}

// A value that two convolutions, an output and a join read, and a part of the net no output needs.
OnnxParts BranchingNet() {
  OnnxParts parts;
  parts.nodes = {OnnxNode("Conv", {"image", "w0"}, "first"),
                 OnnxNode("Relu", {"first"}, "shown"),
                 OnnxNode("Conv", {"shown", "w1"}, "a"),
                 OnnxNode("Relu", {"a"}, "a_shown"),
                 OnnxNode("Conv", {"shown", "w2"}, "b", {{"pads", {1, 1, 1, 1}}}),
                 OnnxNode("Dropout", {"b"}, "same"),
                 OnnxNode("Concat", {"a_shown", "same", "shown"}, "out", {{"axis", {1}, false}}),
                 OnnxNode("Conv", {"out", "w3"}, "unused")};
  parts.tensors = {OnnxTensor("w0", {5, 3, 2, 2}, Random(60, 3)),
                   OnnxTensor("w1", {7, 5, 1, 1}, Random(35, 4)),
                   OnnxTensor("w2", {3, 5, 3, 3}, Random(135, 5)),
                   OnnxTensor("w3", {1, 15, 1, 1}, Random(15, 6))};
  parts.outputs = {{"shown", 5}, {"out", 15}};
  return parts;
}

TEST_F(OnnxNetTest, BranchesGradient) {
  OnnxNet net = Net(BranchingNet());
  EXPECT_EQ(net.channels(), (std::vector<int>{5, 15}));
  EXPECT_EQ(net.min_side(), 2);
  ExpectGradient(std::move(net));
}

TEST_F(OnnxNetTest, AnOutputBeforeItsReluStaysAsItIs) {
  OnnxParts parts = BranchingNet();
  parts.outputs = {{"first", 5}, {"out", 15}};
  OnnxNet net = Net(parts);
  const Result result = RunOn(net, Random(3 * kWidth * kHeight, 1));
  EXPECT_LT(*std::min_element(result.maps[0].begin(), result.maps[0].end()), -0.1f);
  ExpectGradient(std::move(net));
}

TEST_F(OnnxNetTest, SameBitsWhateverTheThreadsOfOneDnn) {
  const std::vector<float> image = Random(3 * kWidth * kHeight, 1);
  std::vector<std::vector<float>> gradients;
  const int before = omp_get_max_threads();
  for (const int threads : {1, 2, 5}) {
    omp_set_num_threads(threads);
    OnnxNet net = Net(BranchingNet());
    gradients.push_back(net.Backward(RunOn(net, image, true).maps));
    EXPECT_EQ(omp_get_max_threads(), threads);
  }
  omp_set_num_threads(before);
  EXPECT_EQ(gradients[0], gradients[1]);
  EXPECT_EQ(gradients[0], gradients[2]);
}

TEST_F(OnnxNetTest, LayersThatAreNotSupported) {
  OnnxParts parts = BranchingNet();
  parts.nodes[3] = OnnxNode("Sigmoid", {"a"}, "a_shown");
  ExpectRefused(parts, {"net.onnx", "node_a_shown", "Sigmoid", "not among the layers"});
  parts = BranchingNet();
  parts.nodes[3] = OnnxNode("Mul", {"a", "a"}, "a_shown");
  ExpectRefused(parts, {"node_a_shown (Mul)", "a value and a constant"});
  parts.nodes[3] = OnnxNode("Add", {"a", "w0"}, "a_shown");
  ExpectRefused(parts, {"node_a_shown (Add)", "number per channel"});
  parts.nodes[3] = OnnxNode("Concat", {"a", "b"}, "a_shown", {{"axis", {1}, false}});
  ExpectRefused(parts, {"node_a_shown", "reads b"});
  parts.nodes[3] = OnnxNode("Concat", {"a", "shown"}, "a_shown", {{"axis", {2}, false}});
  ExpectRefused(parts, {"node_a_shown", "channels"});
  parts = BranchingNet();
  parts.nodes[6] = OnnxNode("Concat", {"a", "b", "image", "image"}, "out", {{"axis", {1}, false}});
  parts.nodes.pop_back();
  ExpectRefused(parts, {"does not accept", "node_out", "different sizes"});
  parts = BranchingNet();
  parts.nodes[3] = OnnxNode("MaxPool", {"a"}, "a_shown");
  ExpectRefused(parts, {"node_a_shown (MaxPool)", "impossible"});
  parts.nodes[3] =
      OnnxNode("MaxPool", {"a"}, "a_shown", {{"kernel_shape", {2, 2}}, {"pads", {0, 2, 0, 0}}});
  ExpectRefused(parts, {"node_a_shown (MaxPool)", "padding"});
  parts = BranchingNet();
  parts.nodes[2] = OnnxNode("Conv", {"shown", "image"}, "a");
  ExpectRefused(parts, {"node_a (Conv)", "not constants"});
  parts.nodes[2] = OnnxNode("Conv", {"shown", "w3"}, "a");
  ExpectRefused(parts, {"node_a (Conv)", "5 channels"});
  parts.nodes[2] = OnnxNode("Conv", {"shown", "w1"}, "a", {{"strides", {0, 1}}});
  ExpectRefused(parts, {"node_a (Conv)", "impossible"});
  parts.nodes[2] = OnnxNode("Conv", {"shown", "w1"}, "a", {{"strides", {1}}});
  ExpectRefused(parts, {"node_a (Conv)", "strides", "two dimensions"});
}

TEST_F(OnnxNetTest, NumbersThatDoNotFit) {
  OnnxParts parts = BranchingNet();
  parts.tensors[1] = OnnxTensor("w1", {7, 5, 1, 2}, Random(35, 4));
  ExpectRefused(parts, {"w1", "35 numbers", "70"});
  parts.tensors[1] = OnnxTensor("w1", {1 << 30, 1 << 30, 1 << 30, 1 << 30}, Random(35, 4));
  ExpectRefused(parts, {"w1", "extent"});
  parts = BranchingNet();
  parts.nodes.insert(parts.nodes.begin() + 1, OnnxNode("Identity", {"first"}, "again"));
  parts.nodes.push_back(OnnxNode("Relu", {}, "x"));
  ExpectRefused(parts, {"node_x (Relu)", "no inputs"});
}

// Whatever is wrong is found when the file is read, or stays within this exception.
TEST_F(OnnxNetTest, BytesThatAreNearlyANetwork) {
  const std::vector<std::string> seeds{test::OnnxBytes(BranchingNet()),
                                       test::OnnxBytes(ConvolutionNet())};
  const std::string path = folder_ / "net.onnx";
  const std::vector<float> image = Random(3 * kWidth * kHeight, 1);
  Rng rng{5};
  int run = 0, refused = 0;
  for (int i = 0; i < 3000; ++i) {
    std::ofstream(path, std::ios::binary) << test::Mutated(seeds[rng.Below(2)], seeds, rng);
    try {
      OnnxNet net(path, {"out"});
      net.Backward(RunOn(net, image, true).maps);
      ++run;
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      ++refused;
    }
  }
  EXPECT_GT(run, 100);
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace cosplat
