// Options of training a scene, shared by `train-scene` and `scene`.
#pragma once

#include <CLI/CLI.hpp>

#include "apps/cosplat/options/train_options.h"

namespace cosplat {

struct SceneTrainOptions : TrainOptions {
  std::string images = "images";
  std::optional<size_t> random_points;  // none: the preset's choice
  float memory_gb = 0;                  // 10^9 bytes; 0: no limit
  size_t blocks = 1;

  // As TrainOptions::DeclareTraining, with those that only scenes have.
  void DeclareTraining(CLI::App& command);
  // Call once `command` has been parsed: sets what --quality stands for.
  void Settle(CLI::App& command);
  // As TrainOptions::ToSettings, and of blocks.
  TrainSettings ToSettings(float extent) const {
    return SettingsBy(blocks > 1 ? BlockRules() : SceneRules(preset), extent);
  }
  // Throws Error if `blocks` does not go with other options.
  void CheckBlocks() const;
};

}  // namespace cosplat
