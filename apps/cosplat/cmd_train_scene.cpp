// cosplat train-scene: trains a static scene from images.
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/options/scene_options.h"
#include "apps/cosplat/run/scene_training.h"

namespace cosplat {

void AddTrainScene(CLI::App& app) {
  CLI::App* command = app.add_subcommand("train-scene", "train a static scene from photographs");
  const auto options = std::make_shared<SceneTrainOptions>();
  options->DeclareFolders(*command);
  options->DeclareTraining(*command);
  command->callback([options, command, &app] { TrainScene(*options, ConfigOf(app, *command)); });
}

}  // namespace cosplat
