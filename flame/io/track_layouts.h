// One function per layout of tracked video, and shared helpers. Each fills a TrackedVideo except
// for the final checks, which LoadTrack makes for all layouts.
#pragma once

#include <array>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "flame/track.h"
#include "splat/base/data_files.h"

namespace cosplat {

class JsonField;
class Npz;
struct NpyArray;

// The queries about images that layouts make, so that the layouts do not depend on an image
// decoder. Throws Error as ReadImageInfo and VideoReader do.
class ImageFiles {
 public:
  struct Video {
    std::shared_ptr<VideoReader> reader;
    int frame_count = 0;
    ImageInfo size;
    std::vector<std::string> notes;
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

// Recognises tracks in millimetres, centimetres and others by the size at which the head is seen,
// sets video.unit and makes the lengths metres; offsets of a track in metres may still be in the
// unit of the file of `flame`, or null. Throws Error for a track so far from the origin that floats
// have lost it.
void ConvertToMetres(const FlameModel* flame, TrackedVideo& video);

// "imavatar": <path>/flame_params.json with image/ or images/ (or video.mp4, .avi, .mkv) and mask/.
void LoadImavatarTrack(const std::string& path, const TrackRequest& request, TrackedVideo& video);

// "vhap": <path>/transforms_train.json with transforms_test.json (or _val) and an .npz per time
// step.
void LoadVhapTrack(const std::string& path, const TrackRequest& request, TrackedVideo& video);

// The subject's shape and offsets from an .npz of VHAP or GaussianAvatars.
void ReadVhapSubject(const Npz& npz, TrackedVideo& video);

// "insta": <path>/transforms_train.json with transforms_test.json (or _val), or transforms.json;
// images; and the tracker's checkpoint/, for what INSTA's files lack.
void LoadInstaTrack(const std::string& path, const TrackRequest& request, TrackedVideo& video);

// "metrical-tracker": <path>/checkpoint/NUMBER.frame with images/, image/ or input/ and mask/.
void LoadMetricalTrack(const std::string& path, const TrackRequest& request, TrackedVideo& video);

// One of that tracker's checkpoints: parameters with the subject's shape, and the camera (size,
// intrinsics, pose). The head is in FLAME's rest place. Throws Error if the file cannot be read;
// returns what is wrong with its numbers, if anything.
std::string ReadMetricalFrame(const std::string& path, FlameParams& params, Camera& camera);

// Moves the shape that every frame of such checkpoints repeats to the video: its median, so that a
// few other frames do not matter, which are skipped.
void SettleShape(TrackedVideo& video);

// "smirk": what SMIRK's encoder returns, in an .npz. `npz` is <path>/smirk.npz with images/ or
// image/ (or a video) and mask/, or a driving sequence.
void LoadSmirkTrack(const std::string& path,
                    const Npz& npz,
                    const TrackRequest& request,
                    TrackedVideo& video);
// Whether an .npz has SMIRK's arrays.
bool IsSmirkNpz(const Npz& npz);

// "npz": a driving sequence: expr [T, E], and optionally rot, neck_rot, jaw_rot, eye_rot,
// tra [T, 3], fx, fy, cx, cy, resolutions (height, width), extr (cam_from_world, OpenGL axes), fps.
// Or GaussianAvatars' flame_param.npz: expr, and optionally rotation, neck_pose, jaw_pose,
// translation [T, 3], eyes_pose [T, 6] (left, right), dynamic_offset (which must be zero); with
// static_offset it is also the subject's: shape. Rows of zeros are moments without a frame.
void LoadDrivingNpz(const Npz& npz, TrackedVideo& video);

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
// The same for row `row` of an array [T, ...].
std::string CopyRow(const std::string& name,
                    const NpyArray& array,
                    size_t row,
                    std::vector<float>& out);

// The median of each column of `rows`, which have one length; numbers that are not finite do not
// count. Throws Error(file, name, ...) if a column has none.
std::vector<float> MedianOf(const std::string& file,
                            const std::string& name,
                            const std::vector<std::vector<float>>& rows);

// Appends the frame to `kept`, or to the skipped ones if there is a problem with it.
void KeepOrSkip(TrackedFrame frame,
                const std::string& problem,
                std::vector<TrackedFrame>& kept,
                TrackedVideo& video);

// Reads the first three rows of transform_matrix, 3x4 or 4x4; returns what is wrong with it, if
// anything.
// `transposed` counts those in the order of columns.
std::string CopyTransform(const JsonField& field,
                          size_t& transposed,
                          std::array<double, 12>& matrix);
// What is said of them.
void NoteTransposed(const std::string& file, size_t transposed, TrackedVideo& video);

// What the frames of a transforms file are read with.
struct Transforms {
  const std::string& folder;
  const JsonField& file;
  const TrackRequest& request;
  DataFiles files;        // of the folder
  size_t transposed = 0;  // matrices, as CopyTransform counts them
};

// Reads a file's frames. `load` fills one, which has its name and as time step its place in the
// list, and returns why it is unusable, if it is. folder: of the files that frames name.
void LoadTransforms(const std::string& file,
                    const std::string& folder,
                    const TrackRequest& request,
                    std::string (*load)(const JsonField&, Transforms&, TrackedFrame&),
                    std::vector<TrackedFrame>& frames,
                    TrackedVideo& video);

// Skips frames with expressions, angles or a distance that no head has.
void SkipImpossible(TrackedVideo& video);

void SortByTime(std::vector<TrackedFrame>& frames);

// Moves the last `count` time steps of video.train, with all cameras' frames, to video.test. Throws
// Error if none would remain.
void SplitLastFrames(int count, TrackedVideo& video);

// The number of test frames asked for, or a fifth of the usable ones and no more than `at_most`.
int TestFrameCount(const TrackOptions& options,
                   size_t usable,
                   int at_most = std::numeric_limits<int>::max());

// Images by frame name in a folder, or a video's frames; masks.
struct TrackFiles {
  const ImageFiles* images = nullptr;
  std::string image_folder;  // or empty: a video, or nothing
  std::string mask_folder;   // or empty
  std::shared_ptr<DataFiles> in_image_folder, in_mask_folder;
  ImageFiles::Video video;  // or none
};

// The first of `image_folders` in folder `path`, or (or_video) video.mp4, .avi or .mkv, and mask/
// or masks/. Throws Error if there is none of them. Empty if `images` is null.
TrackFiles FindTrackFiles(const std::string& path,
                          const std::vector<std::string>& image_folders,
                          bool or_video,
                          const ImageFiles* images,
                          TrackedVideo& video);

// Sets the paths of image and mask by the frame's name, if images are asked for, and finishes the
// frame; returns what is missing or wrong.
std::string FindAndFinish(const Camera& lens,
                          const TrackRequest& request,
                          const TrackFiles& files,
                          const TrackedVideo& video,
                          TrackedFrame& frame);

// <folder>/<name> of the first of `names` that exists, or empty.
std::string FirstThatExists(const std::string& folder, const std::vector<std::string>& names);

// The number that a name consists of ("00012" -> 12), if it is one.
std::optional<int> NumberIn(const std::string& name);

// The files of a folder with this ending, or its images if there is none, by the number that is
// their name. Returns the first whose name is no number or that of another, or "".
std::string NumberedFiles(const std::string& folder,
                          const std::string& ending,
                          std::map<int, std::string>& files);

constexpr double kMaxSide = 1 << 20;  // px, of an image that a track names

// w, h, fl_x, fl_y, cx, cy (px) of a frame in a transforms file, or else of the file.
Camera LensOfTransforms(const JsonField& file, const JsonField& frame);

// The array's first number, or `fallback` if there is no such array.
double ScalarOr(const Npz& npz, const char* name, double fallback);

// fps; 0 if there is none. Throws Error if it is negative or not finite.
double FrameRateOf(const Npz& npz);

}  // namespace cosplat
