// What the points of a head look like, as the mean over a video's frames. Private to flame/fit/.
//
// Frames and a track of them -> FaceTexture::Measure -> brightness per point -> PhotometricCost,
// which improves the track; then again. An active appearance model (Cootes et al. 2001; Matthews
// and Baker 2004) on FLAME's surface, whose mean is measured anew as the track improves.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "flame/fit/band_pass.h"
#include "flame/fit/landmark_cost.h"
#include "flame/fit/points_on_flame.h"

namespace cosplat::internal {

// How a frame sees the head. Camera axes are OpenGL's: x right, y up, looking along -z.
struct FrameView {
  FitLens lens;
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  // of the head's frame to the camera's
  std::array<double, 3> translation{};                        // metres
  std::array<double, 4> box{};  // left, top, right, bottom in px: where the head and chest are
  double face_size = 0;         // px, side of a square of the face's area
};

constexpr int kMaxPhotometricRounds = 6;

// A point that a frame shows, and the brightness that it should have there.
struct TexturePoint {
  int point;
  double value, sigma;  // 8-bit levels
};

class FaceTexture {
 public:
  // views: none for frames to leave out. image(f): RGB or RGBA with a matte; asked for once, in
  // order, for every frame with a view.
  FaceTexture(const FlameModel& model,
              int shape_count,
              int expression_count,
              std::vector<std::optional<FrameView>> views,
              const std::function<Image8(size_t f)>& image);

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

  // Of the last measurement.
  bool measured() const { return !visible_.empty(); }
  const std::vector<TexturePoint>& VisibleIn(size_t f) const { return visible_[f]; }
  // Mean over the points that VisibleIn never has: how far frames differ from the mean, in 8-bit
  // levels. A better track lowers it; one that only follows the noise of the other points does not.
  // Not a number if no such point is visible.
  double held_out_spread() const { return held_out_spread_; }

  const PointsOnFlame& points() const { return points_; }
  const BandPassed& image(size_t f) const { return images_[f]; }
  const FrameView& view(size_t f) const { return *views_[f]; }

 private:
  struct Seen {
    double value = 0, facing = 0;  // cosine between normal and viewer; 0: not visible
  };
  std::vector<Seen> See(const std::vector<double>& shape,
                        double log_focal,
                        const std::vector<double>& frame,
                        size_t f) const;

  const std::vector<std::optional<FrameView>> views_;
  const PointsOnFlame points_, corners_;  // corners: three per point, of its triangle
  std::vector<BandPassed> images_;
  std::vector<std::vector<TexturePoint>> visible_;
  double held_out_spread_ = 0;
};

// Parameters: shape [S], logarithm of the focal length in px [1], frame [frame_size].
// Residuals: one per visible point, in standard deviations, robust (flame/fit/robust.h).
class PhotometricCost : public ceres::CostFunction {
 public:
  // Keeps references to what `texture` has of frame f.
  PhotometricCost(const FaceTexture& texture, size_t f);
  // Fails if a point is not in front of the camera.
  bool Evaluate(const double* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  const PointsOnFlame& points_;
  const std::vector<TexturePoint>& visible_;
  const BandPassed& image_;
  const FrameView& view_;
};

}  // namespace cosplat::internal
