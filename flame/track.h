// A tracked head video: images, masks, cameras and FLAME parameters per frame.
//
// flame/io/{imavatar,vhap,insta,metrical,smirk,driving_npz}.cpp read the layouts written by
// trackers into this common structure; the avatar trainer and the player's driving mode use it.
// Lengths are in metres of the FLAME model: if a layout enlarges the mesh (IMavatar x4), its camera
// translations are divided; tracks in other units are converted.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "flame/model.h"
#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/base/skipped.h"
#include "splat/media/image_io.h"

namespace cosplat {

struct TrackedFrame {
  std::string name;        // stem of the image file, or the frame number in a video
  std::string image_path;  // empty: frame `video_frame` of TrackedVideo::video_path, or no image
  std::string mask_path;   // empty: alpha is the image's fourth channel, or absent
  int video_frame = -1;
  int orientation = 1;   // EXIF's, by which the image is turned
  int timestep = 0;      // frames with equal timestep show the same moment
  int camera_index = 0;  // of several cameras
  Camera camera;         // at the size that LoadTrackedImage returns
  FlameParams params;    // shape and static_offset are left empty here: see TrackedVideo
  bool has_image = true;
  std::shared_ptr<const Image8> image;  // used instead of a file; has the camera's size
};

struct TrackedVideo {
  std::string source;  // folder or file as given
  std::string layout;  // "imavatar", "vhap", "insta", "metrical-tracker", "smirk", "npz"
  std::string video_path;
  std::shared_ptr<VideoReader> video;  // of video_path, if there is one
  double frames_per_second = 0;        // time steps per second; 0 if unknown
  double unit = 1;                     // metres per unit of the track as stored
  int model_vertices = 0;              // of the model that it is of, without a mouth; 0: unknown
  std::string model_sha256;            // FlameModel::sha256 of a model that is not FLAME, or empty
  std::vector<float> shape;            // the subject's
  // [V, 3] metres, or empty; VHAP's export may have 120 rows more, for teeth (flame/mouth.h)
  std::vector<float> static_offset;
  std::vector<TrackedFrame> train;
  std::vector<TrackedFrame> test;
  std::vector<SkippedFrame> skipped;  // unusable frames, each with the reason
  std::vector<std::string> notes;     // what a user should know of how it was read
  bool masks_inverted = false;        // their masks, or alpha, are dark where the person is
  // Each frame has a camera of its own about a head whose root stays in FLAME's rest place, as the
  // tracker wrote it: the head's motion is in the cameras. See MoveHead.
  bool head_is_fixed = false;
};

struct TrackOptions {
  int test_frames = -1;  // last N frames are the test set; -1: the layout's own split, or 20 %
  int resolution = 1;    // -r: cameras and images are divided by this
  // The model that the video was tracked with. Layouts that move the camera about a fixed head need
  // it to move the head instead; without it, their head_is_fixed remains. Throws Error if the track
  // is of another model, whose coefficients mean something else; where it does not say,
  // it is FLAME's, not that of a model with landmarks of its own.
  const FlameModel* flame = nullptr;
};

// The layout of `path` as in TrackedVideo::layout, or "" if it is no tracked video: a folder with
// flame_params.json (IMavatar), transforms_train.json (VHAP, GaussianAvatars; INSTA),
// checkpoint/*.frame (metrical-tracker) or smirk.npz, or a driving sequence *.npz. Throws Error if
// a file that decides it is damaged.
std::string TrackLayoutOf(const std::string& path);

// Throws Error if `path` is no such folder, if the set is empty or if more than a third of the
// frames are unusable. If a single camera only translates, without rotating, the camera is held
// still and the head is moved instead; MoveHead does the same for a rotating one.
TrackedVideo LoadTrackedVideo(const std::string& path, const TrackOptions& options);

// Compares masks and alpha of some frames with where the posed head is: inverted masks are taken as
// such, with a note; masks that miss the head are noted. flame: as in TrackOptions. Throws Error if
// they show nothing at all.
void SettleMasks(const FlameModel& flame, TrackedVideo& video);

// The same for parameters and cameras only, of such a folder or of a driving sequence *.npz, whose
// frames are all in `test`. Ignores images, so that a program that calls only this function does
// not link an image decoder. flame: as in TrackOptions.
TrackedVideo LoadDrivingSequence(const std::string& path, const FlameModel* flame = nullptr);

// If the head is fixed: replaces the moving camera by one that stands still in front of the head
// (it looks along -z of FLAME's frame, y up), and moves the head's root so that every frame looks
// the same. Vertices in the camera are unchanged, whatever shape and expression, since the root
// rotates about its joint as `flame` poses it (coefficients beyond the model's are left out).
// Throws Error as FlamePoser does.
void MoveHead(const FlameModel& flame, TrackedVideo& video);

constexpr double kFaceSize = 0.14;  // metres
// Depth of the head's root before the camera, metres.
double DepthOfHead(const TrackedFrame& frame);

// How wide a face is in the frame's image, in px; at most as from a centimetre's distance.
double FaceSizeIn(const TrackedFrame& frame);

// What is lost of expressions that the model has no directions for, as FLAME's Open model has none:
// "50 of 100 expression coefficients are used, ..."; empty if nothing is.
std::string UnusedExpressions(const FlameModel& flame,
                              const std::vector<const FlameParams*>& faces);

// Whether any frame's eyelids are moved.
bool TracksEyelids(const TrackedVideo& video);

// EyelidsToExpression of flame/eyelids.h for every frame. Tracks loaded with a model that has
// eyelids have it done.
void EyelidsToExpression(const FlameModel& model, TrackedVideo& video);
// The reverse.
void EyelidsFromExpression(const FlameModel& model, TrackedVideo& video);

// The frames of both sets in order of time, as pointers into `video`. If several cameras show a
// moment, only the frame of the first camera is included.
std::vector<const TrackedFrame*> InstantsOf(const TrackedVideo& video);

// The frames of both sets, of all cameras, in order of time.
std::vector<TrackedFrame*> FramesInOrder(TrackedVideo& video);

// RGBA at the frame's camera size, or RGB if there is neither mask nor alpha. Images in memory are
// returned unchanged. Throws Error naming the file if image or mask is missing or differs in size.
Image8 LoadTrackedImage(const TrackedVideo& video, const TrackedFrame& frame);

// Whether a tracked video's images, masks, cameras and parameters tell one story: what would train
// into something wrong without an error, for `cosplat check` and before the first step of training.
//
// Looks at 24 frames at most, those that move most, and their neighbours: heads outside of the
// image or of the mask, or of another size than the masks'; images upside down, mirrored, of other
// moments than their parameters, or without content; expressions that the model cannot have. After
// SettleMasks. Images that cannot be used are noted and left out, as in training. flame: as in
// TrackOptions. Throws Error as FlamePoser does, or if there are no other images.
std::vector<Finding> CheckTrack(const FlameModel& flame, const TrackedVideo& video);

// A frame's mesh: [V, 3], world units. Coefficients that the model lacks do not move it.
std::vector<float> TrackedVertices(const FlameModel& flame,
                                   const TrackedVideo& video,
                                   const TrackedFrame& frame);

// Whether one camera that stands still shows all frames, so that its focal length may be the
// tracker's assumption. Several are calibrated to each other, and one that moves by its motion.
bool HasOneStillCamera(const TrackedVideo& video);

// Multiplies the camera's focal lengths, and the depth of every head in it, so that each head keeps
// its size in the image and only its perspective changes. The poses stay. Throws Error unless
// HasOneStillCamera.
void ScaleFocal(const FlameModel& flame, double scale, TrackedVideo& video);

}  // namespace cosplat
