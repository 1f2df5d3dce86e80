// avatar/train/virtual_faces.h, on a head that is filmed with its mouth shut.
#include "avatar/train/virtual_faces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "flame/mouth.h"
#include "tests/avatar/made_video.h"
#include "tests/flame/hollow_head.h"

namespace cosplat::test {
namespace {

constexpr int kSide = 192;

const FlameModel& WithTeeth() {
  static const FlameModel model = WithMouth(HollowHead());
  return model;
}

Camera Front() { return procedural::OrbitCamera(0, 0, 0.9f, kSide); }

// Frames whose jaw is opened by so many radians.
struct Talking {
  AvatarPoser poser{WithTeeth(), {}, {}, {}};
  std::vector<AvatarPoser::Parameters> track;
  std::vector<Camera> cameras;

  Talking(size_t frames, float jaw) : track(frames, At(jaw)), cameras(frames, Front()) {}
  AvatarPoser::Parameters At(float jaw) const {
    FlameParams face;
    face.pose[2][0] = jaw;
    return poser.ParametersFor(face);
  }
  VirtualFaces Choose(size_t count) {
    return ChooseVirtualFaces(WithTeeth(), poser, track, cameras, count);
  }
};

TEST(VirtualFaces, OpenTheMouthWiderThanTheFrames) {
  Talking shut(20, 0), open(20, 0.6f);
  const VirtualFaces chosen = shut.Choose(8);
  ASSERT_EQ(chosen.faces.size(), 8u);
  EXPECT_LT(chosen.known, 0.004f);
  for (const VirtualFace& face : chosen.faces) EXPECT_GT(face.params.pose[2][0], 0);
  EXPECT_LT(open.Choose(8).faces.size(), 8u);
  // The same every time.
  EXPECT_EQ(shut.Choose(8).faces[3].params.expression, chosen.faces[3].params.expression);
  AvatarPoser without(MadeHead().model, {}, {}, {});
  EXPECT_TRUE(
      ChooseVirtualFaces(MadeHead().model, without, shut.track, shut.cameras, 8).faces.empty());
}

TEST(VirtualFaces, ShowLipsAndDeepBetweenThemTheDark) {
  Talking shut(1, 0);
  TrainFrame frame;
  frame.camera = Front();
  frame.target =
      RenderProceduralHead(MadeHead(), MadeHead().model.template_vertices, {}, frame.camera);
  MeshInFrame seen{&frame, {}};
  shut.poser.Forward(shut.track[0], seen.vertices);
  const PaintedMesh painted(WithTeeth(), MakeCanonicalMesh(WithTeeth(), {}, {}, {}), {seen}, 1);
  EXPECT_FALSE(ToVirtualFace(seen, seen.vertices, 0.01f, painted)) << "a shut mouth";
  std::vector<float> vertices;
  shut.poser.Forward(shut.At(0.35f), vertices);
  const auto mesh = DrawMesh(vertices, WithTeeth().faces, frame.camera);
  size_t dark_before = 0;
  for (const float known : {0.001f, 0.004f}) {
    const auto face = ToVirtualFace(seen, vertices, known, painted);
    ASSERT_TRUE(face);
    size_t dark = 0, lips = 0;
    for (size_t i = 0; i < mesh.size(); ++i) {
      if (face->ignored.data[i] != 0) continue;
      EXPECT_EQ(face->target.data[4 * i + 3], 255);
      const int green = face->target.data[4 * i + 1];
      const bool inside = painted.IsInMouth(mesh[i]);
      (inside ? dark : lips) += 1;
      if (inside) {
        EXPECT_LT(green, 50);
      } else {
        EXPECT_GT(green, 30);
      }
    }
    EXPECT_GT(dark, 20u);
    EXPECT_GT(lips, dark);
    EXPECT_LT(lips + dark, mesh.size() / 20) << "all else is ignored";
    if (dark_before > 0) {
      EXPECT_LT(dark, dark_before);
    }
    dark_before = dark;
  }
}

// How bright it is deep in an open mouth, of an avatar trained on a shut one.
double BrightnessInside(bool with_virtual) {
  constexpr int kSmall = 96;
  TrainFrame frame;
  frame.camera = procedural::OrbitCamera(0, 0, 0.5f, kSmall);
  frame.target =
      RenderProceduralHead(MadeHead(), MadeHead().model.template_vertices, {}, frame.camera);
  const TrackedVideo video = VideoOf(std::vector<TrainFrame>(16, frame));
  AvatarSettings settings = SmallAvatar(1500);
  settings.virtual_views = with_virtual ? 0.5f : 0.0f;
  settings.iterations = 1200;
  AvatarSubject subject(WithTeeth(), video, settings);
  const TrainSettings train = ShortRun(1200, 2500);
  Trainer trainer(train, subject, subject.InitialGaussians(train.degree, Basis::kDcsh, 1));
  while (trainer.iteration() < train.iterations) trainer.Step();
  FlameParams open;
  open.pose[2][0] = 0.35f;
  RenderedImage image;
  const AvatarModel avatar = subject.Model(trainer.TakeGaussians());
  Player(avatar, WithTeeth()).RenderOver(open, frame.camera, {1, 1, 1}, image);
  AvatarPoser poser(WithTeeth(), {}, {}, {});
  std::vector<float> vertices;
  poser.Forward(poser.ParametersFor(open), vertices);
  const auto mesh = DrawMesh(vertices, WithTeeth().faces, frame.camera);
  const auto is_inside = [&](int x, int y) {
    const MeshPixel& at = mesh[size_t(y * kSmall + x)];
    return at.face >= 0 && WithTeeth().faces[size_t(at.face)][0] >= WithTeeth().own_vertex_count();
  };
  double sum = 0;
  int count = 0;
  for (int y = 2; y < kSmall - 2; ++y)
    for (int x = 2; x < kSmall - 2; ++x) {
      if (!is_inside(x - 2, y) || !is_inside(x + 2, y) || !is_inside(x, y - 2) ||
          !is_inside(x, y + 2))
        continue;
      sum += double(image.color[size_t((kSmall + y) * kSmall + x)]);  // green
      ++count;
    }
  EXPECT_GT(count, 20);
  return sum / count;
}

TEST(VirtualFaces, MakeAnOpenMouthDark) {
  const double with = BrightnessInside(true), without = BrightnessInside(false);
  EXPECT_LT(with, 0.7 * without) << with << " " << without;
}

}  // namespace
}  // namespace cosplat::test
