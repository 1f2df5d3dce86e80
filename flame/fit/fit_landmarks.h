// FLAME's parameters of a video from the landmarks of its frames.
//
// ChooseFaces -> FitLandmarks -> a track in the form that every layout's reader gives
// (flame/track.h). A maximum-a-posteriori estimate: landmarks reprojected through one pinhole
// camera, robustly, against Gaussian priors of shape and expression (FLAME's coefficients have unit
// variance) and of the joints, and against the neighbouring frames. The minimiser is Ceres
// Solver's. Uses no earlier track and no guess by the user. Bit-identical for any number of
// threads.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "flame/fit/choose_faces.h"
#include "flame/fit/landmark_embedding.h"
#include "flame/track.h"
#include "splat/base/camera.h"
#include "splat/base/image.h"

namespace cosplat {

constexpr int kMinFaces = 3;  // that a track is fitted to

struct LandmarkFitOptions {
  double focal = 0;  // px of the whole frame; 0: found, which needs a head that turns
  // Where in a frame the images are: the lens is in the middle of the whole frame.
  std::optional<FrameCrop> crop;
  // At most as many coefficients, and no more than the model has; eyelids come on top.
  int shape_count = 100, expression_count = 100;
  // The image of a frame with a face: RGB, or RGBA with a matte; called in order. Empty: landmarks
  // alone.
  std::function<Image8(size_t frame)> image;
  // Draws the mesh's outline to the rims of the images' mattes, and finds the hair's static offset.
  bool silhouette = false;
  std::string source = "landmarks";  // named in errors
};

struct FittedFrame {
  FlameParams params;                         // without shape; eyelids are in FlameParams::eyelids
  std::vector<std::array<double, 2>> points;  // [L] px, where the fitted mesh has the landmarks
  double error = 0;                           // px, mean distance from the landmarks
  double turned = 0;                          // degrees between the face and the camera
};

struct LandmarkFit {
  Camera camera;                     // stands still in front of the head, which moves
  std::vector<float> shape;          // the subject's
  std::vector<float> static_offset;  // [V, 3] metres, of hair that mattes show; or empty
  std::vector<std::optional<FittedFrame>> frames;  // none where there was no face
  double error = 0;                                // px, mean over the fitted frames
  // How far points' brightness is from their mean, 8-bit levels: by the landmarks alone, and after
  // each round of refinement. Points that were not fitted to; empty without images.
  std::vector<double> brightness_spread;
};

// faces: one per frame of a video of width x height pixels. `progress`, if given, is called with
// increasing `done`. Throws Error if fewer than three frames have a face or the fit does not
// converge to finite numbers.
LandmarkFit FitLandmarks(const FlameModel& model,
                         const LandmarkEmbedding& embedding,
                         const std::vector<std::optional<ObservedFace>>& faces,
                         int width,
                         int height,
                         const LandmarkFitOptions& options,
                         const std::function<void(int done, int total)>& progress = {});

// Measures what the frames' parameters are now against the landmarks that they were fitted to:
// points, error and turned of each, and the mean error.
void MeasureFit(const FlameModel& model,
                const LandmarkEmbedding& embedding,
                const std::vector<std::optional<ObservedFace>>& faces,
                LandmarkFit& fit);

// Makes a track that there is more exact, by what its images show: points of the surface keep their
// brightness from frame to frame (flame/fit/face_texture.h); frames stay near the given parameters
// and near the neighbouring frames. Shape and cameras are left as they are.
//
// Refines pose, translation and expression of all frames, with the model that `video` was loaded
// with. image: RGB, or RGBA with a matte, of the camera's size; called once per frame, in order of
// time. progress, if given, is called with increasing `done`. Returns how far points' brightness is
// from their mean, in 8-bit levels: before, and after each round; of points that were not fitted
// to. Throws Error if several cameras show a moment, or if the frames' lenses differ. Bit-identical
// for any number of threads.
std::vector<double> RefineTrack(const FlameModel& model,
                                TrackedVideo& video,
                                const std::function<Image8(const TrackedFrame&)>& image,
                                const std::function<void(int done, int total)>& progress = {});

}  // namespace cosplat
