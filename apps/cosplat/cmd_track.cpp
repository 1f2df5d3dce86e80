// cosplat track: FLAME's parameters of a video, from its landmarks or from an earlier track.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/run/head_model.h"
#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/track_run.h"
#include "apps/cosplat/run/train_run.h"
#include "flame/eyelids.h"
#include "flame/fit/fit_landmarks.h"
#include "flame/io/imavatar_writer.h"
#include "flame/model.h"
#include "flame/track.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"

namespace cosplat {

void DeclareTracking(TrackRunOptions& o, CLI::App& command) {
  command.add_option("--landmark-embedding",
                     o.embedding,
                     ".npz that says where the landmarks are on the model, if it is not FLAME");
  command
      .add_option(
          "--focal", o.focal, "focal length in pixels of the whole frame, if it is known; 0: found")
      ->check(CLI::Range(0.0, 1e6));
  command.add_flag("--silhouette",
                   o.silhouette,
                   "draw the mesh's outline to the rims of the mattes, and offset it by the hair");
  command
      .add_option(
          "--avatar-rounds", o.avatar_rounds, "rounds in which small avatars refine the track")
      ->check(CLI::Range(0, 20));
}

namespace {

namespace fs = std::filesystem;

// Eyelids are refined if the track has them.
TrackedVideo LoadVideo(const TrackRunOptions& o, FlameModel& model) {
  TrackOptions options;
  if (TracksEyelids(LoadTrackedVideo(o.source, options))) model = WithEyelids(std::move(model));
  options.flame = &model;
  TrackedVideo video = LoadTrackedVideo(o.source, options);
  PrintNotes(video.notes);
  MoveHead(model, video);
  for (const auto* set : {&video.train, &video.test})
    for (const TrackedFrame& frame : *set)
      if (!frame.has_image) throw Error(o.source, "'" + frame.name + "' has no image");
  return video;
}

// How many frames at the end are the test set; -1 if that is not where it is.
int TestFramesAtEnd(const TrackedVideo& video) {
  if (video.test.empty()) return -1;
  int last = video.train.empty() ? -1 : video.train[0].timestep;
  for (const TrackedFrame& frame : video.train) last = std::max(last, frame.timestep);
  const bool at_end = std::all_of(video.test.begin(), video.test.end(), [&](const auto& frame) {
    return frame.timestep > last;
  });
  return at_end ? int(video.test.size()) : -1;
}

// Writes image and mask; returns the mask's extent.
std::array<float, 4> WriteFrame(const TrackRunOptions& o,
                                const std::string& name,
                                const Image8& image) {
  WriteImage(o.out + "/image/" + name + ".png", RgbOf(image));
  if (image.channels != 4) return {-1, -1, 1, 1};
  const Image8 mask = ChannelOf(image, 3);
  MakeDirectories(o.out + "/mask");
  WriteImage(o.out + "/mask/" + name + ".png", mask);
  return ImavatarBox(mask);
}

void WriteRefined(const TrackRunOptions& o,
                  const FlameModel& model,
                  const std::vector<double>& spread,
                  const std::vector<double>& held_out_psnr,
                  TrackedVideo& video) {
  MakeDirectories(o.out + "/image");
  fs::remove(o.out + "/flame_params.json");  // so that a half is not taken for the whole
  TrackedVideo track = TrackOf(model);
  track.shape = video.shape;
  track.static_offset = video.static_offset;
  std::vector<std::array<float, 4>> boxes;
  const std::vector<TrackedFrame*> frames = FramesInOrder(video);
  ProgressBar bar("write", int(frames.size()), o.quiet);
  for (TrackedFrame* frame : frames) {
    boxes.push_back(WriteFrame(o, frame->name, LoadTrackedImage(video, *frame)));
    track.train.push_back(*frame);
    bar.Update(int(track.train.size()), "frames");
  }
  const Json figures = {{"source", o.source},
                        {"flame", o.flame},
                        {"frames", frames.size()},
                        {"brightness_spread", spread},
                        {"held_out_psnr", held_out_psnr}};
  WriteFileAtomically(o.out + "/track.json", figures.dump(1) + "\n");
  WriteImavatarTrack(o.out, track, boxes, TestFramesAtEnd(video));
}

// From a tracked video to a more exact track of it on disk, by what its images show:
// LoadTrackedVideo
// -> RefineTrack -> RefineByAvatars -> a folder in IMavatar's layout with track.json.
//
// Writes <out>/flame_params.json (last), image/, mask/ where the frames have masks, and track.json;
// prints a summary. Keeps cameras, shape and the split into training and test frames if the test
// frames come last. Throws Error before anything is written if the track cannot be refined.
void RunRefinement(const TrackRunOptions& o) {
  RefuseInput("-o", o.out, o.source);
  FlameModel model = LoadFlameModel(o.flame);
  TrackedVideo video = LoadVideo(o, model);
  const auto image = [&](const TrackedFrame& frame) { return LoadTrackedImage(video, frame); };
  const std::vector<double> spread =
      RefineTrack(model, video, image, ShowProgress("refine", "fits", o.quiet));
  EyelidsFromExpression(model, video);
  const std::vector<double> psnr = RefineByAvatars(o.flame, video, image, o.avatar_rounds, o.quiet);
  WriteRefined(o, model, spread, psnr, video);
  if (o.quiet) return;
  std::printf(
      "%zu frames refined in %zu rounds: points differ in brightness from frame to frame by %.2f "
      "of 255, before by %.2f: %s\n",
      video.train.size() + video.test.size(),
      spread.size() - 1,
      spread.back(),
      spread.front(),
      o.out.c_str());
  if (o.avatar_rounds > 0) std::printf("%s\n", AvatarRoundsText(psnr).c_str());
  PrintSkipped(video.skipped);
}

void Track(TrackRunOptions o) {
  RefuseInput("-o", o.out + "/image", o.source);
  if (!o.overlay.empty()) RefuseInput("--overlay", o.overlay, o.source);
  if (!o.landmarks.empty()) {
    FrameSource frames(o.source);
    PrintNotes(frames.notes());
    ReadLandmarks(o.landmarks);  // what is broken is found before anything is written
    o.flame = HeadModelFor(o.flame, o.out);
    return RunTracking(o, frames);
  }
  if (TrackLayoutOf(o.source).empty())
    throw Error("--landmarks",
                "is missing, and '" + o.source +
                    "' is not a tracked video that could be refined: see `cosplat landmarks`");
  if (o.focal > 0 || !o.overlay.empty() || !o.embedding.empty() || o.silhouette)
    throw Error("--focal, --overlay, --landmark-embedding and --silhouette", "need --landmarks");
  o.flame = HeadModelOfTrack(o.flame, o.source);
  RunRefinement(o);
}

}  // namespace

void AddTrack(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "track",
      "fit FLAME to the landmarks of a video, or refine a track that there is: a folder for "
      "train-avatar");
  const auto o = std::make_shared<TrackRunOptions>();
  command
      ->add_option("video",
                   o->source,
                   "a video file, or a folder of images; or a tracked video, to be refined")
      ->required();
  command->add_option("--flame", o->flame, "FLAME model, .pkl or .npz; none: our own head");
  command->add_option("-o,--out", o->out, "folder to write, in IMavatar's layout")->required();
  DeclareTracking(*o, *command);
  command->add_option(
      "--landmarks", o->landmarks, "the video's landmarks, see `cosplat landmarks`");
  command->add_option(
      "--overlay", o->overlay, "also write the mesh over every frame: .mp4 or folder");
  command->add_flag("--quiet", o->quiet, "print nothing but errors");
  command->callback([o] { Track(*o); });
}

}  // namespace cosplat
