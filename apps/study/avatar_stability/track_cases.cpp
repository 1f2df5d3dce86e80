// Imperfect tracks: missing frames, non-finite parameters, and noise.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "apps/study/avatar_stability/cases.h"
#include "assets/head/video.h"
#include "avatar/train/avatar_subject.h"
#include "splat/base/error.h"
#include "splat/base/json.h"
#include "splat/media/image_io.h"
#include "splat/train/loss/loss.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 40, kTestFrames = 4;
constexpr int kDropEvery = 10;                  // one image in this many is missing
constexpr int kBad = kFrames / kDropEvery + 1;  // plus one frame with a non-finite expression
constexpr int kSpoiledFrame = 7;
constexpr int kVideoSide = 48;  // px
constexpr int kSteps = 300;
constexpr size_t kGaussians = 1500;

// A video in the system's temporary folder, removed by the destructor.
class TemporaryVideo {
 public:
  TemporaryVideo() : TemporaryVideo(MakeFolder()) {  // the destructor runs even if this throws
    MakeHeadOptions options;
    options.frames = kFrames;
    options.test_frames = kTestFrames;
    options.size = kVideoSide;
    WriteProceduralVideo(folder_, options);
  }
  ~TemporaryVideo() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  TemporaryVideo(const TemporaryVideo&) = delete;
  TemporaryVideo& operator=(const TemporaryVideo&) = delete;

  void Spoil() const {
    for (int i = 1; i <= kFrames; i += kDropEvery)
      fs::remove(folder_ + "/image/" + std::to_string(i) + ".png");
    Json json = ReadJson(folder_ + "/flame_params.json");
    json["frames"][kSpoiledFrame]["expression"][3] = nullptr;  // JSON's representation of NaN
    std::ofstream(folder_ + "/flame_params.json") << json;
  }
  const std::string& folder() const { return folder_; }

 private:
  explicit TemporaryVideo(const std::string& folder) : folder_(folder) {}
  static std::string MakeFolder() {
    std::string pattern = (fs::temp_directory_path() / "cosplat_study_XXXXXX").string();
    if (!mkdtemp(pattern.data()))
      throw Error(fs::temp_directory_path().string(), "folder", "cannot make one in it");
    return pattern;
  }
  std::string folder_;
};

double ShareLost(const Gaussians& gaussians) {
  size_t lost = 0, count = 0;
  for (const Buffer<float>& values : gaussians.values)
    for (const float x : values) {
      lost += !std::isfinite(x);
      ++count;
    }
  return double(lost) / double(count);
}

TrainSettings ShortTraining(float unit) {
  TrainSettings s;
  s.iterations = kSteps;
  s.degree = 0;
  s.background = Background::kRandom;
  s.schedule.densify_until = 0;
  s.schedule.opacity_reset_every = kSteps + 1;
  s.schedule.position_rate_steps = kSteps;
  ScaleToUnit(unit, s);
  return s;
}

// Adam's first step (Kingma & Ba 2015) on a NaN loss, all of whose derivatives are NaN.
Gaussians AfterNaiveStep(Gaussians gaussians) {
  constexpr float kRate = 1e-3f, kEps = 1e-15f;
  const float gradient = std::numeric_limits<float>::quiet_NaN();
  for (Buffer<float>& values : gaussians.values)
    for (float& x : values) x -= kRate * gradient / (std::sqrt(gradient * gradient) + kEps);
  return gaussians;
}

// Noise as in the output of a landmark tracker on a still head.
FlameParams Trembling(Rng& rng) {
  constexpr float kExpression = 0.1f;
  FlameParams params;
  params.expression.resize(kExpressionCount);
  for (float& x : params.expression) x = kExpression * rng.Normal();
  return params;
}

// White where the images are equal.
Image8 DifferenceImage(const RenderedImage& a, const RenderedImage& b) {
  constexpr float kTimes = 10;
  RenderedImage difference = a;
  for (size_t k = 0; k < a.color.size(); ++k)
    difference.color[k] = 1 - kTimes * std::abs(a.color[k] - b.color[k]);
  return ToBytes(difference.ToImage());
}

}  // namespace

StabilityCase BadFramesCase(const StudyHead& head) {
  StabilityCase c;
  c.key = "bad_frames";
  c.title = "Frames that are missing or no numbers";
  c.what =
      "300 steps of training on a video of 40 frames, of which 4 images are missing and one "
      "expression is NaN. One step on a loss of NaN turns every parameter into NaN.";
  c.quantity = "share of the parameters lost, every bad frame counted, the loss finite";
  c.naive.name = "Frames are taken as they come";
  c.ours.name = "Bad frames are skipped, counted and listed";
  const TemporaryVideo video;
  video.Spoil();
  AvatarSettings settings;
  settings.initial_gaussians = kGaussians;
  settings.bust = AvatarSettings::BustChoice::kNo;
  AvatarSubject subject(head.head.model, LoadTrackedVideo(video.folder(), {}), settings);
  const TrainSettings training = ShortTraining(subject.extent());
  Trainer trainer(
      training, subject, subject.InitialGaussians(training.degree, Basis::kDcsh, training.seed));
  double loss = 0;
  for (int i = 0; i < kSteps; ++i) loss += trainer.Step().loss;
  BoundBothWays bound(subject.Model(trainer.state().gaussians));
  c.ours.value = ShareLost(bound.ours.model.gaussians);
  if (!std::isfinite(loss) || subject.video().skipped.size() != kBad)
    c.ours.value = std::numeric_limits<double>::infinity();
  c.ours.image = ImageOf(bound.ours, StudyCamera());
  bound.ours.model.gaussians = AfterNaiveStep(bound.ours.model.gaussians);
  c.naive.value = ShareLost(bound.ours.model.gaussians);
  c.naive.image = ImageOf(bound.ours, StudyCamera());
  return c;
}

StabilityCase JitterCase(const StudyHead& head) {
  constexpr int kShown = 16;
  constexpr size_t kSharp = 15000;  // Gaussians, small ones: jitter is invisible on smooth regions
  StabilityCase c;
  c.key = "jitter";
  c.title = "A still head, a trembling track";
  c.what =
      "Sixteen frames of a head at rest with a tracker's noise on its parameters. The image must "
      "not tremble more than the mesh. Shown: ten times the difference of the last two.";
  c.quantity = "least likeness of two frames that follow each other";
  c.unit = "dB";
  c.bound = 39;
  c.at_least = true;
  c.naive = {"exp(log s A / A0), as released", INFINITY, {}};
  c.ours = {"s sqrt(A / A0)", INFINITY, {}};
  BoundBothWays bound(PaintedAvatar(head.head, kSharp, 0));
  Rng rng{8};
  RenderedImage last[2];
  for (int i = 0; i < kShown; ++i) {
    bound.Pose(head.Vertices(Trembling(rng)));
    for (const bool is_ours : {false, true}) {
      StabilityForm& form = is_ours ? c.ours : c.naive;
      const BoundBothWays::Way& way = is_ours ? bound.ours : bound.naive;
      RenderedImage image = DrawOver(way, StudyCamera(), {1, 1, 1});
      if (i > 0) form.value = std::min(form.value, Psnr(image.color, last[is_ours].color));
      if (i + 1 == kShown) form.image = DifferenceImage(image, last[is_ours]);
      last[is_ours] = std::move(image);
    }
  }
  return c;
}

}  // namespace cosplat
