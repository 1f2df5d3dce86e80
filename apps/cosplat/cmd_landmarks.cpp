// cosplat landmarks: the points of the face in each frame of a video, and mattes.
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/run/landmark_run.h"

namespace cosplat {

void AddLandmarks(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "landmarks", "find the points of the face in a video; needs node and Chromium");
  const auto o = std::make_shared<LandmarkRunOptions>();
  command->add_option("video", o->source, "a video file, or a folder of images")->required();
  command->add_option("-o,--out", o->out, "file to write, .json; mattes/ goes beside it")
      ->required();
  command->add_flag("--quiet", o->quiet, "print nothing but errors");
  command->callback([o] { DetectLandmarks(*o); });
}

}  // namespace cosplat
