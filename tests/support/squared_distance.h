// A distance for the crop loss (splat/train/loss/crop_loss.h) that needs no network.
#pragma once

#include "splat/train/loss/crop_loss.h"

namespace cosplat::test {

// Mean squared difference, as LossWeights::mse weighs it.
class SquaredDistance : public ImageDistance {
 public:
  explicit SquaredDistance(int min_side = 1) : min_side_(min_side) {}
  int min_side() const override { return min_side_; }
  double Evaluate(View<const float> rendered,
                  View<const float> target,
                  int width,
                  int height,
                  std::vector<float>& d_rendered) override {
    const double mean = 1.0 / (3.0 * width * height);
    d_rendered.resize(rendered.size());
    double sum = 0;
    for (size_t i = 0; i < rendered.size(); ++i) {
      const double difference = double(rendered[i]) - target[i];
      sum += difference * difference;
      d_rendered[i] = float(2 * mean * difference);
    }
    return mean * sum;
  }

 private:
  const int min_side_;
};

}  // namespace cosplat::test
