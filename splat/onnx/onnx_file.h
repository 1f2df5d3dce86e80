// Reads the ONNX file of a convolutional network: file -> OnnxGraph -> OnnxNet
// (splat/onnx/onnx_net.h). Knows the layers of AlexNet, VGG and SqueezeNet; refuses all others.
// Source: the operator sets 1 to 13 of https://onnx.ai, which define these layers alike.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

namespace cosplat {

// Sizes and steps of kernels, {y, x}.
using OnnxPair = std::array<int, 2>;

// A value is an array [1, channels, height, width]. Value 0 is the image, value i + 1 the result of
// layer i, which reads values before it.
struct OnnxLayer {
  enum class Kind { kConvolution, kRelu, kMaxPool, kConcat };
  Kind kind = Kind::kRelu;
  std::string name;         // as in the file, for messages
  std::vector<int> inputs;  // values; more than one only of kConcat, along the channels
  int channels = 0;         // of the result
  // Convolutions and pooling.
  OnnxPair kernel{1, 1}, stride{1, 1}, dilation{1, 1}, pad_begin{}, pad_end{};
  bool ceil = false;  // pooling: the last window may end beyond the padding
  // Convolutions. Adding or multiplying a number per channel is one, with a group per channel.
  int groups = 1;
  std::vector<float> weights;  // [channels, input channels / groups, kernel y, kernel x]
  std::vector<float> bias;     // [channels]
};

struct OnnxGraph {
  std::vector<OnnxLayer> layers;
  std::map<std::string, int> outputs;  // values, by name
  int ChannelsOf(int value) const { return value == 0 ? 3 : layers[size_t(value - 1)].channels; }
};

// Throws Error if the file is no ONNX network that takes one RGB image, or has other layers.
OnnxGraph ReadOnnx(const std::string& path);

// Heights and widths of all values for an image of this size; empty if some layer has nothing left,
// which is then named in *refusal.
std::vector<OnnxPair> ValueSizes(const OnnxGraph& graph, OnnxPair image, std::string* refusal);

}  // namespace cosplat
