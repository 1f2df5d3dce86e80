#include "splat/train/scene_subject.h"

#include <tbb/parallel_for.h>

#include <string>

namespace cosplat {

std::vector<TrainFrame> LoadTrainFrames(std::vector<SceneView>& views,
                                        std::vector<SkippedFrame>& skipped) {
  std::vector<TrainFrame> loaded(views.size());
  std::vector<std::string> problems(views.size());
  tbb::parallel_for(size_t(0), views.size(), [&](size_t i) {
    problems[i] = Problem([&] {
      loaded[i] = {views[i].camera, LoadViewImage(views[i]), LoadIgnored(views[i])};
    });
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

TrainingScene LoadTrainingScene(SceneData& scene) {
  TrainingScene loaded;
  loaded.train = LoadTrainFrames(scene.train, scene.skipped);
  loaded.test = LoadTrainFrames(scene.test, scene.skipped);
  CheckSkipped(scene.source, loaded.train.size() + loaded.test.size(), scene.skipped);
  loaded.points = scene.points;
  loaded.point_colors = scene.point_colors;
  loaded.extent = scene.extent;
  loaded.white_background_hint = scene.white_background_hint;
  return loaded;
}

}  // namespace cosplat
