#include "apps/cosplat/options/scene_options.h"

#include "splat/base/error.h"

namespace cosplat {

void SceneTrainOptions::DeclareTraining(CLI::App& command) {
  TrainOptions::DeclareTraining(command);
  command
      .add_option("--batch",
                  batch,
                  "views per step; iterations are views, and rates follow (docs/large-scenes.md)")
      ->check(CLI::Range(1, 1024));
  command
      .add_option(
          "--preset",
          preset,
          "default: in proportion to --iterations, better and faster; 3dgs: as its code does")
      ->check(CLI::IsMember({"default", "3dgs"}));
  command
      .add_option("--random-points,--random_points",
                  random_points,
                  "number of random initial points for data without points; 0: the preset's choice "
                  "(default: points found in the images; 3dgs: 100,000)")
      ->check(CLI::Range(size_t(0), kMaxGaussians));
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
  command.add_flag("--exposure",
                   exposure,
                   "find each photograph's exposure and white balance while training, so that the "
                   "scene does not learn them");
  command.add_flag("--antialiasing",
                   antialiasing,
                   "train for images of any size and distance: Mip-Splatting's filters");
}

void SceneTrainOptions::CheckBlocks() const {
  if (blocks == 1) return;
  const auto refuse = [&](const std::string& option, const std::string& why) {
    throw Error(option, why + ": not with --blocks " + std::to_string(blocks));
  };
  if (ResolveDevice() != Device::kCpu)
    refuse("--device " + device, "blocks are trained on the CPU");
  if (prune != "none") refuse("--prune " + prune, "ranks the Gaussians of a whole scene");
  if (prune_to > 0)
    refuse("--prune-to " + std::to_string(prune_to), "ranks the Gaussians of a whole scene");
  if (budget != "none") refuse("--budget " + budget, "tries a whole scene several times");
  if (drop_bands > 0) refuse("--drop-bands", "measures images of a whole scene");
  if (preset == "3dgs") refuse("--preset 3dgs", "has a schedule in steps of a whole scene");
  if (!save_iterations.empty() || !test_iterations.empty())
    refuse(save_iterations.empty() ? "--test_iterations" : "--save_iterations",
           "the scene is in one piece at the end only");
}

}  // namespace cosplat
