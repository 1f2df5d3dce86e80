// cosplat-study face-points: where a detector sees its points on people, as points of a head model.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/study/commands.h"
#include "apps/study/face_points/cast_points.h"
#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

struct FacePointsCommand {
  std::vector<std::string> tracks, landmarks;
  std::string model, out;
};

void CastFacePoints(const FacePointsCommand& o) {
  if (o.tracks.size() != o.landmarks.size())
    throw Error("--landmarks",
                Format("{} files for {} tracks", o.landmarks.size(), o.tracks.size()));
  if (std::filesystem::exists(o.out) && std::filesystem::equivalent(o.out, o.model))
    throw Error("-o", "'" + o.out + "' is the model itself, which the tracks are of");
  FlameModel model = LoadFlameModel(o.model);
  if (model.landmarks.empty()) throw Error(model.name, "landmark_indices", "array is missing");
  std::vector<CastPlaces> people;
  for (size_t i = 0; i < o.tracks.size(); ++i) {
    TrackedVideo video = LoadDrivingSequence(o.tracks[i], &model);
    people.push_back(CastPoints(model, video, ReadLandmarks(o.landmarks[i])));
  }
  const PlacedPoints placed = PlaceOnSkin(model, people);
  for (size_t p = 0; p < placed.places.size(); ++p) {
    const auto& [x, y, z] = placed.places[p];
    std::printf("    {%d, {%.4ff, %.4ff, %.4ff}},\n", placed.landmarks[p].landmark, x, y, z);
  }
  std::printf(
      "%d of %zu points, moved by %.2f mm RMS; people differ by %.2f, right and left by %.2f\n",
      placed.seen,
      placed.places.size(),
      1e3 * placed.moved,
      1e3 * placed.people,
      1e3 * placed.symmetry);
  if (o.out.empty()) return;
  model.landmarks = placed.landmarks;
  WriteFlameModelNpz(o.out, model);
}

}  // namespace

void AddFacePoints(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "face-points",
      "where a detector sees its points on people, as places on a head model's template");
  const auto o = std::make_shared<FacePointsCommand>();
  command->add_option("model", o->model, "the tracks' head model, as the head.npz beside them")
      ->required();
  command->add_option("--track", o->tracks, "a person's track by the model; may be repeated")
      ->required();
  command->add_option("--landmarks", o->landmarks, "the landmarks of each, in the same order")
      ->required();
  command->add_option("-o,--out", o->out, ".npz: the model with these points, to track by again");
  command->callback([o] { CastFacePoints(*o); });
}

}  // namespace cosplat
