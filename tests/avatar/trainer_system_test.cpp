// AvatarSystem: where SplattingAvatar's choices are followed and where ours are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/avatar/training_fixture.h"
#include "tests/support/expect_error.h"

namespace cosplat::test {
namespace {

constexpr AvatarSystem kSystems[] = {
    AvatarSystem::kCosplat, AvatarSystem::kPublished, AvatarSystem::kReleased};

AvatarSettings SettingsOf(AvatarSystem system, size_t gaussians) {
  AvatarSettings avatar = SmallAvatar(gaussians);
  avatar.system = system;
  avatar.color_frame = ColorFrame::kWorld;
  return avatar;
}

// Opens what density control calls.
class OpenSubject : public AvatarSubject {
 public:
  using AvatarSubject::AvatarSubject;
  using AvatarSubject::Move;
  using AvatarSubject::PositionRateScale;
  using AvatarSubject::Veto;
};

OpenSubject Subject(AvatarSystem system, size_t gaussians = 500) {
  return OpenSubject(SmallVideo::Get().flame, LoadSmallVideo(4, 3), SettingsOf(system, gaussians));
}

TEST(AvatarSystem, TheCanonicalMeshIsTheShapeOrFrame0) {
  const FlameModel& flame = SmallVideo::Get().flame;
  const TrackedVideo video = LoadSmallVideo(4, 3);
  std::vector<float> frame0;
  AvatarPoser poser(flame, video.shape, video.static_offset, {});
  poser.Forward(poser.ParametersFor(video.train[0].params), frame0);
  const CanonicalMesh rest = MakeCanonicalMesh(flame, video.shape, video.static_offset, {});
  ASSERT_NE(frame0, rest.vertices);
  for (const AvatarSystem system : kSystems) {
    OpenSubject subject = Subject(system);
    const AvatarModel model = subject.Model(subject.InitialGaussians(0, Basis::kSh, 0));
    const bool ours = system == AvatarSystem::kCosplat;
    EXPECT_EQ(model.mesh.vertices, ours ? rest.vertices : frame0);
    EXPECT_EQ(model.canonical_frame.has_value(), !ours);
    EXPECT_EQ(model.embedding.released.has_value(), system == AvatarSystem::kReleased);
    if (model.embedding.released) {
      EXPECT_EQ(model.embedding.released->unit, subject.extent());
    }
  }
}

// The share of Gaussians on the smallest half of the faces, against those faces' share of the area.
TEST(AvatarSystem, OnlyTheReleaseBeginsWithoutRegardToArea) {
  for (const AvatarSystem system : kSystems) {
    OpenSubject subject = Subject(system, 20000);
    const AvatarModel model = subject.Model(subject.InitialGaussians(0, Basis::kSh, 0));
    const size_t faces = model.mesh.faces.size();
    std::vector<std::pair<double, int32_t>> by_area;
    for (size_t f = 0; f < faces; ++f) by_area.push_back({FaceArea(model.mesh, f), int32_t(f)});
    std::sort(by_area.begin(), by_area.end());
    by_area.resize(faces / 2);
    std::set<int32_t> small;
    const double total = SurfaceArea(model.mesh);
    double area = 0;
    for (const auto& [a, f] : by_area) {
      area += a / total;
      small.insert(f);
    }
    double share = 0;
    for (const int32_t t : model.embedding.triangle)
      share += small.contains(t) / double(model.size());
    EXPECT_NEAR(share, system == AvatarSystem::kReleased ? 0.5 : area, 0.015);
    ASSERT_LT(area, 0.4);
  }
}

// An even spacing, the same for all; or each one's distance to its neighbours, which is about half
// of that on average.
TEST(AvatarSystem, FirstScalesAreTheSpacingOrTheNeighboursDistance) {
  for (const AvatarSystem system : kSystems) {
    OpenSubject subject = Subject(system, 3000);
    const Gaussians g = subject.InitialGaussians(0, Basis::kSh, 0);
    const double spacing = std::sqrt(SurfaceArea(subject.Model(g).mesh) / 3000);
    const auto& scales = g.values[kScaleLog];
    const auto [min, max] = std::minmax_element(scales.begin(), scales.end());
    double mean = 0;
    for (const float s : scales) mean += std::exp(s) / double(scales.size());
    if (system == AvatarSystem::kCosplat) {
      EXPECT_EQ(*min, *max);
      EXPECT_NEAR(mean, spacing, 1e-4 * spacing);
    } else {
      EXPECT_GT(*max - *min, 1);
      EXPECT_GT(mean, 0.3 * spacing);
      EXPECT_LT(mean, 1.1 * spacing);
    }
  }
}

TEST(AvatarSystem, StepsOnTheSurfaceAreMetricOrInBarycentricUnits) {
  for (const AvatarSystem system : kSystems) {
    OpenSubject subject = Subject(system);
    const AvatarModel model = subject.Model(subject.InitialGaussians(0, Basis::kSh, 0));
    const View<const float> scale = subject.PositionRateScale();
    for (size_t i = 0; i < model.size(); ++i) {
      const double metres =
          std::sqrt(2 * FaceArea(model.mesh, size_t(model.embedding.triangle[i])));
      const double unit = system == AvatarSystem::kCosplat ? metres : subject.extent();
      EXPECT_NEAR(scale[3 * i] * unit, 1, 1e-4);
      EXPECT_EQ(scale[3 * i + 1], scale[3 * i]);
      EXPECT_EQ(scale[3 * i + 2], 1);
    }
  }
}

// At ten times the published rate, so that a short run shows it. Measured: 0.85, 0.06
// and none.
TEST(AvatarSystem, OnlyTheReleaseDoesNotWalk) {
  for (const AvatarSystem system : kSystems) {
    TrainSettings settings = ShortRun(150, 1000);
    settings.degree = 0;
    settings.rates.position_lr_init = 1.6e-3f;
    settings.schedule.densify_until = 0;  // nothing but walking moves a Gaussian
    Training<> run(LoadSmallVideo(4, 3), SettingsOf(system, 1000), settings);
    run.Run(149);  // the steps since the last walk are still there
    double step = 0;
    for (size_t i = 0; i < run.gaussians().size(); ++i)
      for (int k = 0; k < 2; ++k) step += std::abs(run.gaussians().values[kPosition][3 * i + k]);
    if (system == AvatarSystem::kReleased) {
      EXPECT_EQ(run.subject.WalkedShare(), 0);
      EXPECT_EQ(step, 0);
    } else {
      EXPECT_GT(run.subject.WalkedShare(), 0.03);
      EXPECT_GT(step, 0);
    }
  }
}

TEST(AvatarSystem, ASplitsChildKeepsItsParentsDOrGetsItsOwn) {
  for (const AvatarSystem system : kSystems) {
    OpenSubject subject = Subject(system);
    Gaussians g = subject.InitialGaussians(0, Basis::kSh, 0);
    const float d = 1e-3f * subject.extent();
    for (size_t i = 0; i < g.size(); ++i) g.at(kPosition, i)[2] = d;
    double change = 0;
    const Buffer<float> offsets(3 * g.size(), d);
    subject.Move(offsets, 0, g, HostStream());
    for (uint32_t i = 0; i < g.size(); ++i) change += std::abs(g.at(kPosition, i)[2] - d);
    if (system == AvatarSystem::kCosplat)
      EXPECT_GT(change, 0.1 * d * double(g.size()));
    else
      EXPECT_EQ(change, 0);
  }
}

TEST(AvatarSystem, OnlyOursKeepsWhatWouldLeaveAHole) {
  for (const AvatarSystem system : kSystems) {
    OpenSubject subject = Subject(system, 20000);
    Gaussians g = subject.InitialGaussians(0, Basis::kSh, 0);
    for (float& logit : g.values[kOpacityLogit]) logit = 3;
    std::vector<uint32_t> removed;
    for (uint32_t i = 0; i < g.size(); ++i) removed.push_back(i);
    const size_t allowed = test::Allowed(subject, g, removed).size();
    if (system == AvatarSystem::kCosplat)
      EXPECT_LT(allowed, g.size());
    else
      EXPECT_EQ(allowed, g.size());
  }
}

// What is trained is what is played: the same Gaussians in the world, to the bit, and for the
// release others than by our rule.
TEST(AvatarSystem, AFrameIsPlayedByTheRuleOfItsTraining) {
  const FlameModel& flame = SmallVideo::Get().flame;
  for (const AvatarSystem system : kSystems) {
    OpenSubject subject = Subject(system);
    const Gaussians g = subject.InitialGaussians(0, Basis::kSh, 0);
    const WorldGaussians trained = subject.ToWorld(g, 3);
    const auto placed = [&](const AvatarModel& model) {
      PosedAvatar out;
      Player player(model, flame);
      player.Pose(subject.video().train[3].params, out);
      return player.GaussiansOf(out).scale_log;
    };
    AvatarModel model = subject.Model(g);
    const Buffer<float> played = placed(model);
    EXPECT_TRUE(std::equal(played.begin(), played.end(), trained.scale_log));
    model.embedding.released.reset();
    EXPECT_EQ(placed(model) == played, system != AvatarSystem::kReleased);
  }
}

TEST(AvatarSystem, TheReleaseCannotRefineTheTrack) {
  AvatarSettings avatar = SettingsOf(AvatarSystem::kReleased, 10);
  avatar.refine_track = true;
  ExpectError([&] { AvatarSubject(SmallVideo::Get().flame, LoadSmallVideo(4, 3), avatar); },
              {"--refine-track", "released"});
}

}  // namespace
}  // namespace cosplat::test
