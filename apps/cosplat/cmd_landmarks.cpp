// cosplat landmarks: the points of the face in each frame of a video, and mattes, by MediaPipe in
// headless Chromium.
//
// FrameSource -> FindHead -> FrameSource::CropTo -> FaceDetector -> ChooseFrames -> a landmark file
// with its mattes, which `cosplat track` reads.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/run/face_detector.h"
#include "apps/cosplat/run/find_head.h"
#include "apps/cosplat/run/frame_source.h"
#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/video_mattes.h"
#include "flame/fit/choose_frames.h"
#include "flame/fit/choose_person.h"
#include "flame/fit/face_looks.h"
#include "flame/fit/landmark_scores.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

std::vector<double> MillisecondsOf(const LandmarkVideo& video) {
  std::vector<double> times;
  for (const LandmarkFrame& frame : video.frames)
    times.push_back(1000 * frame.frame / video.rate());
  return times;
}

// Leaves the frames that are worth training on, and returns where they were in `video`.
std::vector<size_t> KeepBest(const FaceDetector& detector, int wanted, LandmarkVideo& video) {
  std::vector<double> sharpness(video.frames.size());
  tbb::parallel_for(size_t(0), video.frames.size(), [&](size_t f) {
    if (!video.frames[f].faces.empty())
      sharpness[f] = SharpnessOf(detector.Added(f), video.frames[f].faces[0].points);
  });
  const std::vector<size_t> kept = ChooseFrames(video, sharpness, wanted);
  std::vector<LandmarkFrame> best;
  for (const size_t f : kept) best.push_back(std::move(video.frames[f]));
  video.frames = std::move(best);
  return kept;
}

// Named as the file, so that files of several videos may lie in one folder.
std::string MatteFolder(const std::string& landmarks) {
  return fs::path(landmarks).replace_extension(".mattes").string();
}

// Mattes made by somebody count before the frames' alpha, and that before what the detector found
// in the images `found_as`, which is refined. others: faces of other people in these images.
void WriteMattes(const LandmarkRunOptions& o,
                 const FrameSource& frames,
                 const std::optional<OwnMattes>& own,
                 const FaceDetector& detector,
                 const std::vector<size_t>& found_as,
                 const std::vector<std::vector<FaceBox>>& others,
                 LandmarkVideo& video) {
  const std::string to = MatteFolder(o.out);
  MakeDirectories(to);
  const int count = int(video.frames.size());
  ProgressBar bar("mattes", count, o.quiet);
  const auto write = [&](int i, const Image8& matte) {
    LandmarkFrame& frame = video.frames[size_t(i)];
    frame.matte = to + "/" + frame.name + ".png";
    WriteImage(frame.matte, matte);
  };
  std::vector<int> left;             // without one
  for (int i = 0; i < count; ++i) {  // a video is read in its order
    const int f = video.frames[size_t(i)].frame;
    if (const std::optional<Image8> matte = own ? own->Read(f) : frames.Matte(f)) {
      write(i, *matte);
      bar.Update(i + 1 - int(left.size()), "frames");
    } else {
      left.push_back(i);
    }
  }
  if (left.empty()) return;
  const MatteRefiner refiner = RefinerOf(
      video,
      [&](int i) { return detector.Added(found_as[size_t(i)]); },
      [&](int i) {
        Image8 matte = detector.Matte(found_as[size_t(i)]);
        if (const auto face = FaceBoxOf(video.frames[size_t(i)]))
          LeaveToOthers(*face, others[found_as[size_t(i)]], matte);
        return matte;
      });
  constexpr size_t kAtOnce = 16;
  const size_t done = size_t(count) - left.size();
  for (size_t begin = 0; begin < left.size(); begin += kAtOnce) {
    const size_t end = std::min(begin + kAtOnce, left.size());
    tbb::parallel_for(begin, end, [&](size_t k) { write(left[k], refiner.Refine(left[k])); });
    bar.Update(int(done + end), "frames");
  }
}

}  // namespace

void DetectLandmarks(const LandmarkRunOptions& o, FrameSource& frames) {
  std::optional<OwnMattes> own;
  if (!o.matte.empty()) {
    std::error_code ignored;  // that the folder to write is not there yet
    if (fs::equivalent(o.matte, MatteFolder(o.out), ignored))
      throw Error("--matte",
                  "'" + o.matte + "' would be overwritten: move it, or name another --out");
    own.emplace(o.matte, frames);
  }
  const FoundHead head = FindHead(o.source, frames, o.size, o.quiet);
  PrintNotes(head.notes);
  const std::optional<FrameCrop>& crop = head.crop;
  if (crop) frames.CropTo(*crop);
  if (crop && own) own->CropTo(*crop);
  LandmarkVideo video;
  video.source = o.source;
  video.source_checksum = frames.Checksum();
  video.width = frames.width(), video.height = frames.height();
  video.crop = crop;
  video.frames_per_second = frames.frames_per_second();
  video.left_out = frames.count() - int(head.frames.size());
  const FrameSelection choice = FramesToLookAt(head.frames.size(), o.frames, video.rate());
  video.held_out = choice.held_out;
  std::vector<int> chosen;
  for (const size_t i : choice.frames) chosen.push_back(head.frames[i]);
  for (const int f : chosen) video.frames.push_back({frames.Name(f), f, {}, ""});
  const int count = int(chosen.size());
  FaceDetector detector(frames.width(), frames.height(), o.quiet);
  ProgressBar decoding("decode", count, o.quiet);
  ForFrames(
      frames,
      chosen,
      [&](size_t i, const Image8& image) { detector.Add(i, image); },
      [&](int done) { decoding.Update(done, "frames"); });
  ProgressBar looking("landmarks", count, o.quiet, OffTerminal::kLines);
  detector.Run(MillisecondsOf(video), true, [&](int done) { looking.Update(done, "frames"); });
  auto faces = detector.Faces();
  const Person person = KeepPerson(faces, head.ExpectedIn(chosen));
  if (!head.is_alone || !person.is_alone)
    PrintNotes({o.source +
                ": shows another person, too; the one who is seen larger or longer is used (cut "
                "the other out, if it is meant)"});
  for (size_t f = 0; f < video.frames.size(); ++f) video.frames[f].faces = std::move(faces.at(f));
  const auto seen = std::count_if(
      video.frames.begin(), video.frames.end(), [](const auto& f) { return !f.faces.empty(); });
  if (seen == 0) throw Error(o.source, "has no face in any of its frames");
  std::vector<size_t> found_as(video.frames.size());
  std::iota(found_as.begin(), found_as.end(), size_t(0));
  if (choice.held_out > 0) found_as = KeepBest(detector, o.frames, video);
  WriteMattes(o, frames, own, detector, found_as, person.others, video);
  AddScores(video);
  WriteLandmarks(o.out, video);
  if (o.quiet) return;
  std::printf("faces in %d of %d frames", int(seen), count);
  if (choice.held_out > 0)
    std::printf(", of which %zu are kept, of %d", video.frames.size(), frames.count());
  if (crop)
    std::printf("; the head's part is %dx%d at %d, %d of %dx%d, as %dx%d",
                crop->part.width,
                crop->part.height,
                crop->part.x,
                crop->part.y,
                crop->frame_width,
                crop->frame_height,
                crop->width,
                crop->height);
  std::printf(": %s\n", o.out.c_str());
}

void DeclareLandmarks(LandmarkRunOptions& o, CLI::App& command) {
  command
      .add_option(
          "--size",
          o.size,
          "side of the images, in pixels: the head's part of larger frames becomes an image of "
          "at most this, squared; 0: whole frames")
      ->check(CLI::Range(0, 8192));
  command
      .add_option(
          "--frames",
          o.frames,
          "of a longer video, choose so many frames that differ, the last fifth of them one "
          "after the other for testing; 0: all")
      ->check(CLI::Range(0, 100000));
  command.add_option("--matte",
                     o.matte,
                     "your own mattes: a folder of images, named as the frames or in their order, "
                     "or a grey video");
}

void AddLandmarks(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "landmarks", "find the points of the face in a video; needs node and Chromium");
  const auto o = std::make_shared<LandmarkRunOptions>();
  command->add_option("video", o->source, "a video file, or a folder of images")->required();
  command
      ->add_option(
          "-o,--out", o->out, "file to write, .json; its mattes go into FILE.mattes beside it")
      ->required();
  DeclareLandmarks(*o, *command);
  command->add_flag("--quiet", o->quiet, "print nothing but errors");
  command->callback([o] {
    FrameSource frames(o->source);
    PrintNotes(frames.notes());
    DetectLandmarks(*o, frames);
  });
}

}  // namespace cosplat
