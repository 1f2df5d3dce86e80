// Options that both trainers share: the names and meanings of 3DGS's where it has them.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "apps/cosplat/options/train_choices.h"
#include "splat/train/train_device.h"

namespace cosplat {

// Far more than any machine holds; more is a slip of the finger.
constexpr size_t kMaxGaussians = 1000000000;

struct TrainOptions : TrainChoices {
  // Declares them on a sub-command; defaults are the values at the time of the call.
  void Declare(CLI::App& command);
};

// All options of a sub-command with their values, as `--config` reads them.
std::string ConfigOf(const CLI::App& app, const CLI::App& command);

}  // namespace cosplat
