// cosplat train-avatar: a head avatar from tracked video.
#include <cstdio>
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/progress_bar.h"
#include "apps/cosplat/run_folder.h"
#include "apps/cosplat/test_images.h"
#include "apps/cosplat/train_options.h"
#include "avatar/avatar_file.h"
#include "avatar/player.h"
#include "avatar/silhouette.h"
#include "avatar/trainer.h"
#include "flame/io/model_file.h"
#include "splat/base/error.h"
#include "splat/io/cameras_json.h"
#include "splat/io/ply.h"

namespace cosplat {
namespace {

struct AvatarOptions : TrainOptions {
  AvatarOptions() {
    iterations = 6000;
    sh_degree = 3;
    background = "random";
    // SplattingAvatar's 1.6e-4 is for 30,000 steps; the way that a Gaussian can go is rate times
    // steps.
    rates.position_first = 6.4e-4f;
  }
  std::string flame;
  int test_frames = -1;
  std::string color_frame = "surface";
  std::string bust = "auto";
  bool embed_flame = false;
  AvatarSettings avatar;
};

constexpr std::array<float, 3> kWhite{1, 1, 1};
constexpr int kGaussiansPerTriangle = 64;  // cap: GaussianAvatars' report of 8,000 on one face

// SplattingAvatar's loss in place of ours.
void ApplyPreset(const AvatarOptions& o, TrainSettings& settings) {
  settings.scale_regularizer.weight = 1;
  if (o.preset == "splattingavatar") settings.loss = {1, 0, 10};
}

std::array<float, 3> EvaluationBackground(const AvatarOptions& o) {
  if (o.background == "black" && !o.white_background) return {0, 0, 0};
  return kWhite;
}

void Evaluate(const AvatarOptions& o,
              const FlameModel& flame,
              const AvatarSubject& subject,
              const Trainer& trainer) {
  Player player(subject.Model(trainer.state().gaussians), flame);
  const std::array<float, 3> background = EvaluationBackground(o);
  TestImageWriter writer(o.model, trainer.state().iteration, background);
  RenderedImage image;
  for (const TrackedFrame& frame : subject.video().test) {
    player.RenderOver(frame.params, frame.camera, background, image);
    const std::array<int, 4> box = MouthBox(player.vertices(),
                                            player.avatar().mesh.vertices,
                                            subject.surface().topology(),
                                            frame.camera);
    const Rectangle mouth{box[0], box[1], box[2], box[3]};
    writer.Write(
        image, LoadTrackedImage(subject.video(), frame), mouth.width > 0 ? &mouth : nullptr);
  }
  writer.Finish();
}

// Where the head is on average and how the camera sees it: orbits and driven playback start here.
Json ReferenceView(const TrackedVideo& video) {
  std::vector<FlameParams> frames;
  for (const TrackedFrame& frame : video.train) frames.push_back(frame.params);
  const FlameParams mean = MeanRoot(frames);
  return {{"rotation", mean.pose[0]},
          {"translation", mean.translation},
          {"camera", CameraToJson(video.train[0].camera)}};
}

void SaveInputs(const AvatarOptions& o, const TrackedVideo& video, const std::string& config) {
  const Json run{{"kind", "avatar"},
                 {"source", o.source},
                 {"flame", o.flame},
                 {"resolution", o.resolution},
                 {"eval", o.eval},
                 {"test_frames", o.test_frames},
                 {"iterations", o.iterations},
                 {"degree", o.sh_degree},
                 {"basis", o.basis},
                 {"seed", o.seed},
                 {"white_background", EvaluationBackground(o) == kWhite},
                 {"refine_track", o.avatar.refine_track},
                 {"reference", ReferenceView(video)},
                 {"version", COSPLAT_VERSION}};
  WriteRunConfiguration(o.model, o, config, run);
  std::vector<NamedCamera> cameras;
  for (const auto* frames : {&video.test, &video.train})
    for (const TrackedFrame& frame : *frames) cameras.push_back({frame.name, frame.camera});
  WriteCamerasJson(o.model + "/cameras.json", cameras);
}

// The first Gaussians at rest.
void SaveFirstPoints(const AvatarOptions& o, const AvatarModel& first) {
  const Gaussians rest = RestPose(first);
  const std::vector<float> points(rest.values[kPosition].begin(), rest.values[kPosition].end());
  WritePointsPly(o.model + "/input.ply", points, std::vector<uint8_t>(points.size(), 128));
}

void Save(const AvatarOptions& o,
          const FlameModel& flame,
          const AvatarSubject& subject,
          const Trainer& trainer) {
  const AvatarModel model = subject.Model(trainer.state().gaussians);
  // The rest pose, for tools that know only 3DGS's layout.
  SaveSplats(o.model, trainer.state().iteration, RestPose(model));
  AvatarFileOptions file;
  file.embed_flame = o.embed_flame;
  file.truncate_degree = true;  // the exact coefficients are in our own extension
  WriteAvatarGlb(o.model + "/avatar.glb", model, &flame, file);
}

void ReportSkipped(const TrackedVideo& video) {
  if (video.skipped.empty()) return;
  std::printf("%zu frames skipped:\n", video.skipped.size());
  constexpr size_t kListed = 5;
  for (size_t i = 0; i < std::min(kListed, video.skipped.size()); ++i)
    std::printf("  %s: %s\n", video.skipped[i].name.c_str(), video.skipped[i].reason.c_str());
  if (video.skipped.size() > kListed) std::printf("  ...\n");
}

void RunTraining(const AvatarOptions& o,
                 const FlameModel& flame,
                 const AvatarSubject& subject,
                 Trainer& trainer) {
  ProgressBar bar("train", o.iterations);
  double loss = 0;
  for (int i = 1; i <= o.iterations; ++i) {
    const StepReport step = trainer.Step();
    loss = i == 1 ? step.loss : 0.95 * loss + 0.05 * step.loss;
    char detail[96];
    std::snprintf(detail,
                  sizeof detail,
                  "loss %.4f  %s Gaussians",
                  loss,
                  WithThousands(step.gaussians).c_str());
    bar.Update(i, detail);
    if (o.ReachesMilestone(o.save_iterations, i)) Save(o, flame, subject, trainer);
    if (o.eval && !subject.video().test.empty() && o.ReachesMilestone(o.test_iterations, i))
      Evaluate(o, flame, subject, trainer);
  }
}

// Without --eval every frame trains.
TrackedVideo LoadVideo(const AvatarOptions& o) {
  TrackedVideo video = LoadTrackedVideo(o.source, {o.test_frames, o.resolution, true});
  if (o.fold) {
    // The last fifth of the training frames in place of the test frames.
    const size_t held = video.train.size() / 5;
    video.test.assign(video.train.end() - held, video.train.end());
    video.train.resize(video.train.size() - held);
  } else if (!o.eval) {
    video.train.insert(video.train.end(), video.test.begin(), video.test.end());
    video.test.clear();
  }
  return video;
}

void Train(AvatarOptions o, const std::string& config) {
  o.eval = o.eval || o.fold;
  const FlameModel flame = LoadFlameModel(o.flame);
  AvatarSubject subject(flame, LoadVideo(o), o.avatar);
  const TrackedVideo& video = subject.video();
  TrainSettings settings = o.ToSettings(1);
  ApplyPreset(o, settings);
  ScaleToUnit(subject.extent(), settings);
  settings.density.group_cap = kGaussiansPerTriangle;
  if (!o.quiet) ReportSkipped(video);
  SaveInputs(o, video, config);
  Trainer trainer(
      settings, subject, subject.InitialGaussians(o.sh_degree, BasisFromString(o.basis), o.seed));
  if (!o.quiet)
    std::printf("%s: %zu training and %zu test frames of %dx%d\n",
                video.layout.c_str(),
                video.train.size(),
                video.test.size(),
                video.train[0].camera.width,
                video.train[0].camera.height);
  RunTraining(o, flame, subject, trainer);
  const TrainingStatistics statistics = trainer.statistics();
  WriteStatistics(o.model, statistics, video.skipped.size());
  if (!o.quiet)
    std::printf(
        "%d iterations in %.1f s (%.2f ms per step at the end), %s Gaussians, "
        "%.1f %% of them on another triangle than they began on\n",
        o.iterations,
        statistics.seconds,
        statistics.ms_per_step,
        WithThousands(statistics.gaussians).c_str(),
        100 * subject.WalkedShare());
  if (o.eval && !video.test.empty()) {
    const TestSummary summary = EvaluateTestImages(o.model, o.iterations);
    if (!o.quiet) std::printf("%s\n", ToString(summary).c_str());
  }
}

}  // namespace

void AddTrainAvatar(CLI::App& app) {
  CLI::App* command = app.add_subcommand("train-avatar", "train a head avatar from tracked video");
  const auto o = std::make_shared<AvatarOptions>();
  o->Declare(*command);
  command->add_option("--flame", o->flame, "FLAME model file (.pkl or .npz)")->required();
  command->add_option(
      "--test-frames", o->test_frames, "hold the last N frames out; -1: the video's own split");
  command->add_option("--gaussians", o->avatar.initial_gaussians, "Gaussians to start with")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--color_frame",
                   o->color_frame,
                   "surface: colours see the direction in the skin's frame; world: in the world's")
      ->check(CLI::IsMember({"surface", "world"}));
  command
      ->add_option("--bust",
                   o->bust,
                   "a sheet for shoulders, which FLAME lacks: yes, no, or auto by the masks")
      ->check(CLI::IsMember({"auto", "yes", "no"}));
  command->add_flag("--refine-track",
                    o->avatar.refine_track,
                    "improve pose, translation and expression of the training frames along");
  command->add_flag("--embed-flame",
                    o->embed_flame,
                    "put the FLAME mesh into avatar.glb; mind the model's licence");
  command
      ->add_option("--preset",
                   o->preset,
                   "default; splattingavatar: its loss; 3dgs: absolute schedule steps")
      ->check(CLI::IsMember({"default", "splattingavatar", "3dgs"}));
  command->callback([o, command, &app] {
    o->avatar.color_frame = o->color_frame == "world" ? ColorFrame::kWorld : ColorFrame::kSurface;
    using BustChoice = AvatarSettings::BustChoice;
    o->avatar.bust = o->bust == "yes" ? BustChoice::kYes
                                      : (o->bust == "no" ? BustChoice::kNo : BustChoice::kAuto);
    Train(*o, ConfigOf(app, *command));
  });
}

}  // namespace cosplat
