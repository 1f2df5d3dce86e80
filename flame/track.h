// A tracked head video: images, masks, cameras and FLAME parameters per frame.
//
// flame/io/{imavatar,vhap,driving_npz}.cpp read the layouts that trackers write into this one
// structure; the avatar trainer and the player's driving mode read it. Everything is in metres of
// the FLAME model: layouts that enlarge the mesh (IMavatar x4) have their camera translations
// divided instead.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "flame/model.h"
#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/base/image_io.h"
#include "splat/base/skipped.h"

namespace cosplat {

struct TrackedFrame {
  std::string name;        // stem of the image file, or the frame number in a video
  std::string image_path;  // empty: frame `video_frame` of TrackedVideo::video_path, or no image
  std::string mask_path;   // empty: alpha from the image's fourth channel, or none
  int video_frame = -1;
  int timestep = 0;      // frames with equal timestep show the same instant
  int camera_index = 0;  // which of several cameras
  Camera camera;         // at the size that LoadTrackedImage returns
  FlameParams params;    // shape and static_offset are left empty here: see TrackedVideo
  bool has_image = true;
  std::shared_ptr<const Image8> image;  // instead of a file, at the camera's size
};

struct TrackedVideo {
  std::string source;  // folder or file as given
  std::string layout;  // "imavatar", "vhap", "npz"
  std::string video_path;
  std::shared_ptr<VideoReader> video;  // of video_path, where there is one
  double frames_per_second = 0;        // time steps per second; 0 where the layout does not say
  std::vector<float> shape;            // the subject's
  std::vector<float> static_offset;    // [V, 3] metres, or empty
  std::vector<TrackedFrame> train;
  std::vector<TrackedFrame> test;
  std::vector<SkippedFrame> skipped;  // frames that cannot be used, each with why
};

struct TrackOptions {
  int test_frames = -1;  // last N frames are the test set; -1: the layout's own split, or 20 %
  int resolution = 1;    // -r: cameras and images are divided by this
};

// Finds the layout by what `path` is: a folder with flame_params.json (IMavatar) or
// transforms_train.json (VHAP, GaussianAvatars). Throws Error when there is none of these, when the
// set is empty or when more than a third of the frames cannot be used. Where one camera only ever
// moves without turning, it is taken to stand still and the head to move instead.
TrackedVideo LoadTrackedVideo(const std::string& path, const TrackOptions& options);

// The same for parameters and cameras alone, of such a folder or of a driving sequence *.npz, whose
// frames are all in `test`. Nothing about images is looked at, and a program that calls only this
// links no decoder of images.
TrackedVideo LoadDrivingSequence(const std::string& path);

// Both sets' frames in order of time; of several cameras' views of an instant the first camera's.
// They point into `video`.
std::vector<const TrackedFrame*> InstantsOf(const TrackedVideo& video);

// RGBA at the frame's camera size, or RGB when there is neither mask nor alpha. An image in memory
// is returned as it is. Throws Error (naming the file) on a missing image or mask or one whose size
// disagrees.
Image8 LoadTrackedImage(const TrackedVideo& video, const TrackedFrame& frame);

}  // namespace cosplat
