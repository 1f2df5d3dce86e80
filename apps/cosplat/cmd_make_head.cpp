// cosplat make-head: writes the procedural head's tracked video and its model file.
#include <cstdio>
#include <memory>
#include <vector>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/run/head_sheets.h"
#include "apps/cosplat/run/progress_bar.h"
#include "assets/head/video.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

struct MakeHeadChoices : MakeHeadOptions {
  std::string out, sheets;
  bool quiet = false;
};

void MakeHead(const MakeHeadChoices& o) {
  if (!o.sheets.empty()) return WriteHeadSheets(o.sheets);
  if (o.out.empty()) throw Error("--out", "is missing: the folder to write");
  {
    ProgressBar bar("make-head", o.frames, o.quiet);
    WriteProceduralVideo(o.out, o, [&](int done, int) { bar.Update(done, "frames"); });
  }
  if (!o.quiet)
    std::printf("%d frames of %dx%d, the last %d held out: %s (model: %s/model.npz)\n",
                o.frames,
                o.size,
                o.size,
                o.test_frames,
                o.out.c_str(),
                o.out.c_str());
}

}  // namespace

void AddMakeHead(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("make-head", "render the procedural head: a tracked video to train on");
  const auto o = std::make_shared<MakeHeadChoices>();
  command->add_option("-o,--out", o->out, "folder to write");
  command->add_option("--frames", o->frames, "length of the video");
  command->add_option("--test-frames", o->test_frames, "the last ones, with unseen expressions");
  command->add_option("--size", o->size, "width and height in pixels");
  command->add_flag(
      "--frontal",
      o->frontal,
      "the head hardly turns, before one camera at rest; test frames are seen from all "
      "around");
  command->add_option("--seed", o->seed, "of the motion");
  command
      ->add_option(
          "--landmark-noise", o->landmark_noise, "px, added to the points in landmarks.json")
      ->check(CLI::Range(0.0, 100.0));
  const std::vector<CLI::Option*> of_video = command->get_options([&](const CLI::Option* option) {
    return option != command->get_help_ptr() && option != command->get_help_all_ptr();
  });
  auto* sheets = command->add_option(
      "--sheets", o->sheets, "folder for pictures of the expressions and shapes of our own head");
  for (CLI::Option* option : of_video) sheets->excludes(option);
  command->add_flag("--quiet", o->quiet, "print nothing but errors");
  command->callback([o] { MakeHead(*o); });
}

}  // namespace cosplat
