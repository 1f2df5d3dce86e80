// An ONNX network run on the CPU by OpenCV's dnn module: image -> OnnxNet -> feature maps. Within
// the libraries, only onnx_net.cpp includes OpenCV for networks.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "splat/base/image.h"

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
  // Throws Error if the file cannot be read, lacks an output or does not accept such images.
  //
  // Disables OpenCV's threads for the whole process, since its convolutions round differently for
  // different numbers of threads. To use several cores, run one net per thread.
  OnnxNet(const std::string& path, const std::vector<std::string>& outputs);
  ~OnnxNet();
  OnnxNet(OnnxNet&&) noexcept;

  const std::vector<int>& channels() const { return channels_; }  // of each output
  // Minimum width and height, px, below which the output of some layer would be empty.
  int least_side() const { return least_side_; }

  // The outputs for an image (RGB, scaled from [0, 255] to [-1, 1]). Memory is reused between
  // images of the same size. Throws Error if the image is not RGB or too small.
  std::vector<FeatureMap> Run(const Image8& image);

 private:
  struct Impl;
  std::string path_;
  std::vector<int> channels_;
  int least_side_ = 0;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosplat
