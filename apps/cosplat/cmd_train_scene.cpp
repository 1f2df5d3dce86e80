// cosplat train-scene: trains a static scene from images, alone or as one of mpirun's ranks.
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/options/config_file.h"
#include "apps/cosplat/options/scene_options.h"
#include "apps/cosplat/run/scene_training.h"
#include "apps/cosplat/run/stop_signals.h"
#include "splat/base/error.h"
#include "splat/train/ranks/join_ranks.h"

namespace cosplat {
namespace {

// What ends all ranks alike rank 0 says; what ends one alone, that one.
void TrainOnRanks(const SceneTrainOptions& o, const std::string& config) {
  const std::shared_ptr<Ranks> ranks = JoinRanks();
  try {
    TrainScene(o, config, ranks);
  } catch (const Stopped& stopped) {
    ranks->EndTogether();
    if (ranks->rank() == 0) throw;
    throw CLI::RuntimeError(128 + stopped.signal);
  } catch (const Error& error) {
    if (ranks->size() == 1) throw;
    if (!ranks->EndTogether()) throw Error("rank " + std::to_string(ranks->rank()), error.what());
    if (ranks->rank() == 0) throw;
    throw CLI::RuntimeError(2);  // as main's
  }
}

}  // namespace

void AddTrainScene(CLI::App& app) {
  CLI::App* command = app.add_subcommand("train-scene", "train a static scene from photographs");
  const auto options = std::make_shared<SceneTrainOptions>();
  options->DeclareFolders(*command);
  command->add_option("-i,--images",
                      options->images,
                      "folder of the images, as 3DGS has it: images_4 divides their size by 4");
  options->DeclareTraining(*command);
  command->callback([options, command, &app] {
    options->Settle(*command);
    TrainOnRanks(*options, ConfigOf(app, *command));
  });
}

}  // namespace cosplat
