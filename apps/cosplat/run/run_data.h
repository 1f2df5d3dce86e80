// The data of a run, split identically for training and for later rendering.
#pragma once

#include <array>
#include <string>

#include "apps/cosplat/options/train_options.h"
#include "flame/track.h"
#include "splat/base/json.h"
#include "splat/io/cameras_json.h"
#include "splat/io/dataset.h"

namespace cosplat {

// Determines which images are used for training and which are held out; part of run.json.
struct DataSplit : SceneOptions {
  // Tracked videos only.
  int test_frames = -1;
  bool fold_by_turn = false;
  double focal_scale = 1;  // of the track's focal length (ScaleFocal)
};

// 3DGS's -i: "images_4" divides by 4 on top of `resolution`, another name is the folder's.
void ChooseImages(const std::string& name, DataSplit& split);

Json ToJson(const DataSplit& split);
DataSplit SplitFromJson(const JsonField& run);

// The least of 1, 2, 4, 8 whose folder of images a scene has; 1 if it has none of them. Some data
// sets contain reduced images only.
int LargestResolution(const std::string& path);

SceneData LoadSplitScene(const std::string& source, const DataSplit& split);

// What is to be said of where the scene lies: lines, or nothing.
std::string PlaceLines(const SceneData& scene);

// Likewise of a head or track that is stored in units of so many metres.
std::string UnitLine(const std::string& what, double unit);

// Without `eval`, all frames are used for training. With `fold`, the last fifth of the training
// frames is held out in place of the test frames; with `fold_by_turn` the fifth in which the head
// is turned furthest from its mean. flame: the avatar's. Throws Error as ScaleFocal does.
TrackedVideo LoadSplitVideo(const std::string& source,
                            const DataSplit& split,
                            const FlameModel& flame);

// The cameras by name: of held-out views, then of those for training.
std::vector<NamedCamera> CamerasOf(const SceneData& scene);
std::vector<NamedCamera> CamerasOf(const TrackedVideo& video);

// Throws Error(source, ...) if a held-out view of the run, or (whole, or where none was held out)
// any view of it, is missing from `views` or has another camera there, or if one of the first
// `held_out` of `views` is a training view of the run: what is said of the run would not be true of
// these data. Runs of other programs and of earlier versions do not say.
void RequireDataOfRun(const std::string& folder,
                      const std::string& source,
                      const std::vector<NamedCamera>& views,
                      size_t held_out,
                      bool whole);

// Background colour of held-out images, from run.json.
std::array<float, 3> BackgroundOf(const JsonField& run);

// The head's mean root pose and the camera, for run.json; orbits and driven playback start from it.
Json ReferenceView(const TrackedVideo& video);
// Mean root pose and translation of an avatar's head; all other parameters are zero.
FlameParams ReferenceRoot(const JsonField& run);

}  // namespace cosplat
