#include "apps/cosplat/options/scene_options.h"

#include "apps/cosplat/options/choice.h"
#include "apps/cosplat/options/command_line.h"
#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {

void SceneTrainOptions::DeclareTraining(CLI::App& command) {
  DeclareQuality(command, "draft: 2,000 steps; standard: 7,000; best: 30,000 (docs/scenes.md)");
  TrainOptions::DeclareTraining(command);
  BeginGroup(command, "Photographs");
  command.add_flag(
      "--exposure", exposure, "find each photograph's exposure and white balance while training");
  command.add_flag("--antialiasing",
                   antialiasing,
                   "train for images of any size and distance: Mip-Splatting's filters");
  BeginGroup(command, "More: size of the scene");
  command
      .add_option("--memory",
                  memory_gb,
                  "GB that training may take: photographs that do not fit are read again in each "
                  "step, and there are fewer Gaussians; 0: no limit")
      ->check(CLI::Range(0.0f, 1e6f));
  command
      .add_option("--blocks",
                  blocks,
                  "blocks that the scene is split into by place and trained in, for 1/N of the "
                  "memory: one after another, or by mpirun's ranks (docs/large-scenes.md)")
      ->check(CLI::Range(1, 1024));
  command
      .add_option("--batch",
                  batch,
                  "views per step; iterations are views, and rates follow (docs/large-scenes.md)")
      ->check(CLI::Range(1, 1024));
  BeginGroup(command, "More: start");
  AddChoice<Preset>(
      command,
      "--preset",
      preset,
      {{"default", Preset::kCosplat}, {"3dgs", Preset::k3dgs}},
      "default: in proportion to --iterations, better and faster; 3dgs: as its code does");
  AddOptional<size_t>(command,
                      "--random-points,--random_points",
                      random_points,
                      "number of random initial points for data without points (default: points "
                      "found in the images; 3dgs: 100,000)",
                      0)
      ->check(CLI::Range(size_t(0), kMaxGaussians));
}

void SceneTrainOptions::Settle(CLI::App& command) {
  TrainOptions::Settle(command, {}, SceneValues);
}

void SceneTrainOptions::CheckBlocks() const {
  if (blocks == 1) return;
  const auto refuse = [&](const std::string& option, const std::string& why) {
    throw Error(option, why + ": not with --blocks " + std::to_string(blocks));
  };
  if (ResolveDevice() != Device::kCpu) refuse("--device cuda", "blocks are trained on the CPU");
  if (prune != "none") refuse("--prune " + prune, "ranks the Gaussians of a whole scene");
  if (prune_to) refuse(Format("--prune-to {}", *prune_to), "ranks the Gaussians of a whole scene");
  if (finds_budget) refuse("--budget auto", "ranks the Gaussians of a whole scene");
  if (drop_bands > 0) refuse("--drop-bands", "measures images of a whole scene");
  if (preset == Preset::k3dgs) refuse("--preset 3dgs", "has a schedule in steps of a whole scene");
  if (!save_iterations.empty() || !test_iterations.empty())
    refuse(save_iterations.empty() ? "--test_iterations" : "--save_iterations",
           "the scene is in one piece at the end only");
}

}  // namespace cosplat
