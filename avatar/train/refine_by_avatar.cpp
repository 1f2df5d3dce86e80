#include "avatar/train/refine_by_avatar.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include "avatar/surface/silhouette.h"
#include "flame/mouth.h"
#include "splat/base/error.h"
#include "splat/base/median.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

// Left out are eight frames of every 32: neighbours are so alike that single ones would be known.
constexpr size_t kBlock = 8, kBlocksPerHeldOut = 4;
constexpr size_t kMinFrames = 2 * kBlock + kBlock / 2;  // half a block to judge by
// A face that is small in the picture is not brought to its size if that takes more: a long video
// of reduced pictures is held in memory.
constexpr double kMaxPixels = 512 * 512;
// Frames are fitted in lots of consecutive ones, each by one fitter: at most so many lots, of at
// least so many frames. They do not depend on the threads.
constexpr size_t kLots = 32, kFramesOfLot = 8;
// A start is another's place if its loss is at most this share: what a frame does not determine
// would drift from frame to frame.
constexpr double kClearlyBetter = 0.9;

double MedianFaceSize(const std::vector<TrackedFrame*>& frames) {
  std::vector<double> sizes;
  for (const TrackedFrame* frame : frames) sizes.push_back(FaceSizeIn(*frame));
  return Median(sizes);
}

double ScaleFor(const std::vector<TrackedFrame*>& frames, double face_size) {
  const Camera& camera = frames[0]->camera;
  return std::min({1.0,
                   face_size / std::max(MedianFaceSize(frames), 1e-6),
                   std::sqrt(kMaxPixels / (double(camera.width) * camera.height))});
}

// All frames to train on, with reduced images in memory; none if one has no matte, without which an
// avatar would have to show what is behind the head, too.
TrackedVideo SmallCopy(const TrackedVideo& video,
                       const std::vector<TrackedFrame*>& frames,
                       const std::function<Image8(const TrackedFrame&)>& image,
                       double face_size) {
  const double scale = ScaleFor(frames, face_size);
  TrackedVideo small;
  small.source = video.source;
  small.layout = video.layout;
  small.shape = video.shape;
  small.static_offset = video.static_offset;
  const auto reduced = [&](int size) { return std::max(1, int(std::lround(scale * size))); };
  for (const TrackedFrame* frame : frames) {
    TrackedFrame copy = *frame;
    const Camera& camera = frame->camera;
    copy.camera = camera.Resized(reduced(camera.width), reduced(camera.height));
    copy.image = std::make_shared<const Image8>(
        ResizeByArea(image(*frame), copy.camera.width, copy.camera.height));
    if (copy.image->channels == 3) {
      small.train.clear();
      return small;
    }
    small.train.push_back(std::move(copy));
  }
  return small;
}

std::vector<uint32_t> HeldOut(size_t frames) {
  std::vector<uint32_t> out;
  for (size_t f = 0; f < frames; ++f)
    if (f / kBlock % kBlocksPerHeldOut == kBlocksPerHeldOut / 2) out.push_back(uint32_t(f));
  return out;
}

// What a frame shows of the head and the hair around it: pose and expression are found there, and
// shoulders, which move by themselves, have no say in them. vertices: of the frame.
TrackedFrame AroundHead(const TrackedFrame& frame,
                        const std::vector<float>& vertices,
                        const FlameModel& flame) {
  const Crop crop = HeadBox(vertices, flame, frame.camera);
  if (crop.empty()) return frame;
  TrackedFrame out = frame;
  out.image = std::make_shared<const Image8>(Cropped(*frame.image, crop));
  out.camera.width = crop.width, out.camera.height = crop.height;
  out.camera.cx -= float(crop.x), out.camera.cy -= float(crop.y);
  return out;
}

// `params` with the change that a frame had from its given ones to the fitted ones.
FlameParams Changed(FlameParams params, const FlameParams& given, const FlameParams& fitted) {
  const auto add = [](const auto& a, const auto& b, auto& p) {
    for (size_t k = 0; k < p.size(); ++k) p[k] += b[k] - a[k];
  };
  add(given.expression, fitted.expression, params.expression);
  for (size_t joint = 0; joint < params.pose.size(); ++joint)
    add(given.pose[joint], fitted.pose[joint], params.pose[joint]);
  add(given.translation, fitted.translation, params.translation);
  return params;
}

// Fits consecutive frames.
class LotFitter {
 public:
  LotFitter(const AvatarModel& avatar,
            const FlameModel& flame,
            const TrackedVideo& video,
            const FitSettings& settings)
      : avatar_(avatar),
        flame_(flame),
        fitter_(avatar, flame, settings),
        poser_(flame, video.shape, StaticOffsetFor(flame, video.static_offset), {}) {}

  void Fit(TrackedFrame& frame) {
    // Lots are shared among threads, and not their small images, too.
    alone_.execute([&] { FitAlone(frame); });
  }

 private:
  // Starts at the frame's own parameters, or where these are changed as those of the frame before
  // were: what is wrong with a track is often wrong in many frames, and few steps get far from
  // there.
  void FitAlone(TrackedFrame& frame) {
    const FlameParams given = WithExpressions(frame.params);
    poser_.Forward(poser_.ParametersFor(given), vertices_);
    TrackedFrame part = AroundHead(frame, vertices_, flame_);
    const auto loss = [&] { return fitter_.LossOf(part, *part.image, avatar_.background); };
    part.params = given;
    if (any_) {
      const double own = loss();
      part.params = Changed(given, given_, fitted_);
      if (!(loss() < kClearlyBetter * own)) part.params = given;
    }
    fitter_.Fit(part, *part.image, avatar_.background);
    frame.params.expression = fitter_.parameters().expression;
    frame.params.pose = fitter_.parameters().pose;
    frame.params.translation = fitter_.parameters().translation;
    given_ = given, fitted_ = frame.params, any_ = true;
  }
  FlameParams WithExpressions(FlameParams params) const {
    params.expression.resize(size_t(flame_.expression_count));
    return params;
  }

  const AvatarModel& avatar_;
  const FlameModel& flame_;
  TrackFitter fitter_;
  AvatarPoser poser_;
  std::vector<float> vertices_;
  bool any_ = false;
  FlameParams given_, fitted_;  // of the frame before, if there is any
  tbb::task_arena alone_{1};
};

class AvatarRefiner {
 public:
  AvatarRefiner(const FlameModel& flame, TrackedVideo small, const AvatarRefinement& settings)
      : flame_(flame), settings_(settings), video_(std::move(small)) {}

  std::vector<double> Run();
  const std::vector<TrackedFrame>& frames() const { return video_.train; }

  std::function<void(int steps)> tick;

 private:
  // Trains an avatar of the track; appends how well it shows the frames that it has not seen.
  AvatarModel Train();
  void Fit(const AvatarModel& avatar);

  const FlameModel& flame_;
  const AvatarRefinement& settings_;
  TrackedVideo video_;
  std::vector<double> psnr_;
};

AvatarModel AvatarRefiner::Train() {
  AvatarSettings settings = settings_.avatar;
  settings.virtual_views = 0;  // the poses are fitted from where the camera is
  AvatarSubject subject(flame_, video_, settings);
  const TrainSettings train = settings_.train(subject.extent());
  Trainer trainer(train, subject, subject.InitialGaussians(train.degree, Basis::kDcsh, train.seed));
  const std::vector<uint32_t> held_out = HeldOut(video_.train.size());
  trainer.HoldOut(held_out);
  for (int before = 0; before < settings_.avatar.iterations; before = trainer.iteration()) {
    trainer.Step();
    tick(trainer.iteration() - before);
  }
  psnr_.push_back(trainer.PsnrOf(View<const uint32_t>(held_out.data(), held_out.size())));
  AvatarModel avatar = subject.Model(trainer.CaughtUp());
  avatar.background = {1, 1, 1};
  return avatar;
}

void AvatarRefiner::Fit(const AvatarModel& avatar) {
  const size_t count = video_.train.size();
  const size_t lots = std::clamp(count / kFramesOfLot, size_t(1), kLots);
  tbb::parallel_for(size_t(0), lots, [&](size_t lot) {
    LotFitter fitter(avatar, flame_, video_, settings_.fit);
    for (size_t f = count * lot / lots; f < count * (lot + 1) / lots; ++f) {
      fitter.Fit(video_.train[f]);
      tick(settings_.fit.draws);
    }
  });
}

std::vector<double> AvatarRefiner::Run() {
  std::vector<TrackedFrame> best;
  double max = -HUGE_VAL;
  for (int round = 0;; ++round) {
    const AvatarModel avatar = Train();
    if (psnr_.back() > max) {
      max = psnr_.back();
      best = video_.train;
    }
    if (round == settings_.rounds) break;
    Fit(avatar);
  }
  video_.train = std::move(best);
  return psnr_;
}

}  // namespace

std::vector<double> RefineByAvatar(const FlameModel& flame,
                                   TrackedVideo& video,
                                   const std::function<Image8(const TrackedFrame&)>& image,
                                   const AvatarRefinement& settings,
                                   const std::function<void(int done, int total)>& progress) {
  const std::vector<TrackedFrame*> frames = FramesInOrder(video);
  if (frames.size() < kMinFrames) return {};
  for (size_t f = 1; f < frames.size(); ++f)
    if (frames[f]->timestep == frames[f - 1]->timestep)
      throw Error(video.source,
                  "frames",
                  "'" + frames[f - 1]->name + "' and '" + frames[f]->name +
                      "' show one moment; expected one camera");
  TrackedVideo small = SmallCopy(video, frames, image, settings.face_size);
  if (small.train.empty()) return {};
  AvatarRefiner refiner(flame, std::move(small), settings);
  const int total = (settings.rounds + 1) * settings.avatar.iterations +
                    settings.rounds * int(frames.size()) * settings.fit.draws;
  std::mutex mutex;
  int done = 0;
  refiner.tick = [&](int steps) {
    const std::lock_guard lock(mutex);
    done += steps;
    if (progress) progress(done, total);
  };
  const std::vector<double> psnr = refiner.Run();
  for (size_t f = 0; f < frames.size(); ++f) frames[f]->params = refiner.frames()[f].params;
  if (progress && done < total) progress(total, total);
  return psnr;
}

}  // namespace cosplat
