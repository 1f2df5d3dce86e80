// Options of `cosplat train-avatar`, with what --preset and --quality stand for (presets.h).
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "apps/cosplat/options/train_options.h"
#include "avatar/train/avatar_subject.h"

namespace cosplat {

struct AvatarOptions : TrainOptions {
  AvatarOptions();

  std::string flame, landmarks;
  std::optional<int> test_frames;  // none: the video's own split
  bool fold_by_turn = false;       // implies `fold`
  double focal_scale = 1;          // of the track's focal length (ScaleFocal)
  bool mouth = true;
  bool embed_flame = false;
  bool truncate_degree = false;
  int triangle_cap = 64;  // GaussianAvatars users report 8,000 on one face
  bool of_video = false;  // the track is our own and not exact: images are small for longer
  AvatarSettings avatar;

  void Declare(CLI::App& command);
  // Without the folders of data and results.
  void DeclareTraining(CLI::App& command);
  // Call once `command` has been parsed: sets what --preset and --quality stand for, wherever they
  // stand, also in what ConfigOf reads; then fills in `avatar`.
  void Settle(CLI::App& command);
  // Whether the preset has an LPIPS loss that is left out, as there is no network.
  bool OmitsLpips() const { return IsSplattingAvatar() && lpips.empty(); }
  // `unit`: AvatarSubject::extent.
  TrainSettings ToSettings(float unit) const;

 private:
  bool IsSplattingAvatar() const { return avatar.system != AvatarSystem::kCosplat; }
};

// The name of a preset of avatars.
std::string NameOf(Preset preset);

}  // namespace cosplat
