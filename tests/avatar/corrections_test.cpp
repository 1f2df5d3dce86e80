// Corrections that follow the expression: their weights, binding, and learning them.
#include "avatar/model/corrections.h"

#include <gtest/gtest.h>

#include <cmath>

#include "avatar/play/player.h"
#include "avatar/surface/binding.h"
#include "flame/eyelids.h"
#include "splat/train/loss/loss.h"
#include "tests/avatar/meshes.h"
#include "tests/avatar/training_fixture.h"
#include "tests/avatar/with_corrections.h"
#include "tests/flame/hollow_head.h"

namespace cosplat::test {
namespace {

using Parameters = FlamePoser<float>::Parameters;

std::vector<Parameters> RandomFaces(const FlameModel& flame, size_t count) {
  Rng rng{2};
  std::vector<Parameters> faces(count);
  for (Parameters& p : faces) {
    p.expression.assign(size_t(flame.expression_count), 0.0f);
    p.expression[0] = rng.Normal();
    p.expression[1] = 0.5f * p.expression[0];  // the same motion
    p.expression[3] = 0.3f * rng.Normal();
    p.pose[2][0] = 0.1f * rng.Normal();
    p.pose[0] = {rng.Normal(), rng.Normal(), rng.Normal()};  // does not count
  }
  return faces;
}

TEST(CorrectionMap, HasNoMoreWeightsThanTheFacesHaveMotions) {
  const FlameModel flame = MakeProceduralHead();
  const std::vector<Parameters> faces = RandomFaces(flame, 50);
  const CorrectionMap map = FindCorrectionMap(flame, faces, 8);
  ASSERT_EQ(map.count(), 3u);
  EXPECT_EQ(FindCorrectionMap(flame, faces, 2).count(), 2u);
  EXPECT_EQ(FindCorrectionMap(flame, {faces[0], faces[0]}, 8).count(), 0u);  // nothing moves
  // In the training frames weights are from -1 to 1, and zero on average.
  std::vector<double> mean(3), largest(3);
  for (const Parameters& p : faces) {
    const std::vector<float> weights = CorrectionWeights(map, p);
    for (size_t k = 0; k < 3; ++k) {
      mean[k] += weights[k] / double(faces.size());
      largest[k] = std::max(largest[k], double(std::abs(weights[k])));
    }
  }
  for (size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(mean[k], 0, 1e-4);
    EXPECT_NEAR(largest[k], 1, 1e-4);
  }
}

TEST(CorrectionMap, WeightsStayBounded) {
  const FlameModel flame = MakeProceduralHead();
  const CorrectionMap map = FindCorrectionMap(flame, RandomFaces(flame, 50), 8);
  Parameters far;
  far.expression.assign(size_t(flame.expression_count), 1e5f);
  far.pose[2] = {3, -3, 3};
  for (const float w : CorrectionWeights(map, far)) EXPECT_LE(std::abs(w), 1.51f);
  Parameters none;  // without coefficients: as if they were zero
  EXPECT_EQ(CorrectionWeights(map, none).size(), map.count());
  EXPECT_TRUE(CorrectionWeights({}, far).empty());
}

// The derivative of the bases, through Bind, against differences.
TEST(Corrections, BindBackwardIsTheDerivative) {
  const CanonicalMesh mesh = SphereMesh(2);
  Surface surface(mesh);
  FlameModel flame;
  AvatarModel plain = RandomAvatar(mesh, 21, 5);
  plain.gaussians.Resize(21);
  AvatarModel model = WithCorrections(plain, flame, 2);
  const std::vector<float> weights{0.7f, -0.4f};
  const auto objective = [&](const AvatarModel& m) {
    PosedGaussians out;
    Bind(m, surface, out, weights);
    double sum = 0;
    int i = 0;
    for (const Buffer<float>* b :
         {&out.position, &out.rotation, &out.scale_log, &out.opacity_logit, &out.color_dc})
      for (const float x : *b) sum += std::sin(double(++i)) * x;
    return sum;
  };
  PosedGaussians d;
  Gaussians d_gaussians;
  d_gaussians.Resize(model.size());
  d.Resize(model.size());
  int i = 0;
  for (Buffer<float>* b : {&d.position,
                           &d.rotation,
                           &d.scale_log,
                           &d_gaussians.values[kOpacityLogit],
                           &d_gaussians.values[kColorDc]})
    for (float& x : *b) x = float(std::sin(double(++i)));
  d.frame.clear();
  BindBackward(model, surface, d, d_gaussians, nullptr, weights);
  Buffer<float>& bases = model.gaussians.values[kCorrection];
  ASSERT_EQ(d_gaussians.values[kCorrection].size(), bases.size());
  for (size_t k = 0; k < bases.size(); k += 5) {
    const float before = bases[k], step = 1e-2f;
    bases[k] = before + step;
    const double more = objective(model);
    bases[k] = before - step;
    const double less = objective(model);
    bases[k] = before;
    EXPECT_NEAR(d_gaussians.values[kCorrection][k], (more - less) / (2 * step), 2e-3) << k;
  }
}

// Eyelids are coefficients of the expression, so that weights follow them, too.
TEST(CorrectionMap, FollowsEyelids) {
  const FlameModel flame = WithEyelids(HollowHead());
  std::vector<Parameters> faces(8);
  for (size_t f = 0; f < faces.size(); ++f) {
    faces[f].expression.assign(size_t(flame.expression_count), 0.0f);
    faces[f].expression.back() = f % 2 ? 1.0f : 0.0f;
  }
  const CorrectionMap map = FindCorrectionMap(flame, faces, 4);
  ASSERT_EQ(map.count(), 1u);
  EXPECT_NEAR(
      std::abs(CorrectionWeights(map, faces[0])[0] - CorrectionWeights(map, faces[1])[0]), 2, 1e-4);
}

// Idle bases leave the file, and the image stays as it is.
TEST(Corrections, IdleBasesAreDropped) {
  const FlameModel& flame = SmallVideo::Get().flame;
  Training<> run(LoadSmallVideo(4, 1), SmallAvatar(1500), ShortRun(40, 3000));
  run.Run(40);
  AvatarModel avatar = WithCorrections(run.Model(), flame, 5);
  for (size_t i = 0; i < avatar.size(); ++i)
    for (const int k : {1, 4})
      for (int j = 0; j < kCorrectionNumbers; ++j)
        avatar.gaussians.at(kCorrection, i)[k * kCorrectionNumbers + j] *= 1e-3f;
  AvatarModel dropped = avatar;
  DropIdleCorrections(dropped);
  ASSERT_EQ(dropped.gaussians.corrections, 3);
  ASSERT_EQ(dropped.correction_map.count(), 3u);
  EXPECT_EQ(dropped.gaussians.at(kCorrection, 7)[2 * kCorrectionNumbers],
            avatar.gaussians.at(kCorrection, 7)[3 * kCorrectionNumbers]);
  const TrackedFrame& frame = run.subject.video().train[0];
  FlameParams face = frame.params;
  face.expression = {1.0f, -0.5f, 0.7f};
  face.pose[2] = {0.2f, 0, 0};
  Player all(avatar, flame), fewer(dropped, flame);
  RenderedImage a, b;
  all.RenderOver(face, frame.camera, {0, 0, 0}, a);
  fewer.RenderOver(face, frame.camera, {0, 0, 0}, b);
  EXPECT_GT(Psnr(a.color, b.color), 60);

  for (float& number : avatar.gaussians.values[kCorrection]) number = 0;
  DropIdleCorrections(avatar);
  EXPECT_EQ(avatar.gaussians.corrections, 0);
  EXPECT_EQ(avatar.correction_map.count(), 0u);
  EXPECT_TRUE(avatar.gaussians.values[kCorrection].empty());
}

// The images' colours follow an expression that moves nothing the mesh could show.
TEST(Corrections, LearnWhatTheMeshDoesNotShow) {
  TrackedVideo video = LoadSmallVideo(12, 2);
  for (size_t f = 0; f < video.train.size(); ++f) {
    TrackedFrame& frame = video.train[f];
    Image8 image = LoadTrackedImage(video, frame);
    const bool bright = f % 2 == 0;
    for (size_t p = 0; p < image.pixels(); ++p)
      for (int c = 0; c < 3; ++c)
        image.data[4 * p + c] = uint8_t(image.data[4 * p + c] / (bright ? 1 : 2));
    frame.image = std::make_shared<const Image8>(image);
    frame.params = video.train[0].params;
    frame.camera = video.train[0].camera;
    frame.params.expression[3] = bright ? 1.0f : -1.0f;
  }
  const auto loss = [&](size_t corrections) {
    AvatarSettings avatar = SmallAvatar(1500);
    avatar.corrections = corrections;
    TrainSettings settings = ShortRun(150, 3000);
    settings.rates.correction = 1e-2f;  // of a run of thousands of steps
    Training<> run(video, avatar, settings);
    EXPECT_EQ(run.Model().gaussians.corrections, int(corrections));
    return run.Run(150);
  };
  EXPECT_LT(loss(1), 0.8 * loss(0));
}

}  // namespace
}  // namespace cosplat::test
