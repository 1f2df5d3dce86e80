// cosplat avatar: from a video of a head to a trained avatar, with its report and a playback.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/options/avatar_options.h"
#include "apps/cosplat/options/command_line.h"
#include "apps/cosplat/run/head_model.h"
#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/run_checkpoint.h"
#include "apps/cosplat/run/track_run.h"
#include "apps/cosplat/run/train_run.h"
#include "flame/fit/fit_landmarks.h"
#include "flame/fit/head_crop.h"
#include "flame/model.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// As many as an avatar needs, and as take minutes.
constexpr int kChosenFrames = 400;
// As many as play fast, unless the best is asked for, or what others published: twice as many gain
// 0.2 dB (docs/tried.md).
constexpr size_t kMaxGaussiansToPlay = 12000;

struct AvatarCommand : AvatarOptions {
  LandmarkRunOptions marks;
  TrackRunOptions track;
  std::string out;
};

void Say(const AvatarCommand& o, const char* step) {
  if (o.quiet) return;
  std::printf("%s\n", step);
  std::fflush(stdout);
}

// Of frames of this size, and as many.
bool AreAsAsked(const LandmarkVideo& marks,
                const LandmarkRunOptions& asked,
                const FrameSource& frames) {
  const int side = std::max(frames.width(), frames.height());
  const int usable = frames.count() - marks.left_out;
  const bool all = asked.frames == 0 || usable <= asked.frames;
  const bool whole = asked.size == 0 || side <= asked.size;
  return (marks.crop ? !whole && SidesWithin(marks.crop->part, asked.size)[0] == marks.width
                     : whole) &&
         int(marks.frames.size()) == (all ? usable : asked.frames);
}

// Landmarks that an earlier run found in this video are kept: they take longest to find. Which
// mattes it had is not known.
bool HasLandmarks(const AvatarCommand& o, const FrameSource& frames) {
  const std::string& file = o.marks.out;
  if (o.overwrite || !o.marks.matte.empty() || !fs::exists(file)) return false;
  const LandmarkVideo marks = ReadLandmarks(file);
  if (marks.source != o.track.source || !AreAsAsked(marks, o.marks, frames)) return false;
  // Those of earlier versions have no checksum.
  return marks.source_checksum ? marks.source_checksum == frames.Checksum()
                               : fs::last_write_time(file) >= fs::last_write_time(o.track.source);
}

// Returns whether they had to be found: a track of earlier ones is not theirs.
bool FindLandmarks(AvatarCommand& o, FrameSource& frames) {
  if (!o.landmarks.empty()) return false;
  o.landmarks = o.marks.out;
  if (HasLandmarks(o, frames)) {
    Say(o, "1/4 Landmarks are there from an earlier run");
    return false;
  }
  Say(o, "1/4 Finding the face's landmarks");
  MakeDirectories(o.out);
  DetectLandmarks(o.marks, frames);
  return true;
}

void MakeAvatar(AvatarCommand o, const std::string& config) {
  // What is broken is found first.
  auto frames = std::make_unique<FrameSource>(o.track.source);
  PrintNotes(frames->notes());
  if (frames->count() < kMinFaces)
    throw Error(o.track.source,
                Format("frames: {}, expected at least {}", frames->count(), kMinFaces));
  if (!o.flame.empty()) LoadFlameModel(o.flame);
  o.marks.source = o.track.source;
  o.marks.out = o.out + "/landmarks.json";
  o.marks.quiet = o.quiet;
  o.track.out = o.source = o.out + "/track";
  o.track.quiet = o.quiet;
  o.model = o.out + "/avatar";
  const RunStart start = ChooseStart(o, config);
  o.resume = start != RunStart::kNew;  // the question is not asked again
  o.flame = o.track.flame = HeadModelFor(o.flame, o.out);
  const bool found = FindLandmarks(o, *frames);
  o.track.landmarks = o.landmarks;
  if (o.resume && !found && fs::exists(o.source + "/flame_params.json")) {
    Say(o, "2/4 The track is there from an earlier run");
  } else {
    Say(o, "2/4 Fitting a head to them");
    RunTracking(o.track, *frames);
  }
  frames.reset();  // with what it keeps
  Say(o, "3/4 Training an avatar, and evaluating it on frames that it has not seen");
  const bool sound = TrainAvatar(o, config);
  Say(o, "4/4 Writing the report and a playback");
  WriteReport(o.model, o.quiet);
  const bool chosen =
      ReadLandmarks(o.landmarks).held_out > 0;  // the others do not follow each other
  RenderVideo(o.model,
              chosen ? VideoOf::kTestFrames : VideoOf::kSequence,
              o.track.out,
              o.out + "/playback.mp4",
              o.device,
              o.quiet);
  if (!o.quiet)
    std::printf(
        "track     %s/track.html\nreport    %s/report.html\nplayback  %s/playback.mp4\n"
        "play it   cosplat play %s\n",
        o.track.out.c_str(),
        o.model.c_str(),
        o.out.c_str(),
        o.model.c_str());
  if (!sound) EndAsWrong(o.source);
}

}  // namespace

void AddAvatar(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "avatar", "from a video of a head to an avatar: landmarks, track, training, playback");
  const auto o = std::make_shared<AvatarCommand>();
  o->eval = o->of_video = true;
  o->marks.frames = kChosenFrames;
  o->max_gaussians = kMaxGaussiansToPlay;
  BeginGroup(*command, "Data");
  command->add_option("video", o->track.source, "a video file, or a folder of images")->required();
  command->add_option("-o,--out", o->out, "where results go")->required();
  BeginGroup(*command, "More: track");
  DeclareLandmarks(o->marks, *command);
  DeclareTracking(o->track, *command);
  o->DeclareTraining(*command);
  command->get_option("--flame")->required(false)->description(
      "FLAME model file (.pkl or .npz), which fits people best; none: our own head");
  command->get_option("--max-gaussians")
      ->description("hard limit on their number; 2,000,000 for the best, and published presets");
  command->get_option("--resolution-schedule")
      ->description(
          "steps after which the sides of the images double (a fifth of the run; of the best a "
          "tenth)");
  for (const char* of_images : {"--size", "--frames", "--matte"})
    command->get_option(of_images)->excludes(command->get_option("--landmarks"));
  command->callback([o, command, &app] {
    o->Settle(*command);
    const bool is_best = o->quality == Quality::kBest;
    const bool is_ours = o->preset == Preset::kCosplat || o->preset == Preset::kQuick;
    const std::string unlimited = std::to_string(AvatarOptions().max_gaussians);
    if ((is_best || !is_ours) && SetUnlessGiven(*command, "--max-gaussians", unlimited) && is_best)
      o->settled += " --max-gaussians " + unlimited;
    MakeAvatar(*o, ConfigOf(app, *command));
  });
}

}  // namespace cosplat
