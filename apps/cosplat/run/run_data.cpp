#include "apps/cosplat/run/run_data.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <map>

#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/run_folder.h"
#include "avatar/model/avatar_mesh.h"
#include "flame/track.h"
#include "splat/base/error.h"
#include "splat/base/text.h"

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

// As cameras.json has it, which is UTF-8.
std::string WrittenName(const std::string& name) {
  return Json::parse(Json(name).dump(-1, ' ', false, Json::error_handler_t::replace))
      .get<std::string>();
}

// extent: of all cameras, world units.
bool SamePose(const Camera& a, const Camera& b, float extent) {
  constexpr float kRounding = 1e-4f;
  const std::array<float, 3> p = a.Center(), q = b.Center();
  bool same = true;
  for (size_t i = 0; i < 9; ++i) same &= std::abs(a.rotation[i] - b.rotation[i]) <= kRounding;
  for (size_t k = 0; k < 3; ++k)
    same &= std::abs(p[k] - q[k]) <= kRounding * (extent + 0.01f * std::abs(p[k]));
  return same;
}

float ExtentOf(const std::vector<NamedCamera>& cameras) {
  float extent = 0;
  for (const NamedCamera& camera : cameras)
    for (size_t k = 0; k < 3; ++k)
      extent =
          std::max(extent, std::abs(camera.camera.Center()[k] - cameras[0].camera.Center()[k]));
  return extent;
}

}  // namespace

constexpr int kGreatestReduction = 64;  // as of -r

void ChooseImages(const std::string& name, DataSplit& split) {
  const int reduced = name.starts_with("images_") ? NumberOf<int>(name.substr(7)).value_or(0) : 0;
  if (reduced > 0 && reduced <= kGreatestReduction)
    split.resolution *= reduced;
  else
    split.images = name;
}

Json ToJson(const DataSplit& split) {
  Json json{{"resolution", split.resolution},
            {"eval", split.eval},
            {"fold", split.fold},
            {"fold_by_turn", split.fold_by_turn},
            {"test_frames", split.test_frames},
            {"focal_scale", split.focal_scale}};
  if (split.origin.value_or(WorldOrigin{}) != WorldOrigin{}) json["origin"] = *split.origin;
  if (split.images != DataSplit{}.images) json["images"] = split.images;
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
  if (json.Has("images")) split.images = json["images"].String();
  if (json.Has("focal_scale")) split.focal_scale = json["focal_scale"].Number();
  split.origin = WorldOrigin{};
  for (size_t k = 0; k < 3 && json.Has("origin"); ++k)
    (*split.origin)[k] = json["origin"][k].Number();
  return split;
}

int LargestResolution(const std::string& path) {
  int resolution = 1;
  if (!std::filesystem::exists(path + "/images"))
    for (const int reduced : {8, 4, 2})
      if (std::filesystem::exists(Format("{}/images_{}", path, reduced))) resolution = reduced;
  return resolution;
}

SceneData LoadSplitScene(const std::string& source, const DataSplit& split) {
  SceneData scene = LoadScene(source, split);
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
  if (unit == 1) return "";
  return Format("{} is in units of {:g} m, and was converted to metres\n", what, unit);
}

TrackedVideo LoadSplitVideo(const std::string& source,
                            const DataSplit& split,
                            const FlameModel& flame) {
  TrackedVideo video = LoadTrackedVideo(source, {split.test_frames, split.resolution, &flame});
  std::vector<const FlameParams*> faces;
  for (const TrackedFrame* frame : FramesInOrder(video)) faces.push_back(&frame->params);
  const std::string unused = UnusedExpressions(flame, faces);
  if (!unused.empty()) video.notes.push_back(video.source + ": " + unused);
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

std::vector<NamedCamera> CamerasOf(const SceneData& scene) {
  std::vector<NamedCamera> cameras;
  for (const auto* views : {&scene.test, &scene.train})
    for (const SceneView& view : *views) cameras.push_back({view.name, view.camera});
  return cameras;
}

std::vector<NamedCamera> CamerasOf(const TrackedVideo& video) {
  std::vector<NamedCamera> cameras;
  for (const auto* frames : {&video.test, &video.train})
    for (const TrackedFrame& frame : *frames) cameras.push_back({frame.name, frame.camera});
  return cameras;
}

void RequireDataOfRun(const std::string& folder,
                      const std::string& source,
                      const std::vector<NamedCamera>& views,
                      size_t held_out,
                      bool whole) {
  const JsonField run = ReadRun(folder);
  if (!run.Has("test_views")) return;
  const std::vector<NamedCamera> then = ReadCamerasJson(folder + "/cameras.json");
  const size_t tested = std::min(then.size(), size_t(run["test_views"].Integer()));
  const float extent = ExtentOf(then);
  // Names may repeat, of several sequences: by split, those for training first.
  using ByName = std::multimap<std::string, const Camera*>;
  ByName now[2], before[2];
  for (size_t i = 0; i < views.size(); ++i)
    now[i < held_out].emplace(WrittenName(views[i].name), &views[i].camera);
  for (size_t i = 0; i < then.size(); ++i)
    before[i < tested].emplace(then[i].name, &then[i].camera);
  const auto has = [&](const ByName& cameras, const std::string& name, const Camera& camera) {
    const auto [first, last] = cameras.equal_range(name);
    return std::any_of(
        first, last, [&](const auto& at) { return SamePose(*at.second, camera, extent); });
  };
  const auto fail = [&](const std::string& name, const std::string& problem) {
    throw Error(source,
                name,
                problem + ": these are not the data that " + folder +
                    " was trained on (--overwrite trains again)");
  };
  for (const bool is_test : {true, false}) {
    if (!is_test && !whole && tested > 0) continue;
    for (const auto& [name, camera] : before[is_test]) {
      if (!now[is_test].contains(name))
        fail(name, std::string("is no ") + (is_test ? "held-out" : "training") + " view any more");
      if (!has(now[is_test], name, *camera)) fail(name, "has another camera than in training");
    }
  }
  for (const auto& [name, camera] : now[true])
    if (has(before[false], name, *camera) && !has(before[true], name, *camera))
      fail(name, "is held out now, and was a training view");
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
