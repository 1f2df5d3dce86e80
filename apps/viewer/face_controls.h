// The sliders of a face: expression coefficients and joints.
//
// Panels set values -> FaceControls::Face -> Shot, while nothing else drives the avatar.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "avatar/model/avatar_model.h"
#include "splat/base/rng.h"

namespace cosplat::viewer {

// One slider. Its value is a coefficient, or radians of an axis-angle's component.
struct Slider {
  std::string name;
  float least = -1, most = 1;
  float value = 0;
};

class FaceControls {
 public:
  FaceControls() = default;  // of a scene: no slider
  // rest: the root's pose and translation; sliders turn the head about it. Sliders of expressions
  // reach somewhat beyond what the avatar made in training, where that is known.
  FaceControls(int expression_count,
               const FlameParams& rest,
               const std::optional<TrainedRange>& trained);

  std::vector<Slider>& expressions() { return expressions_; }
  std::vector<Slider>& joints() { return joints_; }
  void SetNeutral();
  // Some expressions at once and a turned head, within what the avatar made in training.
  void SetRandom(Rng& rng);
  // As far as the sliders have it.
  void Take(const FlameParams& face);
  FlameParams Face() const;

 private:
  FlameParams rest_;
  std::vector<Slider> expressions_;
  std::vector<std::array<float, 2>> usual_;  // of each expression in training, least and most
  std::vector<Slider> joints_;               // in the order of kJointSliders
};

}  // namespace cosplat::viewer
