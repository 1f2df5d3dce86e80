// ONNX files of a few convolutions, written by hand as protocol buffers (the numbers of the fields
// are those of onnx.proto), and folders that `cosplat metrics --lpips` reads.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "splat/base/npz.h"

namespace cosplat::test {

class ProtoBytes {
 public:
  ProtoBytes& Add(int field, int64_t value) {
    Varint(uint64_t(field) << 3);
    Varint(uint64_t(value));
    return *this;
  }
  ProtoBytes& Add(int field, const std::string& bytes) {
    Varint(uint64_t(field) << 3 | 2);
    Varint(bytes.size());
    bytes_ += bytes;
    return *this;
  }
  ProtoBytes& Add(int field, const char* text) { return Add(field, std::string(text)); }
  ProtoBytes& Add(int field, const ProtoBytes& message) { return Add(field, message.bytes_); }
  const std::string& bytes() const { return bytes_; }

 private:
  void Varint(uint64_t value) {
    for (; value > 127; value >>= 7) bytes_ += char((value & 127) | 128);
    bytes_ += char(value);
  }
  std::string bytes_;
};

struct OnnxAttribute {
  std::string name;
  std::vector<int64_t> numbers;
  bool is_list = true;
};

inline ProtoBytes OnnxNode(const std::string& op,
                           const std::vector<std::string>& inputs,
                           const std::string& output,
                           const std::vector<OnnxAttribute>& attributes = {}) {
  ProtoBytes node;
  for (const std::string& input : inputs) node.Add(1, input);
  node.Add(2, output).Add(3, "node_" + output).Add(4, op);
  for (const OnnxAttribute& a : attributes) {
    ProtoBytes attribute = ProtoBytes().Add(1, a.name);
    for (const int64_t number : a.numbers) attribute.Add(a.is_list ? 8 : 3, number);
    node.Add(5, attribute.Add(20, a.is_list ? 7 : 2));
  }
  return node;
}

inline ProtoBytes OnnxTensor(const std::string& name,
                             const std::vector<int>& shape,
                             const std::vector<float>& values) {
  std::string raw(values.size() * sizeof(float), '\0');
  std::memcpy(raw.data(), values.data(), raw.size());
  ProtoBytes tensor;
  for (const int extent : shape) tensor.Add(1, extent);
  return tensor.Add(2, 1).Add(8, name).Add(9, raw);  // 1: float
}

inline ProtoBytes OnnxValue(const std::string& name, int channels) {
  ProtoBytes shape;
  shape.Add(1, ProtoBytes().Add(1, 1)).Add(1, ProtoBytes().Add(1, channels));
  for (const char* free : {"height", "width"}) shape.Add(1, ProtoBytes().Add(2, free));
  const ProtoBytes tensor = ProtoBytes().Add(1, 1).Add(2, shape);
  return ProtoBytes().Add(1, name).Add(2, ProtoBytes().Add(1, tensor));
}

// What the file of a network is made of; its input is "image".
struct OnnxParts {
  std::vector<ProtoBytes> nodes, tensors;
  std::vector<std::pair<std::string, int>> outputs;  // names and channels
  int image_channels = 3;
};

inline std::string OnnxBytes(const OnnxParts& parts) {
  ProtoBytes graph;
  for (const ProtoBytes& node : parts.nodes) graph.Add(1, node);
  graph.Add(2, "tiny");
  for (const ProtoBytes& tensor : parts.tensors) graph.Add(5, tensor);
  graph.Add(11, OnnxValue("image", parts.image_channels));
  for (const auto& [name, channels] : parts.outputs) graph.Add(12, OnnxValue(name, channels));
  return ProtoBytes().Add(1, 6).Add(7, graph).Add(8, ProtoBytes().Add(1, "").Add(2, 11)).bytes();
}

// A convolution without bias whose stride is its kernel's size; the first one reads "image".
struct TinyConv {
  std::string input, output;
  int in_channels, out_channels, kernel;
  std::vector<float> weights;  // [out, in, kernel, kernel]
};

// Every convolution's output is one of the net's.
inline std::string TinyOnnx(const std::vector<TinyConv>& convs) {
  OnnxParts parts;
  parts.image_channels = convs[0].in_channels;
  for (const TinyConv& conv : convs) {
    const std::vector<int64_t> kernel{conv.kernel, conv.kernel};
    parts.nodes.push_back(OnnxNode("Conv",
                                   {conv.input, conv.output + ".weight"},
                                   conv.output,
                                   {{"kernel_shape", kernel}, {"strides", kernel}}));
    parts.tensors.push_back(
        OnnxTensor(conv.output + ".weight",
                   {conv.out_channels, conv.in_channels, conv.kernel, conv.kernel},
                   conv.weights));
    parts.outputs.push_back({conv.output, conv.out_channels});
  }
  return OnnxBytes(parts);
}

// Two taps: "near" has 2 channels at full size, "far" 3 at a quarter of the width and height.
inline std::vector<TinyConv> TinyConvs() {
  std::vector<TinyConv> convs{{"image", "near", 3, 2, 1, {}}, {"near", "far", 2, 3, 4, {}}};
  for (TinyConv& conv : convs)
    for (int i = 0; i < conv.out_channels * conv.in_channels * conv.kernel * conv.kernel; ++i)
      conv.weights.push_back(0.1f * float((7 * i + 3) % 11 - 4));
  return convs;
}

inline std::vector<std::vector<float>> TinyLins() { return {{0.5f, 2.0f}, {1.0f, 0.0f, 3.0f}}; }

inline void WriteTinyLpips(const std::string& folder, const std::string& net) {
  std::filesystem::create_directories(folder);
  const std::string stem = folder + "/" + net;
  std::ofstream(stem + "_backbone.onnx", std::ios::binary) << TinyOnnx(TinyConvs());
  std::ofstream(stem + "_taps.txt") << "near\nfar\n";
  Npz npz;
  for (size_t i = 0; i < 2; ++i)
    npz.Add("lin" + std::to_string(i), {TinyLins()[i].size()}, TinyLins()[i]);
  npz.Write(stem + "_lin.npz");
}

// A small network of the kinds of layers that LPIPS's networks have, whose maps are never all zero:
// scaling, two convolutions with ReLU, pooling between them; "near" and "far" have 8 and 6
// channels.
inline void WriteReluLpips(const std::string& folder, const std::string& net) {
  const auto numbers = [](int n, int seed, float scale, float shift) {
    std::vector<float> values;
    for (int i = 0; i < n; ++i)
      values.push_back(shift + scale * float((7 * i + 3 * i * i + seed) % 23 - 11) / 11);
    return values;
  };
  OnnxParts parts;
  parts.nodes = {
      OnnxNode("Sub", {"image", "shift"}, "moved"),
      OnnxNode("Div", {"moved", "scale"}, "scaled"),
      OnnxNode("Conv", {"scaled", "w0", "b0"}, "first", {{"pads", {1, 1, 1, 1}}}),
      OnnxNode("Relu", {"first"}, "near"),
      OnnxNode("MaxPool", {"near"}, "small", {{"kernel_shape", {2, 2}}, {"strides", {2, 2}}}),
      OnnxNode("Conv", {"small", "w1", "b1"}, "second"),
      OnnxNode("Relu", {"second"}, "far")};
  parts.tensors = {OnnxTensor("shift", {1, 3, 1, 1}, {-0.03f, -0.088f, -0.188f}),
                   OnnxTensor("scale", {1, 3, 1, 1}, {0.458f, 0.448f, 0.45f}),
                   OnnxTensor("w0", {8, 3, 3, 3}, numbers(216, 1, 0.4f, 0)),
                   OnnxTensor("b0", {8}, numbers(8, 2, 0.2f, 1)),
                   OnnxTensor("w1", {6, 8, 3, 3}, numbers(432, 5, 0.2f, 0)),
                   OnnxTensor("b1", {6}, numbers(6, 4, 0.2f, 1))};
  parts.outputs = {{"near", 8}, {"far", 6}};
  std::filesystem::create_directories(folder);
  const std::string stem = folder + "/" + net;
  std::ofstream(stem + "_backbone.onnx", std::ios::binary) << OnnxBytes(parts);
  std::ofstream(stem + "_taps.txt") << "near\nfar\n";
  Npz npz;
  npz.Add("lin0", {8}, std::vector<float>(8, 0.5f));
  npz.Add("lin1", {6}, std::vector<float>(6, 1));
  npz.Write(stem + "_lin.npz");
}

}  // namespace cosplat::test
