// Options of `cosplat train-avatar`, and the presets that set several of them at once.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "apps/cosplat/options/train_options.h"
#include "avatar/train/trainer.h"

namespace cosplat {

// `preset` is one of
//   cosplat                    this project's settings
//   splatting-avatar           SplattingAvatar as published
//   splatting-avatar-released  SplattingAvatar's released code, including the faults in which it
//                              differs from the publication (avatar/train/trainer.h, AvatarSystem)
//   3dgs                       as cosplat, but with 3DGS's absolute schedule steps
struct AvatarOptions : TrainOptions {
  AvatarOptions();

  std::string flame, landmarks;
  int test_frames = -1;
  bool fold_by_turn = false;  // implies `fold`
  double focal_scale = 1;     // of the track's focal length (flame/focal.h)
  std::string color_frame = "surface";
  std::string bust = "auto", mouth = "yes";
  bool embed_flame = false;
  bool truncate_degree = false;
  int triangle_cap = 64;  // GaussianAvatars users report 8,000 on one face
  AvatarSettings avatar;

  void Declare(CLI::App& command);
  // Without the folders of data and results.
  void DeclareTraining(CLI::App& command);
  // Call once `command` has been parsed. Assigns the preset's values to all options that were not
  // given on the command line, wherever --preset stands, also in what ConfigOf reads; then fills in
  // `avatar`.
  void ApplyPreset(CLI::App& command);
  // Whether the preset has an LPIPS loss that is left out, as there is no network.
  bool OmitsLpips() const { return IsSplattingAvatar() && lpips.empty(); }
  // `unit`: AvatarSubject::extent.
  TrainSettings ToSettings(float unit) const;

 private:
  bool IsSplattingAvatar() const { return avatar.system != AvatarSystem::kCosplat; }
};

}  // namespace cosplat
