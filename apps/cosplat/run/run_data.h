// The data of a run, split identically for training and for later rendering.
#pragma once

#include <array>
#include <string>

#include "apps/cosplat/options/train_options.h"
#include "flame/track.h"
#include "splat/base/json.h"
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

// Background colour of held-out images, from run.json.
std::array<float, 3> BackgroundOf(const JsonField& run);

// The head's mean root pose and the camera, for run.json; orbits and driven playback start from it.
Json ReferenceView(const TrackedVideo& video);
// cameras.json: the test frames', then the training frames'.
void WriteTrackCameras(const std::string& folder, const TrackedVideo& video);
// Mean root pose and translation of an avatar's head; all other parameters are zero.
FlameParams ReferenceRoot(const JsonField& run);

}  // namespace cosplat
