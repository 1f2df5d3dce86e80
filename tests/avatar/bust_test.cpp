// The bust as a rigid body: its motion and derivative, how it follows the head, and finding where
// it is from images.
#include "avatar/model/bust.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "avatar/math/turn.h"
#include "avatar/model/place_bust.h"
#include "avatar/surface/sample.h"
#include "avatar/train/bust_track.h"
#include "avatar/train/fit_track.h"
#include "splat/device/for_each.h"
#include "tests/avatar/made_video.h"
#include "tests/support/gradient_check.h"

namespace cosplat::test {
namespace {

using math::Quat;
using math::Vec3;

template <class T>
Vec3<T> V(const std::vector<T>& x, size_t i) {
  return {x[i], x[i + 1], x[i + 2]};
}

TEST(BustMotion, VjpMatchesDual) {
  const auto turn = math::Normalize(Quat<double>{0.8, 0.1, -0.3, 0.2});
  const auto q = math::Normalize(Quat<double>{0.3, -0.7, 0.2, 0.4});
  const Vec3<double> pivot{0.1, -0.2, 0.3}, p{1, 2, -0.5};
  // At w = 0, a point and a quaternion that the bust has turned.
  const auto moved = [&](const auto& x) {
    using T = std::decay_t<decltype(x[0])>;
    const auto t = math::TurnedBy(V(x, 0), Quat<T>{T(turn.w), T(turn.x), T(turn.y), T(turn.z)});
    const Vec3<T> at = math::MoveWithBust<T>(
        {t, V(x, 3)}, {T(pivot.x), T(pivot.y), T(pivot.z)}, {T(p.x), T(p.y), T(p.z)});
    const Quat<T> r = math::Multiply(t, Quat<T>{T(q.w), T(q.x), T(q.y), T(q.z)});
    return std::vector<T>{at.x, at.y, at.z, r.w, r.x, r.y, r.z};
  };
  ExpectVjpMatchesDual(
      moved,
      [&](const auto& x, const auto& d) {
        const auto y = moved(x);
        Vec3<double> d_w{0, 0, 0}, d_shift{0, 0, 0};
        math::MoveWithBustVjp({turn, V(x, 3)}, pivot, V(y, 0), V(d, 0), d_w, d_shift);
        math::TurnWithBustVjp(
            Quat<double>{y[3], y[4], y[5], y[6]}, Quat<double>{d[3], d[4], d[5], d[6]}, d_w);
        return std::vector<double>{d_w.x, d_w.y, d_w.z, d_shift.x, d_shift.y, d_shift.z};
      },
      {0, 0, 0, 0.3, -0.1, 0.2});
}

TEST(BustMotion, TheMeanPlaceIsExact) {
  const std::vector<float> mean{0.1f, 0.2f, 0.3f};
  std::vector<float> placed(3);
  ForEach(1, HostStream(), PlaceBust{mean, {0.7f, 0.3f, 0.1f}, &kMeanBustPose, placed.data()});
  EXPECT_EQ(placed, mean);
}

FlameParams HeadAt(float x, float yaw) {
  FlameParams head;
  head.translation = {x, 0.01f * yaw, 0};
  head.pose[0] = {0, yaw, 0};
  return head;
}

BustPose ShiftedBy(float x) { return {{1, 0, 0, 0}, {x, 0, 0}}; }

TEST(BustFollow, LearnsALinearMotion) {
  std::vector<FlameParams> heads;
  std::vector<BustPose> busts;
  for (int i = 0; i < 60; ++i) {
    const float x = 0.03f * std::sin(0.4f * float(i)), yaw = 0.3f * std::cos(0.7f * float(i));
    heads.push_back(HeadAt(x, yaw));
    busts.push_back({math::QuatOfAxisAngle({0, 0.2f * yaw, 0}), {0.6f * x + 0.01f, 0, 0}});
  }
  Bust bust;
  bust.follow = FitBustFollow(bust, heads, busts);
  const BustPose pose = PoseOfBust(bust, HeadAt(0.02f, 0.1f));
  EXPECT_NEAR(pose.shift.x, 0.022f, 3e-4f);  // damping takes a little
  EXPECT_NEAR(math::AxisAngleOf(pose.turn)[1], 0.02f, 5e-4f);
  EXPECT_NEAR(pose.shift.y, 0, 1e-6f);
  // Far beyond what was seen: limited to the range and a quarter.
  const BustPose far = PoseOfBust(bust, HeadAt(10, 0));
  EXPECT_LT(far.shift.x, 0.6f * 0.03f + 0.01f + 0.25f * 0.6f * 0.06f + 1e-4f);
  EXPECT_TRUE(std::isfinite(PoseOfBust(bust, HeadAt(1e6f, 3)).shift.x));
}

TEST(BustFollow, DoesNotFollowWhatTheHeadDoesNotExplain) {
  std::vector<FlameParams> heads;
  std::vector<BustPose> busts;
  Rng rng{5};
  for (int i = 0; i < 60; ++i) {
    heads.push_back(HeadAt(0.02f * rng.Normal(), 0.2f * rng.Normal()));
    busts.push_back(ShiftedBy(0.01f * std::sin(0.1f * float(i))));
  }
  Bust bust;
  bust.follow = FitBustFollow(bust, heads, busts);
  const float at_rest = PoseOfBust(bust, HeadAt(0, 0)).shift.x;
  EXPECT_NEAR(PoseOfBust(bust, HeadAt(0.03f, 0.3f)).shift.x, at_rest, 2e-3f);
  // Two instants are too few to learn from.
  bust.follow = FitBustFollow(bust, {heads[0], heads[1]}, {ShiftedBy(0.01f), ShiftedBy(0.03f)});
  EXPECT_FLOAT_EQ(PoseOfBust(bust, HeadAt(0.05f, 0)).shift.x, 0.02f);
}

TEST(BustFollow, CanBeHeldStill) {
  AvatarModel avatar;
  HoldBustStill(avatar);  // without a bust: nothing
  avatar.bust.emplace().follow.emplace().matrix.fill(1);
  avatar.bust->follow->mean[3] = 0.5f;
  HoldBustStill(avatar);
  EXPECT_FLOAT_EQ(PoseOfBust(*avatar.bust, HeadAt(0.05f, 0.4f)).shift.x, 0.5f);
}

TEST(BustTrack, FramesOfSeveralCamerasShareAnInstant) {
  EXPECT_EQ(InstantsOf({4, 4, 7, 2, 7}), (std::vector<size_t>{1, 1, 2, 0, 2}));
}

// A head on a bust with a pattern, opaque, and images of it with the bust moved.
class MovedBust : public testing::Test {
 protected:
  MovedBust() {
    avatar_.bust = MeanBust(flame_, {}, {}, {FlameParams()});
    avatar_.mesh = MakeCanonicalMesh(flame_, {}, {}, avatar_.bust);
    Rng rng{3};
    constexpr size_t kCount = 4000;
    avatar_.gaussians.Resize(kCount);
    const float spacing = float(std::sqrt(SurfaceArea(avatar_.mesh) / kCount));
    size_t i = 0;
    for (const SurfacePoint& p : SampleSurface(avatar_.mesh, kCount, rng)) {
      avatar_.embedding.triangle.push_back(p.triangle);
      avatar_.embedding.barycentric.push_back(p.barycentric);
      const float* at = &avatar_.mesh.vertices[3 * size_t(avatar_.mesh.faces[p.triangle][0])];
      Gaussians& g = avatar_.gaussians;
      g.at(kRotation, i)[0] = 1;
      g.at(kOpacityLogit, i)[0] = 4;
      for (int k = 0; k < 3; ++k) {
        g.at(kScaleLog, i)[k] = std::log(spacing);
        g.at(kColorDc, i)[k] = std::sin(40 * at[0] + 2 * float(k)) * std::cos(30 * at[1]);
      }
      ++i;
    }
    const std::vector<float>& vertices = avatar_.mesh.vertices;
    float middle[3] = {};
    for (size_t v = 0; v < vertices.size(); ++v)
      middle[v % 3] += 3 * vertices[v] / float(vertices.size());
    camera_.width = camera_.height = 128;
    camera_.fx = camera_.fy = 260;
    camera_.cx = camera_.cy = 64;
    camera_.rotation = {1, 0, 0, 0, -1, 0, 0, 0, -1};
    camera_.translation = {-middle[0], middle[1], 0.9f + middle[2]};
  }
  // With alpha.
  Image8 ImageAt(const FlameParams& head, const BustPose& bust) {
    AvatarPoser poser(flame_, {}, {}, avatar_.bust);
    AvatarPoser::Parameters parameters = poser.ParametersFor(head);
    parameters.bust = bust;
    std::vector<float> vertices;
    poser.Forward(parameters, vertices);
    Surface surface(avatar_.mesh);
    surface.Pose(vertices);
    PosedGaussians posed;
    Bind(avatar_, surface, posed);
    const auto rasterizer = MakeCpuRasterizer();
    const auto tape = rasterizer->MakeTape();
    RenderedImage image;
    rasterizer->Forward(PosedView(avatar_.gaussians, posed, ColorFrame::kSurface),
                        avatar_.gaussians.basis,
                        camera_,
                        {},
                        image,
                        *tape);
    Image8 bytes;
    ToStraightAlphaBytes(image, bytes);
    return bytes;
  }
  TrackedFrame FrameAt(int t, const FlameParams& head, const BustPose& bust) {
    TrackedFrame frame;
    frame.name = std::to_string(t);
    frame.timestep = t;
    frame.camera = camera_;
    frame.params = head;
    frame.image = std::make_shared<const Image8>(ImageAt(head, bust));
    return frame;
  }

  const FlameModel& flame_ = MadeHead().model;
  AvatarModel avatar_;
  Camera camera_;
};

TEST_F(MovedBust, IsRegisteredFromImages) {
  const std::vector<float> truth{-0.02f, 0.0f, 0.015f, 0.005f};
  AvatarPoser poser(flame_, {}, {}, avatar_.bust);
  std::vector<TrainFrame> frames;
  std::vector<float> vertices;
  poser.Forward(poser.ParametersFor({}), vertices);
  for (const float x : truth) frames.push_back({camera_, ImageAt({}, ShiftedBy(x))});
  const std::vector<BustPose> poses = RegisterBusts(poser, frames, {4, vertices});
  // Their mean is the mean place, here at zero too. A pixel is 3.5 mm there.
  for (size_t i = 0; i < truth.size(); ++i) {
    EXPECT_NEAR(poses[i].shift.x, truth[i], 0.004f) << i;
    EXPECT_NEAR(poses[i].shift.y, 0, 0.004f) << i;
  }
}

TEST_F(MovedBust, IsFittedWithTheHead) {
  FlameParams head;
  head.pose[0] = {0.05f, -0.04f, 0.02f};
  head.translation = {0.004f, -0.003f, 0};
  const BustPose bust{math::QuatOfAxisAngle({0, 0, 0.04f}), {0.006f, -0.004f, 0}};
  TrackedFrame frame = FrameAt(0, head, bust);
  const Image8 target = *frame.image;
  frame.params = {};  // the track that is to be mended
  const auto psnr = [&](const TrackFitter& fitter) {
    return Psnr(fitter.image().color, Target(target));
  };
  FitSettings settings;
  settings.head = false;
  TrackFitter of_bust(avatar_, flame_, settings), of_both(avatar_, flame_);
  of_bust.LossOf(frame, target, {1, 1, 1});
  const double before = psnr(of_bust);
  of_bust.Fit(frame, target, {1, 1, 1});
  EXPECT_EQ(of_bust.parameters().translation, frame.params.translation);
  EXPECT_GT(psnr(of_bust), before + 1);
  of_both.Fit(frame, target, {1, 1, 1});
  EXPECT_GT(psnr(of_both), psnr(of_bust) + 3);
  EXPECT_NEAR(of_both.parameters().bust.shift.x, bust.shift.x, 0.002f);
}

// The bust moves on its own while the head stays. Half of the motion is enough for the start, the
// images have to give the rest.
TEST_F(MovedBust, IsFoundInTraining) {
  TrackedVideo video;
  video.source = "made";
  constexpr int kFrames = 12;
  std::vector<float> truth;
  for (int t = 0; t < kFrames; ++t) {
    truth.push_back(0.012f * std::sin(0.6f * float(t)));
    video.train.push_back(FrameAt(t, {}, ShiftedBy(truth.back())));
  }
  const auto train = [&](bool still) {
    AvatarSettings settings = SmallAvatar(2500);
    settings.bust = AvatarSettings::BustChoice::kYes;
    settings.still_bust = still;
    settings.iterations = 240;
    AvatarSubject subject(flame_, video, settings);
    TrainSettings run = ShortRun(240, 4000);
    run.degree = 0;
    Trainer trainer(run, subject, subject.InitialGaussians(0, Basis::kSh, 0), MakeHostStepEngine);
    for (int i = 0; i < 240; ++i) trainer.Step();
    // Not the loss: its penalty of needles is a mean over few, which jumps.
    std::vector<uint32_t> frames(kFrames);
    std::iota(frames.begin(), frames.end(), 0u);
    const double psnr = trainer.PsnrOf(View<const uint32_t>(frames.data(), frames.size()));
    const AvatarModel model = subject.Model(trainer.CaughtUp());
    EXPECT_EQ(model.bust->follow.has_value(), !still);
    const auto state = std::dynamic_pointer_cast<const AvatarTrainingState>(subject.SaveState());
    return std::pair(psnr, state->busts);
  };
  const auto [still_psnr, none] = train(true);
  const auto [psnr, busts] = train(false);
  EXPECT_TRUE(none.empty());
  EXPECT_GT(psnr, still_psnr + 4);
  ASSERT_EQ(busts.size(), size_t(kFrames));
  double product = 0, found2 = 0, truth2 = 0, mean = 0;
  for (const BustState& b : busts) mean += b.pose.shift.x / kFrames;
  for (int t = 0; t < kFrames; ++t) {
    const double x = busts[size_t(t)].pose.shift.x - mean;
    product += x * truth[size_t(t)];
    found2 += x * x;
    truth2 += truth[size_t(t)] * truth[size_t(t)];
  }
  EXPECT_GT(product / std::sqrt(found2 * truth2), 0.95);
}

}  // namespace
}  // namespace cosplat::test
