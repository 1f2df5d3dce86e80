// cosplat metrics: PSNR, SSIM and LPIPS of a run's test images.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/run/camera_path.h"
#include "apps/cosplat/run/head_model.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/run_data.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/test_images.h"
#include "avatar/play/player.h"
#include "avatar/surface/silhouette.h"
#include "avatar/train/fit_track.h"
#include "flame/pose.h"
#include "splat/base/error.h"
#include "splat/base/text.h"
#include "splat/eval/metrics.h"
#include "splat/math/vec.h"
#include "splat/media/image_io.h"
#include "splat/media/signed_distance.h"

namespace cosplat {
namespace {

struct MetricsOptions {
  std::string model, lpips, flame;  // the last two may be empty
  bool fit_track = false, fit_bust = false, fit_exposure = false, turn = false;
};

// Throws Error if the run is a scene; option: that asks.
PosableAvatar LoadAvatar(const MetricsOptions& o, const JsonField& run, const std::string& option) {
  if (run["kind"].String() != "avatar")
    throw Error(o.model, option, "is for avatars; this is a scene");
  return LoadPosable(o.model + "/avatar.glb", &run, o.flame);
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

// An avatar seen from where nobody filmed it: does it hold there?

// Of the camera around the head, from before the face, degrees counterclockwise from above.
constexpr std::array<float, 12> kAngles{0, -15, -30, -45, -60, -90, 180, 15, 30, 45, 60, 90};
constexpr int kSheetColumns = 6;
constexpr int kCell = 320;               // px, width of a view in the sheet
constexpr double kWithinInFront = 0.99;  // of the alpha, which says how far hair and clothes reach

// [height, width] px from the mesh's outline, positive outside.
Image FromMesh(const std::vector<float>& vertices, Player& player, const Camera& camera) {
  Image8 mask(camera.width, camera.height, 1);
  const std::vector<uint8_t> covered = MeshSilhouette(vertices, player.avatar().mesh.faces, camera);
  for (size_t i = 0; i < mask.pixels(); ++i) mask.data[i] = covered[i] ? 255 : 0;
  return SignedDistance(mask, 128);
}

double Alpha(const Image8& rgba, size_t pixel) { return rgba.data[4 * pixel + 3]; }

// px; kWithinInFront of the alpha are not farther from the mesh.
int ReachOf(const Image8& rgba, const Image& distance) {
  std::vector<double> at(size_t(rgba.width + rgba.height), 0);  // by distance, rounded up
  double left = 0;
  for (size_t i = 0; i < rgba.pixels(); ++i) {
    const float d = std::clamp(std::ceil(distance.data[i]), 0.0f, float(at.size() - 1));
    at[size_t(d)] += Alpha(rgba, i);
    left += Alpha(rgba, i);
  }
  const double most = (1 - kWithinInFront) * left;
  size_t reach = 0;
  while (reach + 1 < at.size() && (left -= at[reach]) > most) ++reach;
  return int(reach);
}

// Of the alpha, what is farther from the mesh's outline than `reach`.
double ShareBeyond(const Image8& rgba, const Image& distance, int reach) {
  double beyond = 0, all = 0;
  for (size_t i = 0; i < rgba.pixels(); ++i) {
    all += Alpha(rgba, i);
    if (distance.data[i] > float(reach)) beyond += Alpha(rgba, i);
  }
  return all > 0 ? beyond / all : 0;
}

// The avatar, placed by `rest`, from before its face, aside and behind, by the camera `lens`, which
// goes around the head: RGB, side by side, in rows. shares: what a line says of each view.
Image8 DrawTurned(Player& player,
                  const FlameModel& flame,
                  const FlameParams& rest,
                  const Camera& lens,
                  const std::array<float, 3>& background,
                  std::string& shares) {
  PosedAvatar placed;
  player.Pose(rest, placed);
  const std::vector<float> vertices = player.VerticesOf(placed);
  const std::array<float, 3> center = MiddleOf(vertices, flame.vertex_count);
  const std::array<float, 3> up{-lens.rotation[3], -lens.rotation[4], -lens.rotation[5]};
  // From the camera to before the face: the first of several cameras may stand aside.
  const math::Vec3<float> axis = math::ToVec3(up), forward = HeadForward(rest),
                          arm = math::ToVec3(lens.Center()) - math::ToVec3(center);
  const auto level = [&](const math::Vec3<float>& v) { return v - axis * math::Dot(axis, v); };
  const float to_face = std::atan2(math::Dot(axis, math::Cross(arm, forward)),
                                   math::Dot(level(arm), level(forward))) *
                        180 / std::numbers::pi_v<float>;
  const int rows = (int(kAngles.size()) + kSheetColumns - 1) / kSheetColumns;
  const int height = std::max(1, lens.height * kCell / lens.width);
  Image8 sheet(kSheetColumns * kCell, rows * height, 3);
  int reach = 0, cell = 0;
  for (const float degrees : kAngles) {
    const Camera camera = TurnedAround(lens, center, up, to_face + degrees);
    Image8 image;
    player.Render(rest, camera, image);
    const Image distance = FromMesh(vertices, player, camera);
    if (degrees == 0) reach = ReachOf(image, distance);
    Paste(OverBackground(ResizeByArea(image, kCell, height), background),
          cell % kSheetColumns * kCell,
          cell / kSheetColumns * height,
          sheet);
    shares += Format("{}{:.0f} deg {:.2f} %",
                     cell++ == 0 ? "" : ", ",
                     degrees,
                     100 * ShareBeyond(image, distance, reach));
  }
  return sheet;
}

// Writes turned.png, which the report shows too.
void WriteTurned(const MetricsOptions& o, const JsonField& run) {
  auto [avatar, flame] = LoadAvatar(o, run, "--turn");
  Player player(std::move(avatar), flame);
  std::string shares;
  WriteImage(o.model + "/turned.png",
             DrawTurned(player,
                        flame,
                        ReferenceRoot(run),
                        CameraFromJson(run["reference"]["camera"]),
                        BackgroundOf(run),
                        shares));
  std::printf(
      "alpha outside of the head: %s\nturned: %s/turned.png\n", shares.c_str(), o.model.c_str());
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
