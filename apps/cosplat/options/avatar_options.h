// Options of `cosplat train-avatar`, and the presets that give several of them at once.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "apps/cosplat/options/train_options.h"
#include "avatar/train/trainer.h"

namespace cosplat {

// preset is one of
//   cosplat                    ours
//   splatting-avatar           SplattingAvatar as published
//   splatting-avatar-released  as its code was released, with the faults that make it other than
//                              published (avatar/train/trainer.h, AvatarSystem)
//   3dgs                       ours on 3DGS's absolute schedule steps
struct AvatarOptions : TrainOptions {
  AvatarOptions();

  std::string flame;
  int test_frames = -1;
  std::string color_frame = "surface";
  std::string bust = "auto";
  bool embed_flame = false;
  bool truncate_degree = false;
  int triangle_cap = 64;  // GaussianAvatars users report 8,000 on one face
  AvatarSettings avatar;

  void Declare(CLI::App& command);
  // Once `command` has been parsed: gives the preset's values to the options that were not given
  // (whatever their order), also as what ConfigOf reads, and settles `avatar`.
  void ApplyPreset(CLI::App& command);
  // `unit`: AvatarSubject::extent.
  TrainSettings ToSettings(float unit) const;

 private:
  bool IsSplattingAvatar() const { return avatar.system != AvatarSystem::kCosplat; }
};

}  // namespace cosplat
