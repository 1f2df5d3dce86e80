// One function per layout of tracked video, and what they share. Each fills everything of a
// TrackedVideo but the final checks, which LoadTrack makes for all.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "flame/track.h"

namespace cosplat {

// What layouts ask of images, so that they themselves need no decoder. Throws Error as
// ReadImageInfo and VideoReader do.
class ImageFiles {
 public:
  struct Video {
    std::shared_ptr<VideoReader> reader;
    int frame_count = 0;
    ImageInfo size;
  };
  virtual ~ImageFiles() = default;
  virtual ImageInfo Info(const std::string& image) const = 0;
  virtual Video OpenVideo(const std::string& path) const = 0;
};

// What is asked of a layout.
struct TrackRequest {
  TrackOptions options;
  const ImageFiles* images = nullptr;  // null: a driving sequence
};

// Either of LoadTrackedVideo and LoadDrivingSequence.
TrackedVideo LoadTrack(const std::string& path, const TrackRequest& request);

// <path>/flame_params.json with image/ or images/ (or video.mp4, .avi, .mkv) and mask/.
bool IsImavatarTrack(const std::string& path);
void LoadImavatarTrack(const std::string& path, const TrackRequest& request, TrackedVideo& video);

// <path>/transforms_train.json with transforms_test.json (or _val) and an .npz per time step.
bool IsVhapTrack(const std::string& path);
void LoadVhapTrack(const std::string& path, const TrackRequest& request, TrackedVideo& video);

// A driving sequence *.npz: expr [T, E], and of rot, neck_rot, jaw_rot, eye_rot, tra [T, 3], fx,
// fy, cx, cy, resolutions (height, width), extr (cam_from_world, OpenGL axes), fps what
// there is.
bool IsDrivingNpz(const std::string& path);
void LoadDrivingNpz(const std::string& path, TrackedVideo& video);

// The image of a frame, checked as far as its header tells. Empty when `frame` (whose image_path
// and mask_path are set) is usable, its camera brought from full size (`lens`) to the image's
// divided by the resolution; otherwise why it is not. Forgets the mask where the image has alpha.
std::string FinishTrackedFrame(const Camera& lens,
                               const TrackRequest& request,
                               TrackedFrame& frame);

// The same for the camera alone.
Camera CameraAt(const Camera& lens, int width, int height, int resolution, const Camera& pose);

// More than a pixel between a size and another one scaled to the same height.
bool ProportionsDiffer(int width, int height, int other_width, int other_height);

// Copies numbers into `out`; returns the problem ("expression[3] is not finite") or nothing.
std::string CopyFinite(const std::string& name,
                       const std::vector<double>& values,
                       std::vector<float>& out);

// Moves the last `count` frames of video.train to video.test. Error when none would remain.
void SplitLastFrames(int count, TrackedVideo& video);

}  // namespace cosplat
