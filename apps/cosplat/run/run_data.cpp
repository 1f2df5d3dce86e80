#include "apps/cosplat/run/run_data.h"

#include <algorithm>
#include <cstdio>
#include <iterator>

#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/run_folder.h"
#include "avatar/model/avatar_mesh.h"
#include "flame/focal.h"
#include "splat/base/error.h"
#include "splat/io/cameras_json.h"

namespace cosplat {
namespace {

// A fifth of the training frames becomes the test frames; both stay in order of time.
void HoldOutFurthestTurned(TrackedVideo& video) {
  std::vector<FlameParams> frames;
  for (const TrackedFrame& frame : video.train) frames.push_back(frame.params);
  const std::vector<float> turns = HeadTurns(frames);
  std::vector<float> sorted = turns;
  std::sort(sorted.begin(), sorted.end());
  if (sorted.empty()) return;
  const float limit = sorted[sorted.size() - 1 - sorted.size() / 5];
  std::vector<TrackedFrame> kept;
  video.test.clear();
  for (size_t i = 0; i < turns.size(); ++i)
    (turns[i] > limit ? video.test : kept).push_back(std::move(video.train[i]));
  video.train = std::move(kept);
}

// Coefficients that the model has no directions for, as FLAME's Open model has none, do nothing.
void NoteExpressions(const FlameModel& flame, TrackedVideo& video) {
  const size_t used = size_t(flame.expression_count);
  size_t given = 0;
  double all = 0, left = 0;
  for (const auto* frames : {&video.train, &video.test})
    for (const TrackedFrame& frame : *frames) {
      given = std::max(given, frame.params.expression.size());
      for (size_t k = 0; k < frame.params.expression.size(); ++k) {
        const double square = double(frame.params.expression[k]) * frame.params.expression[k];
        all += square;
        if (k >= used) left += square;
      }
    }
  if (left == 0) return;
  char text[160];
  std::snprintf(text,
                sizeof text,
                ": %zu of %zu expression coefficients are used, all that the model has; the others "
                "are %.0f %% of the expressions (sum of squares)",
                std::min(used, given),
                given,
                100 * left / all);
  video.notes.push_back(video.source + text);
}

}  // namespace

Json ToJson(const DataSplit& split) {
  Json json{{"resolution", split.resolution},
            {"eval", split.eval},
            {"fold", split.fold},
            {"fold_by_turn", split.fold_by_turn},
            {"test_frames", split.test_frames},
            {"focal_scale", split.focal_scale}};
  if (split.origin.value_or(WorldOrigin{}) != WorldOrigin{}) json["origin"] = *split.origin;
  return json;
}

DataSplit SplitFromJson(const JsonField& run) {
  const JsonField json = run["split"];
  DataSplit split;
  split.resolution = json["resolution"].Integer();
  split.eval = json.raw().value("eval", false);
  split.fold = json.raw().value("fold", false);
  split.fold_by_turn = json.raw().value("fold_by_turn", false);
  split.test_frames = json["test_frames"].Integer();
  if (json.Has("focal_scale")) split.focal_scale = json["focal_scale"].Number();
  split.origin = WorldOrigin{};
  for (size_t k = 0; k < 3 && json.Has("origin"); ++k)
    (*split.origin)[k] = json["origin"][k].Number();
  return split;
}

SceneData LoadSplitScene(const std::string& source, const DataSplit& split) {
  SceneData scene = LoadScene(source, {split.resolution, split.eval, split.fold, split.origin});
  PrintNotes(scene.notes);
  return scene;
}

std::string PlaceLines(const SceneData& scene) {
  if (scene.origin == WorldOrigin{}) return "";
  std::string lines =
      "coordinates are counted from " + ToString(scene.origin) + ", which splat files name\n";
  if (scene.coarse_points)
    lines += "the initial points are stored as 32-bit floats, which are coarse so far from zero\n";
  return lines;
}

std::string UnitLine(const std::string& what, double unit) {
  char text[32];
  std::snprintf(text, sizeof text, "%g m", unit);
  return unit == 1 ? "" : what + " is in units of " + text + ", and was converted to metres\n";
}

TrackedVideo LoadSplitVideo(const std::string& source,
                            const DataSplit& split,
                            const FlameModel& flame) {
  TrackedVideo video = LoadTrackedVideo(source, {split.test_frames, split.resolution, &flame});
  NoteExpressions(flame, video);
  SettleMasks(flame, video);
  PrintNotes(video.notes);
  if (split.fold_by_turn) {
    HoldOutFurthestTurned(video);
  } else if (split.fold) {
    const size_t held = video.train.size() / 5;
    const auto first = video.train.end() - std::ptrdiff_t(held);
    video.test.assign(first, video.train.end());
    video.train.erase(first, video.train.end());
  } else if (!split.eval) {
    std::move(video.test.begin(), video.test.end(), std::back_inserter(video.train));
    video.test.clear();
  }
  if ((split.fold || split.eval) && video.test.empty())
    throw Error(source, "test frames", "there is none to evaluate on");
  if (split.focal_scale != 1) ScaleFocal(flame, split.focal_scale, video);
  return video;
}

std::array<float, 3> BackgroundOf(const JsonField& run) {
  const std::vector<float> c = run["background"].Numbers(3);
  return {c[0], c[1], c[2]};
}

Json ReferenceView(const TrackedVideo& video) {
  std::vector<FlameParams> frames;
  for (const TrackedFrame& frame : video.train) frames.push_back(frame.params);
  const FlameParams mean = MeanRoot(frames);
  return {{"rotation", mean.pose[0]},
          {"translation", mean.translation},
          {"camera", CameraToJson(video.train[0].camera)}};
}

void WriteTrackCameras(const std::string& folder, const TrackedVideo& video) {
  std::vector<NamedCamera> cameras;
  for (const auto* frames : {&video.test, &video.train})
    for (const TrackedFrame& frame : *frames) cameras.push_back({frame.name, frame.camera});
  WriteCamerasJson(folder + "/cameras.json", cameras);
}

FlameParams ReferenceRoot(const JsonField& run) {
  FlameParams p;
  const std::vector<float> r = run["reference"]["rotation"].Numbers(3);
  const std::vector<float> t = run["reference"]["translation"].Numbers(3);
  std::copy(r.begin(), r.end(), p.pose[0].begin());
  std::copy(t.begin(), t.end(), p.translation.begin());
  return p;
}

}  // namespace cosplat
