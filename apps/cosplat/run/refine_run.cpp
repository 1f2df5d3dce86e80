#include "apps/cosplat/run/refine_run.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/cosplat/run/avatar_rounds.h"
#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/train_run.h"
#include "flame/eyelids.h"
#include "flame/fit/fit_landmarks.h"
#include "flame/io/imavatar_writer.h"
#include "flame/model.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// Eyelids are refined if the track has them.
TrackedVideo LoadVideo(const RefineRunOptions& o, FlameModel& model) {
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

// Of the frames in order: how many at the end are the test set; -1 if that is not where it is.
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
std::array<float, 4> WriteFrame(const RefineRunOptions& o, const std::string& name, Image8 image) {
  const bool masked = image.channels == 4;
  Image8 color(image.width, image.height, 3), mask(image.width, image.height, 1);
  for (size_t i = 0; i < image.pixels(); ++i) {
    std::copy_n(&image.data[i * size_t(image.channels)], 3, &color.data[3 * i]);
    if (masked) mask.data[i] = image.data[4 * i + 3];
  }
  WriteImage(o.out + "/image/" + name + ".png", color);
  if (!masked) return {-1, -1, 1, 1};
  MakeDirectories(o.out + "/mask");
  WriteImage(o.out + "/mask/" + name + ".png", mask);
  return ImavatarBox(mask);
}

void WriteRefined(const RefineRunOptions& o,
                  const std::vector<double>& spread,
                  const std::vector<double>& held_out_psnr,
                  TrackedVideo& video) {
  MakeDirectories(o.out + "/image");
  fs::remove(o.out + "/flame_params.json");  // so that a half is not taken for the whole
  ImavatarTrack track;
  track.shape = video.shape;
  track.static_offset = video.static_offset;
  track.test_frames = TestFramesAtEnd(video);
  const std::vector<TrackedFrame*> frames = FramesInOrder(video);
  ProgressBar bar("write", int(frames.size()), o.quiet);
  for (TrackedFrame* frame : frames) {
    track.boxes.push_back(WriteFrame(o, frame->name, LoadTrackedImage(video, *frame)));
    track.frames.push_back(*frame);
    bar.Update(int(track.frames.size()), "frames");
  }
  const Json figures = {{"source", o.source},
                        {"flame", o.flame},
                        {"frames", frames.size()},
                        {"brightness_spread", spread},
                        {"held_out_psnr", held_out_psnr}};
  WriteFileAtomically(o.out + "/track.json", figures.dump(1) + "\n");
  WriteImavatarTrack(o.out, track);
}

}  // namespace

void RunRefinement(const RefineRunOptions& o) {
  if (fs::exists(o.out) && fs::equivalent(o.source, o.out))
    throw Error("-o", "is the track's own folder '" + o.out + "', expected another");
  FlameModel model = LoadFlameModel(o.flame);
  TrackedVideo video = LoadVideo(o, model);
  std::unique_ptr<ProgressBar> bar;
  const auto image = [&](const TrackedFrame& frame) { return LoadTrackedImage(video, frame); };
  const std::vector<double> spread = RefineTrack(model, video, image, [&](int done, int total) {
    if (!bar) bar = std::make_unique<ProgressBar>("refine", total, o.quiet);
    bar->Update(done, "fits");
  });
  EyelidsFromExpression(model, video);
  const std::vector<double> psnr = RefineByAvatars(o.flame, video, image, o.avatar_rounds, o.quiet);
  WriteRefined(o, spread, psnr, video);
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

}  // namespace cosplat
