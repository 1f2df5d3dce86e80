// The data of a run, split the same way when it is trained and when it is rendered again.
#pragma once

#include <array>
#include <string>

#include "apps/cosplat/options/train_options.h"
#include "flame/track.h"
#include "splat/base/json.h"
#include "splat/io/dataset.h"

namespace cosplat {

// What decides which images train and which are held out; part of run.json.
struct DataSplit {
  int resolution = 1;
  bool eval = false;
  bool fold = false;
  int test_frames = -1;  // tracked videos only
};

Json ToJson(const DataSplit& split);
DataSplit SplitFromJson(const JsonField& run);

SceneData LoadSplitScene(const std::string& source, const DataSplit& split);

// Without eval every frame trains. With fold the last fifth of the training frames are held out in
// place of the test frames.
TrackedVideo LoadSplitVideo(const std::string& source, const DataSplit& split);

// Colour behind held-out images, as run.json has it.
std::array<float, 3> BackgroundOf(const JsonField& run);

// An avatar's head where it is on average: root pose and translation, all else zero.
FlameParams ReferenceRoot(const JsonField& run);

}  // namespace cosplat
