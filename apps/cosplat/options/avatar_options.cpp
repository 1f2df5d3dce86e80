#include "apps/cosplat/options/avatar_options.h"

#include "apps/cosplat/options/choice.h"
#include "apps/cosplat/options/command_line.h"
#include "avatar/model/corrections.h"

namespace cosplat {
namespace {

// Where there is a network; SplattingAvatar's is AlexNet.
constexpr const char* kSplattingAvatarLpips = "0.01";

using BustChoice = AvatarSettings::BustChoice;
const Choices<BustChoice> kBusts{
    {"auto", BustChoice::kAuto}, {"yes", BustChoice::kYes}, {"no", BustChoice::kNo}};
const Choices<bool> kMouths{{"yes", true}, {"no", false}};
const Choices<ColorFrame> kColorFrames{{"surface", ColorFrame::kSurface},
                                       {"world", ColorFrame::kWorld}};
const Choices<Preset> kPresets{{"cosplat", Preset::kCosplat},
                               {"quick", Preset::kQuick},
                               {"splatting-avatar", Preset::kSplattingAvatar},
                               {"splatting-avatar-released", Preset::kSplattingAvatarReleased},
                               {"3dgs", Preset::k3dgs}};

}  // namespace

AvatarOptions::AvatarOptions() {
  iterations = 6000;
  sh_degree = 2;  // as good as 3 on held-out training frames (docs/tried.md)
  // SplattingAvatar's 1.6e-4 is for 30,000 steps; the distance that a Gaussian can move is the
  // learning rate times the number of steps.
  position_lr_init = 6.4e-4f;
}

void AvatarOptions::Declare(CLI::App& command) {
  DeclareFolders(command);
  command.get_option("--source_path")
      ->description(
          "tracked video of IMavatar's, VHAP's, INSTA's, metrical-tracker's, SMIRK's layout");
  DeclareTraining(command);
}

void AvatarOptions::DeclareTraining(CLI::App& command) {
  BeginGroup(command, "Data");
  command.add_option(
      "--flame", flame, "FLAME model file (.pkl or .npz); none: head.npz beside the track");
  command.add_option("--landmarks",
                     landmarks,
                     "the video's landmarks with scores: lets face trackers drive the avatar");
  DeclareQuality(command,
                 "draft: 2,000 steps, 0.3 x the time, -3.2 dB on a made head; standard: 6,000, the "
                 "default; best: 15,000, 3 x, +0.7 dB");
  TrainOptions::DeclareTraining(command);
  BeginGroup(command, "Head");
  AddChoice(command, "--bust", avatar.bust, kBusts, "a sheet for shoulders; auto: by the masks");
  AddChoice(command, "--mouth", mouth, kMouths, "teeth and the inside of the mouth");
  command.add_flag("--refine-track",
                   avatar.refine_track,
                   "also optimise pose, translation and expression of the training frames");
  BeginGroup(command, "More: head");
  command.add_flag("--still-bust",
                   avatar.still_bust,
                   "hold the bust still, instead of finding where it is in each frame");
  command
      .add_option("--virtual-views",
                  avatar.virtual_views,
                  "share of the second half's steps in which the mesh says how the head looks from "
                  "where no camera was, and in as many with its mouth open; 0: none")
      ->check(CLI::Range(0.0, 0.5));
  command
      .add_option("--corrections",
                  avatar.corrections,
                  "most bases per Gaussian that follow the expression; 0: none")
      ->check(CLI::Range(0, kMaxCorrections));
  command
      .add_option("--light_lr",
                  avatar.light_rate,
                  "learning rate of the light that stands still while the head turns; 0: no light")
      ->check(CLI::NonNegativeNumber);
  command.add_option("--gaussians", avatar.initial_gaussians, "Gaussians to start with")
      ->check(CLI::Range(size_t(1), kMaxGaussians));
  command
      .add_option("--triangle-cap,--triangle_cap",
                  triangle_cap,
                  "most Gaussians on one triangle; 0: no limit")
      ->check(CLI::Range(0, 1000000000));
  AddChoice(command,
            "--color-frame,--color_frame",
            avatar.color_frame,
            kColorFrames,
            "frame of the view direction for colours: surface (moves with the skin) or world");
  command.add_flag(
      "--embed-flame", embed_flame, "put the FLAME mesh into avatar.glb; mind the model's licence");
  command.add_flag(
      "--truncate-degree",
      truncate_degree,
      "with --sh_degree 4: leave band 4 out of what other programs read of avatar.glb");
  BeginGroup(command, "More: frames");
  AddOptional<int>(command,
                   "--test-frames",
                   test_frames,
                   "hold the last N frames out (the video's own split)",
                   -1)
      ->check(CLI::Range(-1, 1000000000));
  command.add_flag(
      "--fold-by-turn",
      fold_by_turn,
      "hold the fifth of the training frames out in which the head is turned furthest, "
      "instead of the test frames: for choosing what has to hold in poses not seen");
  command
      .add_option("--focal-scale",
                  focal_scale,
                  "the camera's focal length as a multiple of the track's, which may be a guess; "
                  "compare values by what they reach with --fold")
      ->check(CLI::Range(0.01, 100.0));
  BeginGroup(command, "More: preset");
  AddChoice(
      command,
      "--preset",
      preset,
      kPresets,
      "quick: half the steps, and more Gaussians sooner; splatting-avatar: as published, with "
      "its LPIPS loss if --lpips has a network; splatting-avatar-released: as its code was "
      "released, faults included; 3dgs: absolute schedule steps; explicitly given options "
      "take precedence");
}

void AvatarOptions::Settle(CLI::App& command) {
  fold = fold || fold_by_turn;
  avatar.system = AvatarRules(preset).system;
  OptionValues values = AvatarRules(preset).options;
  if (IsSplattingAvatar() && !lpips.empty())
    values.emplace_back("--lambda_lpips", kSplattingAvatarLpips);
  TrainOptions::Settle(command, values, AvatarValues);
  avatar.iterations = iterations;
}

TrainSettings AvatarOptions::ToSettings(float unit) const {
  TrainSettings settings = SettingsBy(AvatarRules(preset), 1);
  if (of_video && !resolution_schedule && quality != Quality::kBest)
    settings.schedule.downscale_every *= 2;
  settings.scale_regularizer.weight = 1;  // as in SplattingAvatar, for every preset
  settings.prune.group_cap = triangle_cap;
  ScaleToUnit(unit, settings);
  return settings;
}

std::string NameOf(Preset preset) { return NameIn(kPresets, preset); }

}  // namespace cosplat
