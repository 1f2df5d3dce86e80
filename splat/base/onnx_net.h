// A network stored as ONNX, run on the CPU by OpenCV's dnn: an image in, feature maps out.
// onnx_net.cpp is the only place of the libraries that includes OpenCV for networks.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "splat/base/image.h"

namespace cosplat {

// What the network holds for one of its outputs, valid until it is run again.
struct FeatureMap {
  const float* data = nullptr;  // [channels, height, width]
  int channels = 0;
  int height = 0;
  int width = 0;
};

class OnnxNet {
 public:
  // The file's one input is [1, 3, H, W] for any H and W; `outputs` name maps [1, C, h, w]. Throws
  // Error when the file cannot be read, lacks an output or takes no such images.
  //
  // Turns OpenCV's own threads off for the whole process: its convolutions round differently with
  // the number of threads. To use several cores, run a net in each of several threads.
  OnnxNet(const std::string& path, const std::vector<std::string>& outputs);
  ~OnnxNet();
  OnnxNet(OnnxNet&&) noexcept;

  const std::vector<int>& channels() const { return channels_; }  // of each output
  // Least width and height, px: below it some layer would have nothing left.
  int least_side() const { return least_side_; }

  // The outputs for an image (RGB, scaled from [0, 255] to [-1, 1]). Memory is kept from one
  // image to the next of the same size. Throws Error when it is not RGB or too small.
  std::vector<FeatureMap> Run(const Image8& image);

 private:
  struct Impl;
  std::string path_;
  std::vector<int> channels_;
  int least_side_ = 0;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosplat
