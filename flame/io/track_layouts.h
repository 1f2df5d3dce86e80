// One function per layout of tracked video, and shared helpers. Each fills a TrackedVideo except
// for the final checks, which LoadTrack makes for all layouts.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "flame/track.h"

namespace cosplat {

// The queries about images that layouts make, so that the layouts do not depend on an image
// decoder. Throws Error as ReadImageInfo and VideoReader do.
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

// The arguments of a layout's loader.
struct TrackRequest {
  TrackOptions options;
  const ImageFiles* images = nullptr;  // null: a driving sequence
};

// Implements LoadTrackedVideo and LoadDrivingSequence.
TrackedVideo LoadTrack(const std::string& path, const TrackRequest& request);

// <path>/flame_params.json with image/ or images/ (or video.mp4, .avi, .mkv) and mask/.
bool IsImavatarTrack(const std::string& path);
void LoadImavatarTrack(const std::string& path, const TrackRequest& request, TrackedVideo& video);

// <path>/transforms_train.json with transforms_test.json (or _val) and an .npz per time step.
bool IsVhapTrack(const std::string& path);
void LoadVhapTrack(const std::string& path, const TrackRequest& request, TrackedVideo& video);

// A driving sequence *.npz: expr [T, E], and optionally rot, neck_rot, jaw_rot, eye_rot,
// tra [T, 3], fx, fy, cx, cy, resolutions (height, width), extr (cam_from_world, OpenGL axes), fps.
bool IsDrivingNpz(const std::string& path);
void LoadDrivingNpz(const std::string& path, TrackedVideo& video);

// Checks the image of a frame by its header. Returns "" if `frame` (whose image_path and mask_path
// are set) is usable, after scaling its camera from full size (`lens`) to the image's size divided
// by the resolution; otherwise returns the reason.
std::string FinishTrackedFrame(const Camera& lens,
                               const TrackRequest& request,
                               TrackedFrame& frame);

// The same for the camera only.
Camera CameraAt(const Camera& lens, int width, int height, int resolution, const Camera& pose);

// Whether a size differs by more than a pixel from another one scaled to the same height.
bool ProportionsDiffer(int width, int height, int other_width, int other_height);

// Copies numbers into `out`; returns the problem ("expression[3] is not finite"), or "".
std::string CopyFinite(const std::string& name,
                       const std::vector<double>& values,
                       std::vector<float>& out);

// Moves the last `count` time steps of video.train, with all cameras' frames, to video.test. Throws
// Error if none would remain.
void SplitLastFrames(int count, TrackedVideo& video);

}  // namespace cosplat
