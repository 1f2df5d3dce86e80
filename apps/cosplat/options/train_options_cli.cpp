#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>

#include "apps/cosplat/options/train_options.h"

namespace cosplat {

namespace {

const CLI::Validator kRate(
    [](std::string& text) {
      char* end = nullptr;
      const double value = std::strtod(text.c_str(), &end);
      const bool ok = end != text.c_str() && std::isfinite(value) && value >= 0;
      return ok ? std::string() : "'" + text + "' is not a number >= 0";
    },
    "FLOAT >= 0");

const CLI::Validator kInterval(
    [](std::string& text) {
      char* end = nullptr;
      const long value = std::strtol(text.c_str(), &end, 10);
      const bool ok = end != text.c_str() && (value == -1 || (value > 0 && value <= 1000000000));
      return ok ? std::string() : "'" + text + "' is neither -1 nor a number of steps > 0";
    },
    "-1 or INT > 0");

}  // namespace

void TrainOptions::DeclareFolders(CLI::App& command) {
  command.add_option("-s,--source_path", source, "the data set's folder")->required();
  command.add_option("-m,--model_path", model, "where results go")->required();
}

void TrainOptions::DeclareTraining(CLI::App& command) {
  command.add_option("-r,--resolution", resolution, "divide the images' size by this")
      ->check(CLI::Range(1, 64));
  command.add_flag("--eval", eval, "hold test views out and evaluate on them at the end");
  command.add_flag(
      "--fold",
      fold,
      "hold some training views out (every 8th; of a video the last fifth) instead of the test "
      "views: for choosing settings");
  command.add_option("--iterations", iterations, "training steps")->check(CLI::Range(1, 10000000));
  command.add_option("--sh_degree", sh_degree, "highest band of the view-dependent colour")
      ->check(CLI::Range(0, kMaxTrainedDegree));
  command
      .add_option(
          "--basis",
          basis,
          "basis of the view-dependent colour: dcsh; sh: 3DGS's; dcsh-released: DCSHARP's released "
          "code; dcsh-literal: its published formula, which cannot be saved")
      ->check(CLI::IsMember(std::vector<std::string>(kBasisNames.begin(), kBasisNames.end())));
  command
      .add_option(
          "--background",
          background,
          "in training: black, white, random, or auto (avatars random, renderings with alpha "
          "white, photographs black)")
      ->check(CLI::IsMember({"auto", "black", "white", "random"}));
  command.add_flag("-w,--white_background", white_background, "the same as --background white");
  // An empty list must not appear in config.ini, as it could not be read back.
  command.add_option("--test_iterations", test_iterations, "evaluate at these steps")
      ->default_str("");
  command.add_option("--save_iterations", save_iterations, "save at these steps")->default_str("");
  command.add_option("--seed", seed, "seed of all random numbers");
  command
      .add_option("--max-gaussians,--max_gaussians", max_gaussians, "hard limit on their number")
      ->check(CLI::Range(size_t(1), kMaxGaussians));
  command
      .add_option("--device",
                  device,
                  "where to train: cpu; cuda, an NVIDIA GPU; auto: a GPU if there is one")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}));
  command.add_flag(
      "--deterministic",
      deterministic,
      "bit-identical runs on a GPU as well, by summing in a fixed order; CPU runs always are");
  command
      .add_option("--prune",
                  prune,
                  "rule for pruning Gaussians in addition to density control (docs/study.md)")
      ->check(CLI::IsMember(PruneRuleNames()));
  command.add_option("--prune-to",
                     prune_to,
                     "leave this many Gaussians; for rules that rank, by default leave-one-out");
  command
      .add_option("--prune-lambda,--prune_lambda",
                  prune_lambda,
                  "weight of the mask's loss, for rules that learn a mask")
      ->check(kRate);
  command
      .add_option(
          "--drop-bands,--drop_bands",
          drop_bands,
          "drop bands of colour that change the images by at most this, in grey levels of 255 "
          "(root mean square); 0: none")
      ->check(kRate);
  command
      .add_option("--budget",
                  budget,
                  "auto: find the smallest number of Gaussians that keeps the quality, measured on "
                  "temporarily held-out training views; takes two to three times as long")
      ->check(CLI::IsMember({"none", "auto"}));
  command.add_option("--tolerance", tolerance, "dB that --budget auto may lose on those views")
      ->check(kRate);
  command.add_option("--lambda_dssim", lambda_dssim, "share of D-SSIM in the loss")
      ->check(kRate)
      ->check(CLI::Range(0.0, 1.0));
  command
      .add_option("--lambda_lpips",
                  lambda_lpips,
                  "weight of LPIPS in the loss, by the net of --lpips; 0: off")
      ->check(kRate);
  command
      .add_option("--lpips-crop",
                  lpips_crop,
                  "side of the random part of the image that it is computed on, in pixels")
      ->check(CLI::Range(1, 100000));
  command
      .add_option("--lpips",
                  lpips,
                  "LPIPS by the net in this folder: NET_backbone.onnx, NET_lin.npz and "
                  "NET_taps.txt (docs/lpips.md); also of the held-out images")
      ->default_str("");
  command
      .add_option(
          "--densify_grad_threshold",
          densify_grad_threshold,
          "mean screen gradient from which Gaussians are added; 0: as the preset says (2e-4)")
      ->check(kRate);
  command.add_option("--densify_from_iter", densify_from, "first step that adds Gaussians")
      ->check(CLI::Range(-1, 1000000000));
  command.add_option("--densify_until_iter", densify_until, "last step that adds Gaussians")
      ->check(CLI::Range(-1, 1000000000));
  command
      .add_option(
          "--densification_interval", densify_every, "steps between adding and removing Gaussians")
      ->check(kInterval);
  command
      .add_option(
          "--opacity_reset_interval", opacity_reset_every, "steps between resets of the opacities")
      ->check(kInterval);
  command
      .add_option("--num-downscales,--num_downscales",
                  num_downscales,
                  "how often the sides of the first images are halved; -1: as the preset says")
      ->check(CLI::Range(-1, 6));
  command
      .add_option("--resolution-schedule,--resolution_schedule",
                  resolution_schedule,
                  "steps after which the sides of the images double; -1: a tenth of the run")
      ->check(kInterval);
  command
      .add_option(
          "--position_lr_init", rates.position_lr_init, "initial learning rate of positions")
      ->check(kRate);
  command
      .add_option("--position_lr_final",
                  position_lr_final,
                  "final learning rate of positions; 0: a hundredth of the first in 30,000 steps, "
                  "more in shorter runs")
      ->check(kRate);
  command.add_option("--feature_lr", rates.color, "learning rate of colours")->check(kRate);
  command
      .add_option("--rest-lr,--rest_lr",
                  rates.rest,
                  "learning rate of colour bands 1 and up; 0: feature_lr / 20")
      ->check(kRate);
  command.add_option("--opacity_lr", rates.opacity, "learning rate of opacities")->check(kRate);
  command
      .add_option("--scaling_lr", scaling_lr, "learning rate of log scales; 0: as the preset says")
      ->check(kRate);
  command.add_option("--rotation_lr", rates.rotation, "learning rate of rotations")->check(kRate);
  command
      .add_option("--checkpoint-every",
                  checkpoint_every,
                  "minutes between checkpoints, from which --resume goes on; 0: only when the run "
                  "is interrupted (Ctrl-C, SIGTERM)")
      ->check(kRate);
  CLI::Option* again = command.add_flag(
      "--resume", resume, "go on with the interrupted run in the results' folder, if there is one");
  again->configurable(false);
  command.add_flag("--overwrite", overwrite, "replace the run that the results' folder holds")
      ->configurable(false)
      ->excludes(again);
  command
      .add_flag("--strict", strict, "refuse data of which `cosplat check` says that it is wrong")
      ->configurable(false);
  command.add_flag("--quiet", quiet, "print nothing but errors");
}

std::string ConfigOf(const CLI::App& app, const CLI::App& command) {
  return app.get_config_formatter()->to_config(&command, true, true, command.get_name() + ".");
}

}  // namespace cosplat
