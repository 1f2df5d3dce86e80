// LPIPS: the perceptual difference of two images, from the feature maps of a recognition network
// with weights fitted to human judgements (Zhang et al. 2018, The Unreasonable Effectiveness of
// Deep Features as a Perceptual Metric, eq. 1). Smaller is better; 0 for equal images.
//
// The network and the weights are files (docs/lpips.md describes how to make them):
//   NET_backbone.onnx  image [1, 3, H, W], RGB in [-1, 1] -> feature maps
//   NET_taps.txt       names of the outputs to compare, in order
//   NET_lin.npz        lin0, lin1, ...: per-channel weights of each output
#pragma once

#include <array>
#include <string>
#include <vector>

#include "splat/base/image.h"
#include "splat/onnx/onnx_net.h"
#include "splat/train/loss/crop_loss.h"

namespace cosplat {

class Lpips : public ImageDistance {
 public:
  // `folder` must contain one net. Throws Error if a file is missing or does not match the others.
  explicit Lpips(const std::string& folder);

  // NET. Distances of different nets are not comparable, so this is part of the result.
  const std::string& net() const { return net_; }
  int min_side() const override { return nets_[0].min_side(); }

  // Both images must be RGB, of equal size and at least min_side() wide and high; throws Error
  // otherwise. Not thread-safe. Bit-identical for any number of threads.
  double Distance(const Image8& a, const Image8& b);
  // The same of images in training, with the gradient.
  double Evaluate(View<const float> rendered,
                  View<const float> target,
                  int width,
                  int height,
                  std::vector<float>& d_rendered) override;

 private:
  Lpips(const std::string& folder, const std::string& net);
  std::vector<float> ToPlanes(const Image8& image) const;
  // Compares planes in [-1, 1]; `keeps` what the gradient with respect to `a` needs.
  double Run(
      const std::vector<float>& a, const std::vector<float>& b, int width, int height, bool keeps);

  std::string net_, backbone_;
  std::array<OnnxNet, 2> nets_;  // one per image: they run in parallel
  std::vector<FeatureMap> maps_a_, maps_b_;
  std::vector<std::vector<float>> weights_;
};

}  // namespace cosplat
