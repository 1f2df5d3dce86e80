// Static scenes for the training loop of splat/train/trainer.h.
#pragma once

#include <utility>
#include <vector>

#include "splat/io/dataset.h"
#include "splat/render/rasterizer.h"
#include "splat/train/subject/frame_reader.h"
#include "splat/train/subject/subject.h"

namespace cosplat {

// Everything that the training of a static scene starts from.
struct TrainingScene {
  std::vector<TrainFrame> train, test;
  std::vector<float> points;          // [P, 3] world units; empty where the data has none
  std::vector<uint8_t> point_colors;  // [P, 3] RGB
  float extent = 1;                   // as in SceneData
  bool renderings = false;            // likewise
};

// A static scene: the Gaussians already are in the world frame.
class SceneSubject : public Subject {
 public:
  SceneSubject(std::vector<TrainFrame> frames, float extent)
      : frames_(std::move(frames)), extent_(extent) {}
  size_t frame_count() const override { return frames_.size(); }
  const TrainFrame& frame(size_t i) const override { return reader_.At(frames_[i]); }
  const Camera& camera(size_t i) const override { return frames_[i].camera; }
  void Expect(size_t i) override { reader_.Expect(frames_[i]); }
  size_t max_reduced_bytes() const override { return max_reduced_bytes_; }
  void LimitReduced(size_t bytes) { max_reduced_bytes_ = bytes; }
  // In memory or not.
  const std::vector<TrainFrame>& frames() const { return frames_; }
  float extent() const override { return extent_; }
  bool is_static() const override { return true; }
  WorldGaussians ToWorld(const Gaussians& gaussians, size_t) override { return ViewOf(gaussians); }
  WorldGradients WorldGradientsFor(Gaussians& gradients,
                                   Buffer<float>& screen,
                                   Stream& stream) override {
    WorldGradients view = GradientViewOf(gradients, screen, stream);
    view.drawn_groups_only = true;  // only Adam reads them
    return view;
  }

 private:
  std::vector<TrainFrame> frames_;
  mutable FrameReader reader_;
  size_t max_reduced_bytes_ = size_t(-1);
  float extent_;
};

// Reads every view's image, in parallel, and keeps the first that fit into `max_bytes` together,
// at four bytes a pixel; the others are read again when they are needed. Views with an unusable
// image move from `views` to `skipped`.
std::vector<TrainFrame> LoadTrainFrames(std::vector<SceneView>& views,
                                        std::vector<SkippedFrame>& skipped,
                                        size_t max_bytes = size_t(-1));

// Bytes of a view's image in memory, at four a pixel.
size_t ImageBytes(const Camera& camera);

// The same for the training and the test views of a scene, with everything else that training
// needs. Throws Error if too many views cannot be used (splat/base/skipped.h).
TrainingScene LoadTrainingScene(SceneData& scene, size_t max_bytes = size_t(-1));

}  // namespace cosplat
