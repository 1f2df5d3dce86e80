// ONNX files of a few convolutions, written by hand as protocol buffers (the numbers of the fields
// are those of onnx.proto), and folders that `cosplat metrics --lpips` reads.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
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

// A convolution without bias whose stride is its kernel's size; the first one reads "image".
struct TinyConv {
  std::string input, output;
  int in_channels, out_channels, kernel;
  std::vector<float> weights;  // [out, in, kernel, kernel]
};

inline ProtoBytes OnnxValue(const std::string& name, int channels) {
  ProtoBytes shape;
  shape.Add(1, ProtoBytes().Add(1, 1)).Add(1, ProtoBytes().Add(1, channels));
  for (const char* free : {"height", "width"}) shape.Add(1, ProtoBytes().Add(2, free));
  const ProtoBytes tensor = ProtoBytes().Add(1, 1).Add(2, shape);  // 1: float
  return ProtoBytes().Add(1, name).Add(2, ProtoBytes().Add(1, tensor));
}

inline ProtoBytes OnnxConv(const TinyConv& conv) {
  ProtoBytes node;
  node.Add(1, conv.input).Add(1, conv.output + ".weight").Add(2, conv.output);
  node.Add(3, "node_" + conv.output).Add(4, "Conv");
  for (const char* name : {"kernel_shape", "strides"})
    node.Add(5, ProtoBytes().Add(1, name).Add(8, conv.kernel).Add(8, conv.kernel).Add(20, 7));
  return node;
}

inline ProtoBytes OnnxWeights(const TinyConv& conv) {
  std::string raw(conv.weights.size() * sizeof(float), '\0');
  std::memcpy(raw.data(), conv.weights.data(), raw.size());
  ProtoBytes tensor;
  for (const int extent : {conv.out_channels, conv.in_channels, conv.kernel, conv.kernel})
    tensor.Add(1, extent);
  return tensor.Add(2, 1).Add(8, conv.output + ".weight").Add(9, raw);
}

// Every convolution's output is one of the net's.
inline std::string TinyOnnx(const std::vector<TinyConv>& convs) {
  ProtoBytes graph;
  for (const TinyConv& conv : convs) graph.Add(1, OnnxConv(conv));
  graph.Add(2, "tiny");
  for (const TinyConv& conv : convs) graph.Add(5, OnnxWeights(conv));
  graph.Add(11, OnnxValue("image", convs[0].in_channels));
  for (const TinyConv& conv : convs) graph.Add(12, OnnxValue(conv.output, conv.out_channels));
  return ProtoBytes().Add(1, 6).Add(7, graph).Add(8, ProtoBytes().Add(1, "").Add(2, 11)).bytes();
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

}  // namespace cosplat::test
