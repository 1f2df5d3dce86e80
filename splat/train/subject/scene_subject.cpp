#include "splat/train/subject/scene_subject.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <string>

namespace cosplat {

namespace {

TrainFrame Read(const SceneView& view) {
  return {view.camera, LoadViewImage(view), LoadIgnored(view)};
}

}  // namespace

size_t ImageBytes(const Camera& camera) { return 4 * size_t(camera.width) * camera.height; }

std::vector<TrainFrame> LoadTrainFrames(std::vector<SceneView>& views,
                                        std::vector<SkippedFrame>& skipped,
                                        size_t max_bytes) {
  std::vector<TrainFrame> loaded(views.size());
  std::vector<std::string> problems(views.size());
  std::vector<size_t> bytes(views.size() + 1, 0);  // of all before
  for (size_t i = 0; i < views.size(); ++i) bytes[i + 1] = bytes[i] + ImageBytes(views[i].camera);
  tbb::parallel_for(size_t(0), views.size(), [&](size_t i) {
    problems[i] = Problem([&] { loaded[i] = Read(views[i]); });
    if (bytes[i + 1] <= max_bytes) return;
    const auto read = [view = views[i]] { return Read(view); };
    loaded[i] = {views[i].camera, {}, {}, read};
  });
  std::vector<SceneView> usable;
  std::vector<TrainFrame> frames;
  for (size_t i = 0; i < views.size(); ++i) {
    if (!problems[i].empty()) {
      skipped.push_back({views[i].name, problems[i]});
      continue;
    }
    usable.push_back(std::move(views[i]));
    frames.push_back(std::move(loaded[i]));
  }
  views = std::move(usable);
  return frames;
}

TrainingScene LoadTrainingScene(SceneData& scene, size_t max_bytes) {
  TrainingScene loaded;
  loaded.train = LoadTrainFrames(scene.train, scene.skipped, max_bytes);
  // The test views are seen once or twice in a run.
  size_t left = max_bytes;
  for (const SceneView& view : scene.train) left -= std::min(left, ImageBytes(view.camera));
  loaded.test = LoadTrainFrames(scene.test, scene.skipped, left);
  CheckSkipped(scene.source, loaded.train.size() + loaded.test.size(), scene.skipped);
  loaded.points = scene.points;
  loaded.point_colors = scene.point_colors;
  loaded.extent = scene.extent;
  loaded.renderings = scene.renderings;
  return loaded;
}

}  // namespace cosplat
