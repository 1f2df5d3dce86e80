// A tiny tracked video of the procedural head, and short trainings on it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "assets/head/procedural_head.h"
#include "assets/head/video.h"
#include "avatar/train/avatar_subject.h"
#include "tests/avatar/made_video.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {

// 24 frames of 96 x 96, the last 4 held out; made once per process.
struct SmallVideo {
  TemporaryFolder folder;
  FlameModel flame = MakeProceduralHead();
  SmallVideo() {
    MakeHeadOptions options;
    options.frames = 24;
    options.test_frames = 4;
    options.size = 96;
    WriteProceduralVideo(folder.path(), options);
  }
  static const SmallVideo& Get() {
    static const SmallVideo video;
    return video;
  }
};

// Those of `removed` (ascending) that the subject lets go.
inline std::vector<uint32_t> Allowed(AvatarSubject& subject,
                                     const Gaussians& gaussians,
                                     const std::vector<uint32_t>& removed) {
  Buffer<uint8_t> unwanted(gaussians.size(), 0);
  for (const uint32_t i : removed) unwanted[i] = 1;
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage image;
  const Canvas canvas{*rasterizer, image, *tape};
  subject.Veto(gaussians, &canvas, unwanted, HostStream());
  std::vector<uint32_t> allowed;
  for (const uint32_t i : removed)
    if (unwanted[i]) allowed.push_back(i);
  return allowed;
}

// The first `frames` training frames at 96 / resolution pixels.
inline TrackedVideo LoadSmallVideo(size_t frames, int resolution) {
  TrackedVideo video = LoadTrackedVideo(SmallVideo::Get().folder.path(), {-1, resolution});
  if (video.train.size() > frames) video.train.resize(frames);
  return video;
}

// A subject and its trainer. S: AvatarSubject or derived from it.
template <class S = AvatarSubject>
struct Training {
  S subject;
  TrainSettings settings;
  Trainer trainer;

  Training(TrackedVideo video,
           const AvatarSettings& avatar,
           const TrainSettings& first_settings,
           const FlameModel& flame = SmallVideo::Get().flame)
      : subject(flame, std::move(video), avatar),
        settings(Scaled(first_settings, subject.extent())),
        trainer(settings,
                subject,
                subject.InitialGaussians(settings.degree, Basis::kDcsh, settings.seed)) {}

  // Mean loss of the last tenth.
  double Run(int steps) {
    double sum = 0;
    const int last = std::max(1, steps / 10);
    for (int i = 0; i < steps; ++i) {
      const double loss = trainer.Step().loss;
      if (i >= steps - last) sum += loss / last;
    }
    return sum;
  }
  const Gaussians& gaussians() const { return trainer.state().gaussians; }
  AvatarModel Model() const { return subject.Model(gaussians()); }

 private:
  static TrainSettings Scaled(TrainSettings settings, float unit) {
    ScaleToUnit(unit, settings);
    return settings;
  }
};

}  // namespace cosplat::test
