#include "avatar/train/refine_by_avatar.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "flame/mouth.h"
#include "flame/pose.h"
#include "tests/avatar/track_errors.h"
#include "tests/avatar/training_fixture.h"
#include "tests/flame/hollow_head.h"
#include "tests/support/expect_error.h"

namespace cosplat::test {
namespace {

AvatarRefinement Settings(int rounds) {
  AvatarRefinement settings;
  settings.avatar = SmallAvatar(1500);
  settings.avatar.iterations = 150;
  settings.train = [](float unit) {
    TrainSettings train = ShortRun(150, 2000);
    ScaleToUnit(unit, train);
    return train;
  };
  settings.fit.draws = 12;
  settings.fit.place_prior = settings.fit.face_prior = 1e-6;
  settings.rounds = rounds;
  return settings;
}

std::vector<FlameParams> ParamsOf(const TrackedVideo& video) {
  std::vector<FlameParams> params;
  for (const auto* list : {&video.train, &video.test})
    for (const TrackedFrame& frame : *list) params.push_back(frame.params);
  return params;
}

// Root mean square distance of the vertices from where they are in truth, in metres. A vertex's
// mean over the frames is left out: the avatar absorbs it.
double DistanceOfHeads(const std::vector<FlameParams>& a, const std::vector<TrackedFrame>& truth) {
  const FlamePoser<float> poser(MadeHead().model, {});
  const size_t count = 3 * size_t(MadeHead().model.vertex_count);
  std::vector<double> sum(count), squares(count);
  std::vector<float> is, should;
  for (size_t f = 0; f < a.size(); ++f) {
    poser.Forward(poser.ParametersOf(a[f]), is);
    poser.Forward(poser.ParametersOf(truth[f].params), should);
    for (size_t i = 0; i < count; ++i) {
      sum[i] += is[i] - should[i];
      squares[i] += (is[i] - should[i]) * (is[i] - should[i]);
    }
  }
  double total = 0;
  const double n = double(a.size());
  for (size_t i = 0; i < count; ++i) total += squares[i] / n - sum[i] / n * sum[i] / n;
  return std::sqrt(3 * total / double(count));
}

Image8 ImageOf(const TrackedFrame& frame) { return *frame.image; }

bool Same(const std::vector<FlameParams>& a, const std::vector<FlameParams>& b) {
  return std::equal(
      a.begin(), a.end(), b.begin(), b.end(), [](const FlameParams& x, const FlameParams& y) {
        return x.expression == y.expression && x.pose == y.pose && x.translation == y.translation;
      });
}

// Frames that are to test are refined, too. Expressions are not compared: at this size most of the
// coefficients do not show. The same bits with one thread.
TEST(RefineByAvatar, BringsATrackCloserToTheTruth) {
  const TrackedVideo truth = MakeSmallVideo(20, 1);
  TrackedVideo video = truth;
  Perturb(video);
  const double before = DistanceOfHeads(ParamsOf(video), truth.train);
  video.test.assign(video.train.end() - 3, video.train.end());
  video.train.resize(17);
  TrackedVideo alone = video;

  int done = 0, total = 0;
  const std::vector<double> psnr =
      RefineByAvatar(MadeHead().model, video, ImageOf, Settings(2), [&](int d, int t) {
        EXPECT_GE(d, done);
        done = d;
        total = t;
      });
  ASSERT_EQ(psnr.size(), 3u);
  EXPECT_GT(psnr[1], psnr[0] + 0.5);
  EXPECT_EQ(done, total);
  EXPECT_LT(DistanceOfHeads(ParamsOf(video), truth.train), 0.75 * before);

  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(RefineByAvatar(MadeHead().model, alone, ImageOf, Settings(2)), psnr);
  EXPECT_TRUE(Same(ParamsOf(alone), ParamsOf(video)));
}

// An avatar that has hardly been trained.
TEST(RefineByAvatar, RoundsThatGainNothingAreUndone) {
  TrackedVideo video = MakeSmallVideo(20, 2);
  const std::vector<FlameParams> given = ParamsOf(video);
  AvatarRefinement settings = Settings(3);
  settings.avatar.iterations = 8;
  settings.train = [](float unit) {
    TrainSettings train = ShortRun(8, 2000);
    ScaleToUnit(unit, train);
    return train;
  };
  const std::vector<double> psnr = RefineByAvatar(MadeHead().model, video, ImageOf, settings);
  ASSERT_EQ(psnr.size(), 4u);
  EXPECT_EQ(std::max_element(psnr.begin(), psnr.end()), psnr.begin());
  EXPECT_TRUE(Same(ParamsOf(video), given));
}

// Its offset is of the model as its file has it, without the mouth that avatars add.
TEST(RefineByAvatar, ATrackWithHair) {
  const FlameModel flame = WithMouth(HollowHead());
  ASSERT_GT(flame.vertex_count, flame.own_vertex_count());
  TrackedVideo video = MakeSmallVideo(20, 2);
  video.static_offset.assign(3 * size_t(flame.own_vertex_count()), 1e-4f);
  AvatarRefinement settings = Settings(1);
  settings.avatar.iterations = 8;
  EXPECT_EQ(RefineByAvatar(flame, video, ImageOf, settings).size(), 2u);
}

TEST(RefineByAvatar, FramesThatItCannotCompare) {
  TrackedVideo video = MakeSmallVideo(20, 2);
  video.train[7].timestep = 6;
  ExpectError([&] { RefineByAvatar(MadeHead().model, video, ImageOf, Settings(1)); },
              {"made", "'6'", "'7'", "one camera"});
  TrackedVideo few = MakeSmallVideo(19, 2);
  EXPECT_TRUE(RefineByAvatar(MadeHead().model, few, ImageOf, Settings(1)).empty());
}

TEST(RefineByAvatar, WithoutMattesThereIsNothingToCompare) {
  TrackedVideo video = MakeSmallVideo(20, 2);
  const std::vector<FlameParams> given = ParamsOf(video);
  const auto opaque = [](const TrackedFrame& frame) {
    return Image8(frame.camera.width, frame.camera.height, 3);
  };
  EXPECT_TRUE(RefineByAvatar(MadeHead().model, video, opaque, Settings(1)).empty());
  EXPECT_TRUE(Same(ParamsOf(video), given));
}

}  // namespace
}  // namespace cosplat::test
