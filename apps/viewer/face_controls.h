// Sliders for a face: expression coefficients and joints.
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

// One slider. Its value is a coefficient, or a component of an axis-angle vector in radians.
struct Slider {
  std::string name;
  float min = -1, max = 1;
  float value = 0;
};

class FaceControls {
 public:
  FaceControls() = default;  // for a scene: no sliders
  // rest: the root's pose and translation, relative to which the sliders turn the head. The
  // expression sliders extend somewhat beyond the range of the training frames, if that is known.
  FaceControls(int expression_count,
               const FlameParams& rest,
               const std::optional<TrainedRange>& trained);

  std::vector<Slider>& expressions() { return expressions_; }
  std::vector<Slider>& joints() { return joints_; }
  void SetNeutral();
  // Several random expressions and a turned head, within the range of the training frames.
  void SetRandom(Rng& rng);
  // Sets the sliders to `face`, as far as their ranges allow.
  void SetFace(const FlameParams& face);
  FlameParams Face() const;

 private:
  FlameParams rest_;
  std::vector<Slider> expressions_;
  std::vector<std::array<float, 2>> usual_;  // range of each expression in training
  std::vector<Slider> joints_;               // in the order of kJointSliders
};

}  // namespace cosplat::viewer
