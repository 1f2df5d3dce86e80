// cosplat landmarks: the points of the face in each frame of a video, and mattes, by MediaPipe in
// headless Chromium.
//
// FrameSource -> FaceDetector on a few frames -> HeadCrop -> FrameSource::CropTo -> FaceDetector ->
// ChooseFrames -> a landmark file with its mattes, which `cosplat track` reads.
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
#include "apps/cosplat/run/frame_source.h"
#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/video_mattes.h"
#include "flame/fit/choose_frames.h"
#include "flame/fit/head_crop.h"
#include "flame/fit/landmark_scores.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// Frames in which the head is looked for, and their longer side, px.
constexpr size_t kCoarseFrames = 64, kFramesOfWindows = 12, kFirstFramesOfWindows = 3;
constexpr int kCoarseSide = 640;
// Apart by so much, no face is taken for one that moved.
constexpr double kApart = 1000;  // milliseconds

// Reads frames in their order, some ahead of what is done with them in parallel.
void ForFrames(const std::vector<size_t>& which,
               const std::function<Image8(int)>& read,
               const std::function<void(size_t i, const Image8&)>& use,
               const std::function<void(int done)>& progress) {
  constexpr size_t kAhead = 16;
  for (size_t begin = 0; begin < which.size(); begin += kAhead) {
    std::vector<Image8> images;
    const size_t end = std::min(begin + kAhead, which.size());
    for (size_t i = begin; i < end; ++i) images.push_back(read(int(which[i])));
    tbb::parallel_for(begin, end, [&](size_t i) { use(i, images[i - begin]); });
    progress(int(end));
  }
}

// Squares of half the frames' shorter side that overlap by half.
std::vector<Crop> SmallWindows(int width, int height) {
  const int side = std::max(1, std::min(width, height) / 2);
  const auto places = [&](int length) {
    std::vector<int> at;
    const int count = 1 + (length - side + side / 2 - 1) / std::max(1, side / 2);
    for (int i = 0; i < count; ++i) at.push_back(count > 1 ? i * (length - side) / (count - 1) : 0);
    return at;
  };
  std::vector<Crop> windows;
  for (const int y : places(height))
    for (const int x : places(width)) windows.push_back({x, y, side, side});
  return windows;
}

// Faces in `count` frames spread over the video, which are looked for in each of the windows, all
// of one size. [frames] px of the frame.
std::vector<std::vector<DetectedFace>> SearchFaces(const LandmarkRunOptions& o,
                                                   const FrameSource& frames,
                                                   size_t count,
                                                   const std::vector<Crop>& windows) {
  const size_t total = size_t(frames.count());
  count = std::min(count, total);
  std::vector<size_t> which;
  for (size_t i = 0; i < count; ++i) which.push_back((2 * i + 1) * total / (2 * count));
  std::vector<double> times;
  for (size_t i = 0; i < count * windows.size(); ++i) times.push_back(kApart * double(i));
  const Crop& first = windows[0];
  const double scale = std::min(1.0, double(kCoarseSide) / std::max(first.width, first.height));
  const int width = std::max(1, int(std::lround(scale * first.width)));
  const int height = std::max(1, int(std::lround(scale * first.height)));
  FaceDetector detector(width, height, o.quiet);
  ProgressBar bar("find the head", int(count + times.size()), o.quiet);
  ForFrames(
      which,
      [&](int f) { return frames.ReadWhole(f); },
      [&](size_t i, const Image8& image) {
        for (size_t w = 0; w < windows.size(); ++w)
          detector.Add(i * windows.size() + w,
                       ResizeByArea(Cropped(image, windows[w]), width, height));
      },
      [&](int done) { bar.Update(done, "images"); });
  detector.Run(times, false, [&](int done) { bar.Update(int(count) + done, "images"); });
  const auto found = detector.Faces();
  std::vector<std::vector<DetectedFace>> faces(count);
  for (size_t i = 0; i < found.size(); ++i)
    for (DetectedFace face : found[i]) {
      const Crop& w = windows[i % windows.size()];
      for (auto& [x, y] : face.points) {
        x = w.x + x * w.width / width;
        y = w.y + y * w.height / height;
      }
      faces[i / windows.size()].push_back(std::move(face));
    }
  return faces;
}

size_t WithFaces(const std::vector<std::vector<DetectedFace>>& faces) {
  return size_t(std::count_if(faces.begin(), faces.end(), [](auto& f) { return !f.empty(); }));
}

// The same for a head that is too small for the detector in whole frames, which sees no face that
// is smaller than some twentieth of its image. Few frames are searched by windows, and the others
// where these have the head, unless it is not there.
std::vector<std::vector<DetectedFace>> SearchSmallFaces(const LandmarkRunOptions& o,
                                                        const FrameSource& frames) {
  const int width = frames.width(), height = frames.height();
  const std::vector<Crop> windows = SmallWindows(width, height);
  const auto first = SearchFaces(o, frames, kFirstFramesOfWindows, windows);
  if (WithFaces(first) > 0) {
    const FrameCrop head = HeadCrop(first, width, height, o.size);
    const Crop& part = head.part;
    Crop around{0, 0, std::min(2 * part.width, width), std::min(2 * part.height, height)};
    around.x = std::clamp(part.x - part.width / 2, 0, width - around.width);
    around.y = std::clamp(part.y - part.height / 2, 0, height - around.height);
    auto near = SearchFaces(o, frames, kCoarseFrames, {around});
    if (2 * WithFaces(near) >= near.size()) return near;
  }
  return SearchFaces(o, frames, kFramesOfWindows, windows);
}

// The part around the head; none where the frames are no larger than it would be as an image.
std::optional<FrameCrop> FindCrop(const LandmarkRunOptions& o, const FrameSource& frames) {
  const int width = frames.width(), height = frames.height();
  if (o.size == 0 || std::max(width, height) <= o.size) return {};
  auto faces = SearchFaces(o, frames, kCoarseFrames, {{0, 0, width, height}});
  if (2 * WithFaces(faces) < faces.size()) {
    auto small = SearchSmallFaces(o, frames);
    if (WithFaces(small) * faces.size() > WithFaces(faces) * small.size()) faces = std::move(small);
  }
  if (WithFaces(faces) == 0)
    throw Error(o.source,
                Format("has no face in any of {} frames that were looked at", faces.size()));
  return HeadCrop(faces, width, height, o.size);
}

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

// Mattes made by somebody count before the frames' alpha, and that before what the detector found
// in the images `found_as`, which is refined.
void WriteMattes(const LandmarkRunOptions& o,
                 const FrameSource& frames,
                 const std::optional<OwnMattes>& own,
                 const FaceDetector& detector,
                 const std::vector<size_t>& found_as,
                 LandmarkVideo& video) {
  const std::string to = (fs::path(o.out).parent_path() / "mattes").string();
  MakeDirectories(to);
  const int count = int(video.frames.size());
  ProgressBar bar("mattes", count, o.quiet);
  const auto write = [&](int i, const Image8& matte) {
    LandmarkFrame& frame = video.frames[size_t(i)];
    frame.matte = to + "/" + frame.name + ".png";
    WriteImage(frame.matte, matte);
  };
  if (own || frames.has_alpha()) {  // a video is read in its order
    for (int i = 0; i < count; ++i) {
      const int f = video.frames[size_t(i)].frame;
      write(i, own ? own->Read(f) : frames.Alpha(f));
      bar.Update(i + 1, "frames");
    }
    return;
  }
  const MatteRefiner refiner = RefinerOf(
      video,
      [&](int i) { return detector.Added(found_as[size_t(i)]); },
      [&](int i) { return detector.Matte(found_as[size_t(i)]); });
  constexpr int kAtOnce = 16;
  for (int begin = 0; begin < count; begin += kAtOnce) {
    const int end = std::min(begin + kAtOnce, count);
    tbb::parallel_for(begin, end, [&](int i) { write(i, refiner.Refine(i)); });
    bar.Update(end, "frames");
  }
}

}  // namespace

void DetectLandmarks(const LandmarkRunOptions& o, FrameSource& frames) {
  std::optional<OwnMattes> own;
  if (!o.matte.empty()) own.emplace(o.matte, frames);
  const std::optional<FrameCrop> crop = FindCrop(o, frames);
  if (crop) frames.CropTo(*crop);
  if (crop && own) own->CropTo(*crop);
  LandmarkVideo video;
  video.source = o.source;
  video.width = frames.width(), video.height = frames.height();
  video.crop = crop;
  video.frames_per_second = frames.frames_per_second();
  const FrameSelection choice = FramesToLookAt(size_t(frames.count()), o.frames, video.rate());
  video.held_out = choice.held_out;
  for (const size_t f : choice.frames)
    video.frames.push_back({frames.Name(int(f)), int(f), {}, ""});
  const int count = int(choice.frames.size());
  FaceDetector detector(frames.width(), frames.height(), o.quiet);
  ProgressBar decoding("decode", count, o.quiet);
  ForFrames(
      choice.frames,
      [&](int f) { return frames.Read(f); },
      [&](size_t i, const Image8& image) { detector.Add(i, image); },
      [&](int done) { decoding.Update(done, "frames"); });
  ProgressBar looking("landmarks", count, o.quiet, OffTerminal::kLines);
  detector.Run(MillisecondsOf(video), true, [&](int done) { looking.Update(done, "frames"); });
  auto faces = detector.Faces();
  for (size_t f = 0; f < video.frames.size(); ++f) video.frames[f].faces = std::move(faces.at(f));
  const auto seen = std::count_if(
      video.frames.begin(), video.frames.end(), [](const auto& f) { return !f.faces.empty(); });
  if (seen == 0) throw Error(o.source, "has no face in any of its frames");
  std::vector<size_t> found_as(video.frames.size());
  std::iota(found_as.begin(), found_as.end(), size_t(0));
  if (choice.held_out > 0) found_as = KeepBest(detector, o.frames, video);
  WriteMattes(o, frames, own, detector, found_as, video);
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
  command->add_option("-o,--out", o->out, "file to write, .json; mattes/ goes beside it")
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
