// The blendshape map of an avatar in training: scores matched to frames at the start, fitted when
// the avatar is saved.
#pragma once

#include <optional>
#include <string>

#include "avatar/train/avatar_subject.h"
#include "avatar/train/blendshape_fit.h"
#include "flame/pose.h"

namespace cosplat {

class AvatarBlendshapes {
 public:
  // landmarks: a file of scores, or "" for none; the video's own frames are matched to it. Throws
  // Error if it is damaged or of another video. `subject` and its model must outlive this.
  AvatarBlendshapes(const std::string& landmarks,
                    const FlameModel& flame,
                    const AvatarSubject& subject);

  // Sets the avatar's map, from the track as it has been refined so far; none if there are too few
  // scores.
  void Fit(AvatarModel& avatar);

  // After Fit. One line about the map, or why there is none; "" without a file. Ends with a
  // newline.
  std::string Summary() const;
  // The same as blendshapes.json in the run's folder; removes that of an earlier run.
  void Write(const std::string& folder) const;

 private:
  std::string landmarks_;
  const AvatarSubject& subject_;
  FlamePoser<float> poser_;
  BlendshapeSamples train_, test_;
  std::optional<BlendshapeFit> fit_;
  BlendshapeFitFigures on_test_;
  std::string problem_;  // why there is no map
};

}  // namespace cosplat
