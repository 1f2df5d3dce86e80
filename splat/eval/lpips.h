// LPIPS: how different two images look to a network that was trained to recognise things, its
// feature maps weighed as people judged (Zhang et al. 2018, The Unreasonable Effectiveness of Deep
// Features as a Perceptual Metric, eq. 1). Smaller is better; 0 for equal images.
//
// The network and the weights are files (docs/lpips.md tells how to make them):
//   NET_backbone.onnx  image [1, 3, H, W], RGB in [-1, 1] -> feature maps
//   NET_taps.txt       names of the outputs that are compared, in order
//   NET_lin.npz        lin0, lin1, ...: a weight for each channel of each of them
#pragma once

#include <array>
#include <string>
#include <vector>

#include "splat/base/image.h"
#include "splat/base/onnx_net.h"

namespace cosplat {

class Lpips {
 public:
  // `folder` holds one net. Throws Error when a file is missing or does not fit the others.
  explicit Lpips(const std::string& folder);

  // NET: figures of different nets cannot be compared, so it is part of the result.
  const std::string& net() const { return net_; }
  int least_side() const { return nets_[0].least_side(); }

  // Both RGB, of one size, at least least_side() wide and high; throws Error otherwise. Not from
  // several threads at once. The same bits for any number of threads.
  double Distance(const Image8& a, const Image8& b);

 private:
  Lpips(const std::string& folder, const std::string& net);

  std::string net_, backbone_;
  std::array<OnnxNet, 2> nets_;  // one for each image: they run side by side
  std::vector<std::vector<float>> weights_;
};

}  // namespace cosplat
