// cosplat metrics: PSNR, SSIM and LPIPS of a run's test images.
#include <cstdio>
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/run/head_model.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/run_data.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/test_images.h"
#include "apps/cosplat/run/turned_sheet.h"
#include "avatar/io/avatar_file.h"
#include "avatar/model/avatar_mesh.h"
#include "avatar/play/player.h"
#include "avatar/train/fit_track.h"
#include "flame/model.h"
#include "splat/base/error.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

struct MetricsOptions {
  std::string model, lpips, flame;  // the last two may be empty
  bool fit_track = false, fit_bust = false, fit_exposure = false, turn = false;
};

// The run's avatar, with its mesh, and the model that poses it. Throws Error if the run is a scene;
// option: that asks.
struct PosableAvatar {
  AvatarModel avatar;
  FlameModel flame;
};
PosableAvatar LoadAvatar(const MetricsOptions& o, const JsonField& run, const std::string& option) {
  if (run["kind"].String() != "avatar")
    throw Error(o.model, option, "is for avatars; this is a scene");
  const std::string path = o.model + "/avatar.glb";
  AvatarModel avatar = ReadAvatarGlb(path);
  FlameModel flame = LoadFlameOfRun(avatar, path, &run, o.flame);
  AttachMesh(avatar, flame);
  return {std::move(avatar), std::move(flame)};
}

// Writes the held-out frames as the avatar shows them once their parameters have been fitted,
// beside those on tracked parameters: test/ours_N<suffix>.
void WriteFitted(const MetricsOptions& o, const JsonField& run, int iteration) {
  FitSettings settings;
  settings.head = o.fit_track;
  const std::string option = o.fit_track ? "--fit-track" : "--fit-bust";
  const auto [avatar, flame] = LoadAvatar(o, run, option);
  const TrackedVideo video = LoadSplitVideo(run["source"].String(), SplitFromJson(run), flame);
  if (video.test.empty()) throw Error(o.model, option, "no frames were held out");
  const MeshTopology topology =
      BuildTopology("avatar", avatar.mesh.faces, int(avatar.mesh.vertices.size() / 3));
  TrackFitter fitter(avatar, flame, settings);
  TestImageWriter writer(
      o.model, "test", iteration, avatar.background, o.fit_track ? "_fitted" : "_fitted_bust");
  ProgressBar bar("fit", int(video.test.size()));
  for (size_t i = 0; i < video.test.size(); ++i) {
    const TrackedFrame& frame = video.test[i];
    const Image8 truth = LoadTrackedImage(video, frame);
    fitter.Fit(frame, truth, avatar.background);
    writer.Write(
        fitter.image(), truth, HeadViewOf(fitter.vertices(), avatar, topology, flame, frame));
    bar.Update(int(i) + 1, "frames");
  }
  writer.Finish();
}

// Writes turned.png, which the report shows too.
void WriteTurned(const MetricsOptions& o, const JsonField& run) {
  PosableAvatar loaded = LoadAvatar(o, run, "--turn");
  const FlameModel& flame = loaded.flame;
  Player player(std::move(loaded.avatar), flame);
  const TurnedSheet sheet = DrawTurned(player,
                                       flame,
                                       ReferenceRoot(run),
                                       CameraFromJson(run["reference"]["camera"]),
                                       BackgroundOf(run));
  WriteImage(o.model + "/turned.png", sheet.image);
  std::printf("alpha outside of the head: %s\nturned: %s/turned.png\n",
              ToString(sheet).c_str(),
              o.model.c_str());
}

void Measure(const MetricsOptions& o) {
  const std::string &model = o.model, &lpips_folder = o.lpips;
  const JsonField run = ReadRun(model);
  const int iteration = SavedIteration(model, run);
  if (o.fit_track || o.fit_bust) WriteFitted(o, run, iteration);
  if (o.turn) WriteTurned(o, run);
  if (o.fit_exposure) WriteExposed(model + "/test/ours_" + std::to_string(iteration));
  std::unique_ptr<Lpips> lpips;
  if (!lpips_folder.empty()) lpips = std::make_unique<Lpips>(lpips_folder);
  const TestSummary summary =
      EvaluateTestImages(model, iteration, lpips.get(), ShowProgress("metrics", "views"));
  std::printf("%s\n", ToString(summary).c_str());
  for (const auto& [name, figures] : summary.others)
    std::printf("%s: %s\n", name.c_str(), figures.c_str());
  for (const std::string& line : summary.dropped) std::printf("dropped: %s\n", line.c_str());
}

}  // namespace

void AddMetrics(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "metrics", "PSNR, SSIM and LPIPS of the test views: results.json, per_view.json");
  const auto o = std::make_shared<MetricsOptions>();
  command->add_option("-m,--model_path", o->model, "a trained model's folder")->required();
  command->add_option("--flame", o->flame, "FLAME model file, if not where it was in training");
  command->add_flag("--fit-track",
                    o->fit_track,
                    "also with pose, expression and bust of each test frame fitted to its image, "
                    "the avatar held fixed: ours_N_fitted");
  command
      ->add_flag("--fit-bust",
                 o->fit_bust,
                 "likewise, with the bust's pose alone fitted: ours_N_fitted_bust")
      ->excludes("--fit-track");
  command->add_flag(
      "--fit-exposure",
      o->fit_exposure,
      "also with the exposure and white balance of each test image fitted on its left "
      "half, and measured on its right half: ours_N_exposed");
  command->add_flag(
      "--turn",
      o->turn,
      "also draw an avatar from aside and behind, where it was not filmed: turned.png, "
      "and how much of it sticks out of the head there");
  command->add_option("--lpips",
                      o->lpips,
                      "LPIPS by the net in this folder: NET_backbone.onnx, NET_lin.npz and "
                      "NET_taps.txt (docs/lpips.md)");
  command->callback([o] { Measure(*o); });
}

}  // namespace cosplat
