// cosplat-study mattes: how wrong mattes are before and after MatteRefiner, on the made head before
// made backgrounds.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "apps/cosplat/run/frame_source.h"
#include "apps/cosplat/run/video_mattes.h"
#include "apps/study/commands.h"
#include "apps/study/mattes/made_video.h"
#include "splat/base/files.h"
#include "splat/media/image_io.h"
#include "splat/media/signed_distance.h"

namespace cosplat {
namespace {

struct MattesCommand {
  std::string out, landmarks;
  int frames = 60, size = 512;
  unsigned seed = 0;
};

// Mean absolute errors of alpha, [0, 1]: of all pixels, and within 8 px of the true rim.
struct MatteError {
  double whole = 0, rim = 0;
};

MatteError ErrorOf(const Image8& matte, const Image8& truth) {
  constexpr float kRim = 8;  // px
  const Image distance = SignedDistance(truth, 128);
  MatteError error;
  double in_rim = 0;
  for (size_t i = 0; i < truth.data.size(); ++i) {
    const double wrong = std::abs(double(matte.data[i]) - truth.data[i]) / 255;
    error.whole += wrong;
    if (std::abs(distance.data[i]) > kRim) continue;
    error.rim += wrong;
    ++in_rim;
  }
  error.whole /= double(truth.data.size());
  error.rim /= std::max(in_rim, 1.);
  return error;
}

void Print(const char* background, const char* what, const std::vector<MatteError>& errors) {
  MatteError mean;
  for (const MatteError& error : errors)
    mean.whole += error.whole / double(errors.size()),
        mean.rim += error.rim / double(errors.size());
  std::printf("%-8s %-8s %.4f  %.4f\n", background, what, mean.whole, mean.rim);
}

// The image, and what the network's and the refined matte cut out of it, side by side on green.
void WriteSheet(const std::string& path, const MatteFrame& frame, const Image8& refined) {
  const int width = frame.image.width;
  Image8 sheet(3 * width, frame.image.height, 3);
  for (int y = 0; y < sheet.height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) {
        const auto cut = [&](const Image8& matte) {
          const int alpha = matte.at(x, y, 0), green = c == 1 ? 255 : 0;
          return uint8_t((frame.image.at(x, y, c) * alpha + green * (255 - alpha)) / 255);
        };
        sheet.at(x, y, c) = frame.image.at(x, y, c);
        sheet.at(width + x, y, c) = cut(frame.matte);
        sheet.at(2 * width + x, y, c) = cut(refined);
      }
  WriteImage(path, sheet);
}

MatteRefiner RefinerOfFrames(const std::vector<MatteFrame>& frames, double network_px) {
  return MatteRefiner({int(frames.size()),
                       [&](int f) { return frames[size_t(f)].image; },
                       [&](int f) { return frames[size_t(f)].matte; },
                       [&](int f) { return frames[size_t(f)].face; },
                       network_px});
}

// Frames of a video with the mattes of its landmark file: evenly, so many as the background is
// looked for in.
std::vector<MatteFrame> FilmedFrames(const LandmarkVideo& marks) {
  constexpr size_t kFrames = 48;
  FrameSource source(marks.source);
  if (marks.crop) source.CropTo(*marks.crop);
  const size_t step = std::max<size_t>(1, marks.frames.size() / kFrames);
  std::vector<MatteFrame> frames;
  for (size_t f = 0; f < marks.frames.size(); f += step)
    frames.push_back({source.Read(marks.frames[f].frame),
                      {},
                      ReadImage(marks.frames[f].matte),
                      FaceBoxOf(marks.frames[f])});
  return frames;
}

void DrawFilmed(const MattesCommand& o) {
  const LandmarkVideo marks = ReadLandmarks(o.landmarks);
  const std::vector<MatteFrame> frames = FilmedFrames(marks);
  const MatteRefiner refiner =
      RefinerOfFrames(frames, MadeNetworkPx(std::max(marks.width, marks.height)));
  tbb::parallel_for(size_t(0), frames.size() / 6, [&](size_t i) {
    const size_t f = 6 * i;
    WriteSheet(o.out + "/" + std::to_string(f) + ".png", frames[f], refiner.Refine(int(f)));
  });
}

void MeasureMattes(const MattesCommand& o) {
  if (!o.out.empty()) MakeDirectories(o.out);
  if (!o.landmarks.empty()) return DrawFilmed(o);
  const std::vector<Image8> heads = DrawHeads(o.frames, o.size, o.seed);
  std::printf("%-8s %-8s %-7s %s\n", "before", "matte", "whole", "rim");
  for (const auto background :
       {MadeBackground::kStill, MadeBackground::kMoving, MadeBackground::kBusy}) {
    const std::vector<MatteFrame> made = Compose(heads, background, o.seed);
    const MatteRefiner refiner = RefinerOfFrames(made, MadeNetworkPx(o.size));
    std::vector<MatteError> before(made.size()), after(made.size());
    tbb::parallel_for(size_t(0), made.size(), [&](size_t f) {
      const Image8 refined = refiner.Refine(int(f));
      before[f] = ErrorOf(made[f].matte, made[f].truth);
      after[f] = ErrorOf(refined, made[f].truth);
      if (!o.out.empty() && f % 20 == 0)
        WriteSheet(o.out + "/" + NameOf(background) + std::to_string(f) + ".png", made[f], refined);
    });
    Print(NameOf(background), "network", before);
    Print(NameOf(background), "refined", after);
  }
}

}  // namespace

void AddMattes(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("mattes", "errors of mattes before and after they are refined");
  const auto o = std::make_shared<MattesCommand>();
  command->add_option("-o,--out", o->out, "folder for pictures of some frames")->default_str("");
  command
      ->add_option("--landmarks",
                   o->landmarks,
                   "file whose mattes are refined and drawn instead, of a network")
      ->default_str("");
  command->add_option("--frames", o->frames, "of the made head")->check(CLI::Range(8, 1000));
  command->add_option("--size", o->size, "their width and height, px")->check(CLI::Range(64, 2048));
  command->add_option("--seed", o->seed, "of motion, backgrounds and noise");
  command->callback([o] { MeasureMattes(*o); });
}

}  // namespace cosplat
