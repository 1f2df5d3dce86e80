// Static scenes for the training loop of splat/train/trainer.h.
#pragma once

#include <utility>
#include <vector>

#include "splat/io/dataset.h"
#include "splat/render/rasterizer.h"
#include "splat/train/subject.h"

namespace cosplat {

// Everything that the training of a static scene starts from.
struct TrainingScene {
  std::vector<TrainFrame> train, test;
  std::vector<float> points;           // [P, 3] world units; empty where the data has none
  std::vector<uint8_t> point_colors;   // [P, 3] RGB
  float extent = 1;                    // as in SceneData
  bool white_background_hint = false;  // likewise
};

// A static scene: the Gaussians already are in the world frame.
class SceneSubject : public Subject {
 public:
  SceneSubject(std::vector<TrainFrame> frames, float extent)
      : frames_(std::move(frames)), extent_(extent) {}
  size_t frame_count() const override { return frames_.size(); }
  const TrainFrame& frame(size_t i) const override { return frames_[i]; }
  float extent() const override { return extent_; }
  bool is_static() const override { return true; }
  WorldGaussians Place(const Gaussians& gaussians, size_t) override { return ViewOf(gaussians); }
  WorldGradients WorldGradientsFor(Gaussians& gradients,
                                   Buffer<float>& screen,
                                   Stream& stream) override {
    WorldGradients view = GradientViewOf(gradients, screen, stream);
    view.drawn_groups_only = true;  // only Adam reads them
    return view;
  }

 private:
  std::vector<TrainFrame> frames_;
  float extent_;
};

// Loads every view's image, in parallel. Views with an unusable image move from `views` to
// `skipped`.
std::vector<TrainFrame> LoadTrainFrames(std::vector<SceneView>& views,
                                        std::vector<SkippedFrame>& skipped);

// The same for the training and the test views of a scene, with everything else that training
// needs. Throws Error if too many views cannot be used (splat/base/skipped.h).
TrainingScene LoadTrainingScene(SceneData& scene);

}  // namespace cosplat
