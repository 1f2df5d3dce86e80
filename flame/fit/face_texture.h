// What the points of a head look like, as the mean over a video's frames. Private to flame/fit/.
//
// Frames and a track of them -> FaceTexture::Measure -> brightness per point -> FieldCost, which
// improves the track; then again. An active appearance model (Cootes et al. 2001; Matthews
// and Baker 2004) on FLAME's surface, whose mean is measured anew as the track improves.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "flame/fit/field_cost.h"
#include "flame/fit/points_on_flame.h"

namespace cosplat::internal {

constexpr int kMaxPhotometricRounds = 6;

class FaceTexture {
 public:
  // Keeps references to views and fields (ReadFields).
  FaceTexture(const FlameModel& model,
              int shape_count,
              int expression_count,
              const std::vector<std::optional<FrameView>>& views,
              const std::vector<FrameFields>& fields);

  // Measures, calls fit_frames, which changes `frames`, and so on until points that are held out
  // do not gain, or for kMaxPhotometricRounds. Returns held_out_spread() before and after each
  // round; a last round that made it worse is undone.
  std::vector<double> Refine(const std::vector<double>& shape,
                             double log_focal,
                             std::vector<std::vector<double>>& frames,
                             const std::function<void()>& fit_frames);

  // Measures it with the track as it is. frames: parameters as PointsOnFlame's, empty where there
  // is no face.
  void Measure(const std::vector<double>& shape,
               double log_focal,
               const std::vector<std::vector<double>>& frames);

  // What the last measurement wants of frame f, with the shape as it was then; null if there is
  // none, or no point is visible.
  std::unique_ptr<FieldCost> Cost(size_t f) const;
  // Mean over the points that Cost leaves out: how far frames differ from the mean, in 8-bit
  // levels. A better track lowers it; one that only follows the noise of the other points does not.
  // Not a number if no such point is visible.
  double held_out_spread() const { return held_out_spread_; }

 private:
  bool measured() const { return !visible_.empty(); }
  struct Seen {
    double value = 0, facing = 0;  // cosine between normal and viewer; 0: not visible
  };
  std::vector<Seen> See(const std::vector<double>& shape,
                        double log_focal,
                        const std::vector<double>& frame,
                        size_t f) const;

  const std::vector<std::optional<FrameView>>& views_;
  const std::vector<FrameFields>& fields_;
  const PointsOnFlame points_;
  const PointsOnFlame corners_;  // three per point, of its triangle
  std::vector<double> shape_;    // of the last measurement
  std::vector<std::vector<FieldPoint>> visible_;
  double held_out_spread_ = 0;
};

}  // namespace cosplat::internal
