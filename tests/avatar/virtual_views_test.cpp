// avatar/train/virtual_views.h and what it is made of, on the procedural head filmed from the
// front, beside its images from aside.
#include "avatar/train/virtual_views.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "avatar/model/avatar_mesh.h"
#include "avatar/train/hair_shell.h"
#include "avatar/train/head_regions.h"
#include "tests/avatar/made_video.h"

namespace cosplat::test {
namespace {

constexpr int kSide = 192;
constexpr float kDegree = std::numbers::pi_v<float> / 180;
constexpr float kDistance = 0.9f;  // metres

const FlameModel& Model() { return MadeHead().model; }

Camera CameraAt(float degrees) {
  return procedural::OrbitCamera(degrees * kDegree, 0, kDistance, kSide);
}

TrainFrame FrameAt(float degrees) {
  TrainFrame frame;
  frame.camera = CameraAt(degrees);
  frame.target = RenderProceduralHead(MadeHead(), Model().template_vertices, {}, frame.camera);
  return frame;
}

// The head at rest, which is turned by so many degrees to its left for each of the frames.
struct Filmed {
  std::vector<TrainFrame> frames;
  std::vector<MeshInFrame> seen;
  explicit Filmed(const std::vector<float>& degrees) {
    for (const float d : degrees) frames.push_back(FrameAt(d));
    for (const TrainFrame& frame : frames) seen.push_back({&frame, Model().template_vertices});
  }
  PaintedMesh Paint() const {
    return PaintedMesh(Model(), MakeCanonicalMesh(Model(), {}, {}, {}), seen, 1);
  }
};

// The point that procedural::OrbitCamera looks at.
math::Vec3<float> Middle() {
  const Camera camera = CameraAt(0);
  return math::ToVec3(camera.Center()) + math::ToVec3(&camera.rotation[6]) * kDistance;
}

HeadInFrame HeadSeenFrom(float degrees) {
  return {Middle(), {1, 0, 0, 0, 1, 0, 0, 0, 1}, CameraAt(degrees)};
}

// Degrees to the head's left and upwards.
std::pair<float, float> AnglesOf(const Camera& camera) {
  const math::Vec3<float> d = math::ToVec3(camera.Center()) - Middle();
  return {std::atan2(d.x, d.z) / kDegree, std::atan2(d.y, std::hypot(d.x, d.z)) / kDegree};
}

TEST(FilmedFrom, IsWhereAllFramesButFewAre) {
  std::vector<HeadInFrame> frames{HeadSeenFrom(80)};
  for (int i = 0; i < 99; ++i) frames.push_back(HeadSeenFrom(-20 + 0.3f * float(i)));
  const FilmedFrom filmed = FilmedFromOf(frames);
  EXPECT_NEAR(filmed.yaw[0] / kDegree, -19.4f, 0.2f);
  EXPECT_NEAR(filmed.yaw[1] / kDegree, 9.1f, 0.2f);
  EXPECT_NEAR(filmed.pitch[0], filmed.pitch[1], 1e-3f);
  // From all around less is guessed.
  const float from_front = Filmed({0}).Paint().GuessedShare();
  const float around = Filmed({0, 90, 180, 270}).Paint().GuessedShare();
  EXPECT_GT(from_front, 0.4f);
  EXPECT_LT(from_front, 0.9f);
  EXPECT_LT(around, 0.6f * from_front);
}

TEST(HeadRegions, AreThoseOfAHead) {
  const CanonicalMesh mesh = MakeCanonicalMesh(Model(), {}, {}, {});
  const HeadRegions regions = FindHeadRegions(Model(), mesh);
  ASSERT_EQ(regions.part.size(), mesh.vertices.size() / 3);
  EXPECT_NEAR(regions.unit, 0.07f, 0.02f);
  const auto extreme = [&](int axis, float sign) {
    size_t best = 0;
    for (size_t v = 0; v < regions.rest.size(); ++v)
      if (sign * regions.rest[v][axis] > sign * regions.rest[best][axis]) best = v;
    return regions.part[best];
  };
  EXPECT_EQ(extreme(2, 1), HeadPart::kFace);   // the nose
  EXPECT_EQ(extreme(1, 1), HeadPart::kScalp);  // the crown
  EXPECT_EQ(extreme(1, -1), HeadPart::kBody);  // the neck's base
  std::array<size_t, kHeadParts> counts{};
  for (size_t v = 0; v < regions.rest.size(); ++v) {
    ++counts[size_t(regions.part[v])];
    // The same on both sides.
    if (std::abs(regions.rest[v].x) > 0.001f) continue;
    EXPECT_EQ(regions.part[v] == HeadPart::kScalp && regions.rest[v].y < regions.eye_height, false);
  }
  for (const size_t count : counts) EXPECT_GT(count, regions.rest.size() / 50);
}

// Of a mask that is wider by 15 px than the head around the crown, and of one that is not.
TEST(HairShell, IsAsHighAsTheMaskReaches) {
  const CanonicalMesh mesh = MakeCanonicalMesh(Model(), {}, {}, {});
  const HeadRegions regions = FindHeadRegions(Model(), mesh);
  for (const float grown : {0.0f, 0.02f}) {
    Filmed filmed({0});
    std::vector<float> larger = Model().template_vertices;
    const std::vector<math::Vec3<float>> normals = NormalsOf(larger, Model().faces);
    for (size_t v = 0; v < normals.size(); ++v)
      for (int k = 0; k < 3; ++k) larger[3 * v + size_t(k)] += grown * normals[v][k];
    const std::vector<uint8_t> mask =
        MeshSilhouette(larger, Model().faces, filmed.frames[0].camera);
    for (size_t i = 0; i < mask.size(); ++i)
      filmed.frames[0].target.data[4 * i + 3] = mask[i] ? 255 : 0;
    const std::vector<float> shell = FindHairShell(filmed.seen, Model().faces, regions, 1);
    float crown = 0, highest = 0, elsewhere = 0;
    float top = -1;
    for (size_t v = 0; v < shell.size(); ++v) {
      ASSERT_GE(shell[v], 0);
      highest = std::max(highest, shell[v]);
      if (regions.within_scalp[v] <= 0) elsewhere = std::max(elsewhere, shell[v]);
      if (regions.rest[v].y > top) top = regions.rest[v].y, crown = shell[v];
    }
    EXPECT_EQ(elsewhere, 0);
    // It falls off from the outline, which is not at the crown.
    EXPECT_GE(crown, 0.6f * grown);
    EXPECT_GE(highest, 0.8f * grown);
    EXPECT_LT(highest, grown + 0.006f);
  }
}

TEST(HairShell, IsNoneWhereNoFrameShowsTheScalp) {
  const CanonicalMesh mesh = MakeCanonicalMesh(Model(), {}, {}, {});
  Filmed filmed({0});
  Camera& camera = filmed.frames[0].camera;
  camera.cx -= 10 * kSide;  // beside the image
  for (const float h : FindHairShell(filmed.seen, Model().faces, FindHeadRegions(Model(), mesh), 1))
    EXPECT_EQ(h, 0);
}

TEST(VirtualViews, AreFromWhereNoFrameSeesTheHead) {
  std::vector<HeadInFrame> frames;
  for (int i = 0; i < 40; ++i) frames.push_back(HeadSeenFrom(float(i % 9) - 4));
  const std::vector<VirtualView> views = ChooseVirtualViews(frames, 40);
  ASSERT_GE(views.size(), 32u);
  int left = 0, behind = 0;
  for (const VirtualView& view : views) {
    const auto [yaw, pitch] = AnglesOf(view.camera);
    EXPECT_LT(std::abs(pitch), 21);
    EXPECT_GT(std::hypot(yaw, pitch), 7);  // 12 degrees from all but the outermost frames
    left += yaw > 0;
    behind += std::abs(yaw) > 90;
    // As far away as the frame's, and the head's middle where it was in the image.
    const ImagePoint middle = Project(view.camera, Middle());
    EXPECT_NEAR(middle.depth, kDistance, 1e-4f);
    EXPECT_NEAR(middle.x, 0.5f * kSide, 1e-2f);
    EXPECT_NEAR(middle.y, 0.5f * kSide, 1e-2f);
  }
  EXPECT_NEAR(left, int(views.size()) / 2, 3);
  EXPECT_NEAR(behind, 10, 3);
}

TEST(VirtualViews, AreNoneWhereFramesSeeTheHeadFromAllAround) {
  std::vector<HeadInFrame> frames;
  for (int i = 0; i < 36; ++i)
    for (const float elevation : {-20.0f, -10.0f, 0.0f, 10.0f, 20.0f}) {
      frames.push_back(HeadSeenFrom(0));
      frames.back().camera =
          procedural::OrbitCamera(float(10 * i) * kDegree, elevation * kDegree, kDistance, kSide);
    }
  EXPECT_TRUE(ChooseVirtualViews(frames, 20).empty());
  EXPECT_FALSE(ChooseVirtualViews({frames[0]}, 20).empty());
}

// Where the frame shows the head, as the head is seen from there.
TEST(VirtualViews, ShowTheHeadAsItIsFromThere) {
  const Filmed front({-6, 0, 6});
  const PaintedMesh painted = front.Paint();
  const std::vector<math::Vec3<float>> normals =
      NormalsOf(Model().template_vertices, Model().faces);
  for (const float degrees : {-40.0f, 25.0f, 180.0f}) {
    const TrainFrame truth = FrameAt(degrees);
    const TrainFrame seen = ToVirtualView({1, CameraAt(degrees)}, front.seen[1], painted);
    ASSERT_EQ(seen.target.data.size(), truth.target.data.size());
    double error = 0, wrong_alpha = 0, colors = 0, ignored = 0;
    for (size_t i = 0; i < seen.target.pixels(); ++i) {
      ignored += seen.ignored.data[i] != 0;
      if (seen.ignored.data[i] != 0) continue;
      wrong_alpha +=
          std::abs(int(seen.target.data[4 * i + 3]) - truth.target.data[4 * i + 3]) > 128;
      if (seen.target.data[4 * i + 3] < 255 || truth.target.data[4 * i + 3] < 255) continue;
      for (size_t c = 0; c < 3; ++c)
        error += std::abs(int(seen.target.data[4 * i + c]) - truth.target.data[4 * i + c]);
      colors += 3;
    }
    EXPECT_LT(ignored, 0.08 * kSide * kSide) << degrees;
    EXPECT_LT(wrong_alpha, 0.01 * kSide * kSide) << degrees;
    EXPECT_GT(colors, 0.2 * 3 * kSide * kSide) << degrees;
    EXPECT_LT(error / colors, degrees == 180 ? 40 : 14) << degrees;
  }
}

// What no frame shows is guessed from what is alike: the back of the head is hair, not skin.
TEST(VirtualViews, HaveHairBehindWhereThereIsHairInFront) {
  const Filmed front({0});
  const TrainFrame behind = ToVirtualView({0, CameraAt(180)}, front.seen[0], front.Paint());
  const TrainFrame truth = FrameAt(180);
  // A part of the head's back above its middle.
  std::array<double, 3> guessed{}, there{};
  for (int y = kSide / 5; y < kSide / 3; ++y)
    for (int x = 2 * kSide / 5; x < 3 * kSide / 5; ++x)
      for (int c = 0; c < 3; ++c) {
        guessed[size_t(c)] += behind.target.at(x, y, c);
        there[size_t(c)] += truth.target.at(x, y, c);
      }
  // Darker than half of white, as the hair, where skin is lighter.
  for (size_t c = 0; c < 3; ++c) EXPECT_LT(guessed[c] / there[c], 2.2) << c;
}

double PsnrFrom(const AvatarModel& avatar, float degrees) {
  Player player(avatar, Model());
  RenderedImage image;
  const TrainFrame truth = FrameAt(degrees);
  player.RenderOver({}, truth.camera, {1, 1, 1}, image);
  return Psnr(image.color, Target(truth.target));
}

// Without masks nobody knows where the head ends: an alpha that is opaque everywhere is none.
TEST(VirtualViews, AreNoneWithoutMasks) {
  for (const bool opaque : {false, true}) {
    TrackedVideo video = MakeSmallVideo(6, 2);
    for (TrackedFrame& frame : video.train) {
      Image8 image = *frame.image;
      for (size_t i = 3; opaque && i < image.data.size(); i += 4) image.data[i] = 255;
      frame.image = std::make_shared<const Image8>(std::move(image));
    }
    AvatarSettings settings = SmallAvatar(100);
    settings.virtual_views = 0.2f;
    const AvatarSubject subject(Model(), video, settings);
    EXPECT_EQ(subject.IsMasked(), !opaque);
    EXPECT_EQ(subject.virtual_view_count() > 0, !opaque);
  }
}

// Trained on views from the front: from aside far better with virtual views.
TEST(VirtualViews, KeepTheHeadTogetherFromAside) {
  std::vector<TrainFrame> frames;
  for (int f = 0; f < 12; ++f) frames.push_back(FrameAt(float(f % 5) - 2));
  const TrackedVideo video = VideoOf(std::move(frames));
  std::array<double, 2> from_aside{}, from_the_front{};
  for (const bool with : {false, true}) {
    AvatarSettings settings = SmallAvatar(1500);
    settings.virtual_views = with ? 0.2f : 0.0f;
    settings.iterations = 250;
    AvatarSubject subject(Model(), video, settings);
    EXPECT_EQ(subject.virtual_view_count() > 0, with);
    const TrainSettings train = ShortRun(250, 3000);
    Trainer trainer(train, subject, subject.InitialGaussians(train.degree, Basis::kDcsh, 1));
    while (trainer.iteration() < train.iterations) trainer.Step();
    const AvatarModel avatar = subject.Model(trainer.TakeGaussians());
    from_aside[with] = PsnrFrom(avatar, 45);
    from_the_front[with] = PsnrFrom(avatar, 0);
  }
  EXPECT_GT(from_aside[1], from_aside[0] + 1.5);
  EXPECT_GT(from_the_front[1], from_the_front[0] - 2.5);
}

}  // namespace
}  // namespace cosplat::test
