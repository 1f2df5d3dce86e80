#include "apps/cosplat/run/track_run.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/train_run.h"
#include "flame/eyelids.h"
#include "flame/fit/face_looks.h"
#include "flame/io/imavatar_writer.h"
#include "flame/model.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// A face seen more from the side has half its landmarks guessed.
constexpr double kMaxTurned = 75;  // degrees
// A frame is unusable beyond so many times the median error, if that is visible at all.
constexpr double kMaxErrorRatio = 4, kMinError = 0.02;  // the latter in units of the face's size

void CheckOfVideo(const LandmarkVideo& marks, const std::string& source, FrameSource& frames) {
  const int width = marks.crop ? marks.crop->frame_width : marks.width;
  const int height = marks.crop ? marks.crop->frame_height : marks.height;
  // Of another detector, which saw the bars.
  const Crop& all = frames.in_file();
  if (width == all.width && height == all.height) frames.EndAt(all);
  const Crop& picture = frames.picture();
  if (width != picture.width || height != picture.height)
    throw Error(marks.file,
                marks.crop ? "crop.frame_width, frame_height" : "width, height",
                "are " + SizeText(width, height) + ", " + source + " is " +
                    SizeText(picture.width, picture.height));
  const double rate = frames.frames_per_second();
  constexpr double kSameRate = 0.01;
  if (rate > 0 && marks.frames_per_second > 0 &&
      std::abs(marks.frames_per_second - rate) > kSameRate * rate)
    throw Error(marks.file,
                "frames_per_second",
                Format("is {:g}, {} has {:g}", marks.frames_per_second, source, rate));
  const bool same = fs::path(marks.source).filename() == fs::path(source).filename() ||
                    IsInside(source, marks.source);  // a folder that has the images in another one
  if (!marks.source.empty() && !same)
    PrintNotes({marks.file + ": the landmarks are of " + marks.source + ", not of " + source});
  const std::optional<uint32_t> checksum = frames.Checksum();
  if (marks.source_checksum && checksum && *marks.source_checksum != *checksum)
    throw Error(marks.file,
                "source_checksum",
                Format("is {}, {} has {}: the landmarks are of another film, or of this one before "
                       "it was changed; find them again, or take this field out if its frames are "
                       "the same",
                       *marks.source_checksum,
                       source,
                       *checksum));
  for (size_t i = 0; i < marks.frames.size(); ++i) {
    const LandmarkFrame& frame = marks.frames[i];
    const std::string field = "frames[" + std::to_string(i) + "]";
    if (frame.frame >= frames.count())
      throw Error(marks.file,
                  field + ".frame",
                  Format("is {}, {} has {} frames", frame.frame, source, frames.count()));
    if (frame.name != frames.Name(frame.frame))
      throw Error(marks.file,
                  field + ".name",
                  "is '" + frame.name + "', frame " + std::to_string(frame.frame) + " of " +
                      source + " is '" + frames.Name(frame.frame) + "'");
  }
}

FlameModel TrackingModel(const TrackRunOptions& o) {
  FlameModel model = LoadFlameModel(o.flame);
  return o.embedding.empty() ? WithEyelids(std::move(model)) : model;
}

double MedianError(const LandmarkFit& fit) {
  std::vector<double> errors;
  for (const auto& frame : fit.frames)
    if (frame) errors.push_back(frame->error);
  std::nth_element(errors.begin(), errors.begin() + long(errors.size() / 2), errors.end());
  return errors[errors.size() / 2];
}

// What is wrong with a fitted frame, if anything.
std::string ProblemOf(const FittedFrame& frame, double size, double median) {
  if (frame.error > std::max(kMaxErrorRatio * median, kMinError * size))
    return Format(
        "landmarks are {:.1f} px from the face, {:.1f} px in other frames", frame.error, median);
  if (frame.turned > kMaxTurned)
    return Format("the face is turned away by {:.0f} degrees", frame.turned);
  return "";
}

void Keep(TrackRun& run) {
  run.skipped = run.chosen.skipped;
  const double median = MedianError(run.fit);
  for (size_t f = 0; f < run.fit.frames.size(); ++f) {
    if (!run.fit.frames[f]) continue;
    const std::string problem = ProblemOf(*run.fit.frames[f], run.chosen.faces[f]->size, median);
    if (problem.empty()) {
      run.kept.push_back(f);
    } else {
      run.skipped.push_back({run.marks.frames[f].name, problem});
    }
  }
  CheckSkipped(run.marks.file, run.kept.size(), run.skipped);
}

Image8 MatteOf(const LandmarkFrame& frame, const LandmarkVideo& marks) {
  Image8 matte = ReadImage(frame.matte);
  if (matte.channels != 1 || matte.width != marks.width || matte.height != marks.height)
    throw Error(frame.matte,
                "is " + SizeText(matte.width, matte.height) + " with " +
                    std::to_string(matte.channels) + " channels, expected " +
                    SizeText(marks.width, marks.height) + " with 1");
  return matte;
}

// The frame, with its matte as alpha if it has one.
Image8 ImageOf(const FrameSource& frames, const LandmarkFrame& frame, const LandmarkVideo& marks) {
  Image8 image = frames.Read(frame.frame);
  if (frame.matte.empty()) return image;
  const Image8 matte = MatteOf(frame, marks);
  Image8 out(image.width, image.height, 4);
  for (size_t i = 0; i < image.pixels(); ++i) {
    std::copy_n(&image.data[i * 3], 3, &out.data[i * 4]);
    out.data[i * 4 + 3] = matte.data[i];
  }
  return out;
}

// Whether the frames have mattes. Reads all of them, so that a broken one is found early.
bool HasMattes(const TrackRun& run) {
  const bool first = !run.marks.frames[run.kept[0]].matte.empty();
  for (size_t f : run.kept) {
    if (run.marks.frames[f].matte.empty() == first)
      throw Error(
          run.marks.file,
          "frames[" + std::to_string(f) + "].matte",
          first ? "is missing, earlier frames have one" : "is there, earlier frames have none");
    if (first) MatteOf(run.marks.frames[f], run.marks);
  }
  return first;
}

TrackedFrame TrackedFrameOf(const TrackRun& run, size_t f) {
  TrackedFrame frame;
  frame.name = run.marks.frames[f].name;
  frame.camera = run.fit.camera;
  frame.params = run.fit.frames[f]->params;
  return frame;
}

// Small avatars of the kept frames make their parameters more exact.
void RefineKept(const TrackRunOptions& o, const FrameSource& frames, TrackRun& run) {
  TrackedVideo video;
  video.source = o.source;
  video.shape = run.fit.shape;
  video.static_offset = run.fit.static_offset;
  for (size_t i = 0; i < run.kept.size(); ++i) {
    video.train.push_back(TrackedFrameOf(run, run.kept[i]));
    video.train.back().timestep = int(i);
  }
  const auto image = [&](const TrackedFrame& frame) {
    return ImageOf(frames, run.marks.frames[run.kept[size_t(frame.timestep)]], run.marks);
  };
  run.held_out_psnr = RefineByAvatars(o.flame, video, image, o.avatar_rounds, o.quiet);
  if (run.held_out_psnr.empty()) return;
  for (size_t i = 0; i < run.kept.size(); ++i)
    run.fit.frames[run.kept[i]]->params = video.train[i].params;
  MeasureFit(run.model, run.embedding, run.chosen.faces, run.fit);
}

// Copies images and masks; returns each mask's extent, and what is seen of the face in each.
struct WrittenImages {
  std::vector<std::array<float, 4>> boxes;  // [kept]
  std::vector<double> sharpness;            // [kept] SharpnessOf
  std::vector<std::vector<float>> colors;   // [kept] FaceColorsOf
};

WrittenImages WriteImages(const TrackRunOptions& o,
                          const TrackRun& run,
                          const FrameSource& frames) {
  WrittenImages written;
  written.boxes.assign(run.kept.size(), {-1, -1, 1, 1});
  written.sharpness.resize(run.kept.size());
  written.colors.resize(run.kept.size());
  ProgressBar bar("write", int(run.kept.size()), o.quiet);
  std::vector<int> which;
  for (const size_t f : run.kept) which.push_back(run.marks.frames[f].frame);
  const auto write = [&](size_t i, const Image8& image) {
    const LandmarkFrame& frame = run.marks.frames[run.kept[i]];
    WriteImage(o.out + "/image/" + frame.name + ".png", image);
    const auto& points = run.chosen.faces[run.kept[i]]->points;
    written.sharpness[i] = SharpnessOf(image, points);
    written.colors[i] = FaceColorsOf(image, points);
    if (!run.mattes) return;
    const Image8 matte = MatteOf(frame, run.marks);
    WriteImage(o.out + "/mask/" + frame.name + ".png", matte);
    written.boxes[i] = ImavatarBox(matte);
  };
  ForFrames(frames, which, write, [&](int done) { bar.Update(done, "frames"); });
  return written;
}

// How many of the kept frames are for testing; -1 if nobody said.
int TestFrames(const TrackRun& run) {
  if (run.marks.held_out == 0) return -1;
  const size_t first = run.marks.frames.size() - size_t(run.marks.held_out);
  return int(run.kept.end() - std::lower_bound(run.kept.begin(), run.kept.end(), first));
}

void PrintSummary(const TrackRunOptions& o, const TrackRun& run) {
  std::printf(
      "%zu of %zu frames tracked, %.2f px from the landmarks on average; focal length "
      "%.0f px: %s\n",
      run.kept.size(),
      run.fit.frames.size(),
      run.fit.error,
      run.whole_camera().fx,
      o.out.c_str());
  if (o.avatar_rounds > 0) std::printf("%s\n", AvatarRoundsText(run.held_out_psnr).c_str());
  if (run.chosen.cuts > 0) std::printf("%d cuts, or changes to another face\n", run.chosen.cuts);
  PrintSkipped(run.skipped);
  for (const std::string& line : run.advice) std::printf("for a better avatar: %s\n", line.c_str());
}

}  // namespace

TrackRun FitTrack(const TrackRunOptions& o, FrameSource& frames) {
  TrackRun run;
  run.marks = ReadLandmarks(o.landmarks);
  CheckOfVideo(run.marks, o.source, frames);
  if (run.marks.crop) frames.CropTo(*run.marks.crop);
  run.chosen = ChooseFaces(run.marks);
  run.model = TrackingModel(o);
  run.embedding = o.embedding.empty()
                      ? FlameLandmarks(run.model, run.marks.set)
                      : ReadLandmarkEmbedding(o.embedding, run.model, run.marks.point_count());
  if (o.silhouette && run.marks.frames.at(0).matte.empty())
    throw Error("--silhouette", "needs mattes, of which '" + o.landmarks + "' has none");
  const int side = std::max(frames.in_file().width, frames.in_file().height);
  constexpr double kMinFocal = 0.3;  // of the longer side: 118 degrees
  if (o.focal > 0 && o.focal < kMinFocal * side)
    throw Error(
        Format("--focal {:g}", o.focal),
        Format("is in pixels, of a picture of {}: a phone has some {:.0f}", side, 0.8 * side));
  LandmarkFitOptions options;
  options.focal = o.focal;
  options.crop = run.marks.crop;
  options.silhouette = o.silhouette;
  options.source = o.source;
  options.image = [&](size_t f) { return ImageOf(frames, run.marks.frames[f], run.marks); };
  run.fit = FitLandmarks(run.model,
                         run.embedding,
                         run.chosen.faces,
                         run.marks.width,
                         run.marks.height,
                         options,
                         ShowProgress("track", "fits", o.quiet));
  Keep(run);
  run.mattes = HasMattes(run);
  if (run.mattes) RefineKept(o, frames, run);
  return run;
}

void RunTracking(const TrackRunOptions& o, FrameSource& frames) {
  TrackRun run = FitTrack(o, frames);
  MakeDirectories(o.out + "/image");
  if (run.mattes) MakeDirectories(o.out + "/mask");
  RemoveFile(o.out + "/flame_params.json");  // so that a half is not taken for the whole
  TrackedVideo track = TrackOf(run.model);
  track.shape = run.fit.shape;
  track.static_offset = run.fit.static_offset;
  const WrittenImages written = WriteImages(o, run, frames);
  run.advice = AdviceFor(run, written.sharpness, OtherLooks(written.colors));
  for (size_t f : run.kept) track.train.push_back(TrackedFrameOf(run, f));
  WriteTrackReport(o, run, frames);
  WriteImavatarTrack(o.out, track, written.boxes, TestFrames(run));
  if (!o.quiet) PrintSummary(o, run);
}

}  // namespace cosplat
