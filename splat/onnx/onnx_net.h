// A convolutional ONNX network on the CPU, by oneDNN: image -> OnnxNet -> feature maps, and back
// from their gradients to the image's. Within the libraries, only onnx_net.cpp includes oneDNN.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace cosplat {

// One output of the network, valid until the network is run again.
struct FeatureMap {
  const float* data = nullptr;  // [channels, height, width]
  int channels = 0;
  int height = 0;
  int width = 0;
};

class OnnxNet {
 public:
  // The file's only input must be [1, 3, H, W] for any H and W; `outputs` name maps [1, C, h, w].
  // Throws Error if the file cannot be read, lacks an output, has layers that are not supported
  // (splat/onnx/onnx_file.h) or does not accept such images.
  OnnxNet(const std::string& path, const std::vector<std::string>& outputs);
  ~OnnxNet();
  OnnxNet(OnnxNet&&) noexcept;

  const std::vector<int>& channels() const { return channels_; }  // of each output
  // Minimum width and height, px, below which the output of some layer would be empty.
  int min_side() const { return min_side_; }

  // The outputs for planes [3, height, width]. Memory is reused between images of the same size.
  // keeps: what Backward needs. Each net works on the calling thread alone, so that its results are
  // bit-identical for any number of threads; to use several cores, run one net per thread. Throws
  // Error if the image is too small.
  std::vector<FeatureMap> Run(const std::vector<float>& planes, int width, int height, bool keeps);
  // Gradient with respect to the planes of the last Run, which must have kept what this needs, from
  // that with respect to each of its outputs, of their shapes.
  std::vector<float> Backward(const std::vector<std::vector<float>>& d_maps);

 private:
  struct Impl;
  std::vector<int> channels_;
  int min_side_ = 0;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosplat
