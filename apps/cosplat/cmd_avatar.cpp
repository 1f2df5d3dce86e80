// cosplat avatar: from a video of a head to a trained avatar, with its report and a playback.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/options/avatar_options.h"
#include "apps/cosplat/options/command_line.h"
#include "apps/cosplat/run/run_checkpoint.h"
#include "apps/cosplat/run/track_run.h"
#include "apps/cosplat/run/train_run.h"
#include "splat/base/error.h"
#include "splat/base/files.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

struct AvatarCommand : AvatarOptions {
  TrackRunOptions track;
  std::string out;
};

void Say(const AvatarCommand& o, const char* step) {
  if (o.quiet) return;
  std::printf("%s\n", step);
  std::fflush(stdout);
}

// Landmarks that an earlier run found in this video are kept: they take longest to find.
bool HasLandmarks(const AvatarCommand& o, const std::string& file) {
  if (!fs::exists(file) || fs::last_write_time(file) < fs::last_write_time(o.track.source))
    return false;
  return ReadLandmarks(file).source == o.track.source;
}

std::string LandmarksOf(const AvatarCommand& o) {
  if (!o.landmarks.empty()) return o.landmarks;
  const std::string file = o.out + "/landmarks.json";
  if (HasLandmarks(o, file)) {
    Say(o, "1/4 Landmarks are there from an earlier run");
    return file;
  }
  Say(o, "1/4 Finding the face's landmarks");
  MakeDirectories(o.out);
  DetectLandmarks({o.track.source, file, o.quiet});
  return file;
}

void MakeAvatar(AvatarCommand o, const std::string& config) {
  const FrameSource frames(o.track.source);  // so that a broken video is found first
  o.track.flame = o.flame;
  o.track.out = o.source = o.out + "/track";
  o.track.quiet = o.quiet;
  o.model = o.out + "/avatar";
  const RunStart start = ChooseStart(o, config);
  o.resume = start != RunStart::kNew;  // the question is not asked again
  o.landmarks = o.track.landmarks = LandmarksOf(o);
  if (o.resume && fs::exists(o.source + "/flame_params.json")) {
    Say(o, "2/4 The track is there from an earlier run");
  } else {
    Say(o, "2/4 Fitting FLAME to them");
    RunTracking(o.track);
  }
  Say(o, "3/4 Training an avatar, and evaluating it on frames that it has not seen");
  TrainAvatar(o, config);
  Say(o, "4/4 Writing the report and a playback");
  WriteReport(o.model, o.quiet);
  RenderVideo(o.model, o.track.out, o.out + "/playback.mp4", o.device, o.quiet);
  if (!o.quiet)
    std::printf(
        "track     %s/track.html\nreport    %s/report.html\nplayback  %s/playback.mp4\n"
        "play it   cosplat play %s\n",
        o.track.out.c_str(),
        o.model.c_str(),
        o.out.c_str(),
        o.model.c_str());
}

}  // namespace

void AddAvatar(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "avatar", "from a video of a head to an avatar: landmarks, track, training, playback");
  const auto o = std::make_shared<AvatarCommand>();
  o->eval = true;
  BeginGroup(*command, "Data");
  command->add_option("video", o->track.source, "a video file, or a folder of images")->required();
  command->add_option("-o,--out", o->out, "where results go")->required();
  BeginGroup(*command, "More: track");
  DeclareTracking(o->track, *command);
  o->DeclareTraining(*command);
  command->callback([o, command, &app] {
    o->Settle(*command);
    MakeAvatar(*o, ConfigOf(app, *command));
  });
}

}  // namespace cosplat
