// Avatars played on the device against the CPU's player: images, what is kept between them, what
// is refused.
#include <gtest/gtest.h>

#include <limits>

#include "apps/study/avatar_stability/painted_avatar.h"
#include "assets/head/motion.h"
#include "avatar/play/avatar_renderer.h"
#include "avatar/play/playback.h"
#include "tests/avatar/with_corrections.h"
#include "tests/parity/compare.h"
#include "tests/parity/device_fixture.h"
#include "tests/parity/image_bytes.h"
#include "tests/support/expect_error.h"
#include "tests/support/restless_params.h"

namespace cosplat {
namespace {

class PlayerParity : public test::DeviceTest {};

const ProceduralHead& Head() {
  static const ProceduralHead head = MakeProceduralHeadParts();
  return head;
}
const FlameModel& Flame() { return Head().model; }

PlayerSettings OnDevice(bool half_resolution = false) {
  return {half_resolution, AvatarRendererOn(Device::kCuda)};
}

PlaybackFrame FrameAt(int i, int width = 50) {
  PlaybackFrame frame{test::RestlessParams(Flame(), i),
                      procedural::OrbitCamera(0.1f * float(i), 0.05f, 0.9f, width),
                      {0.2f, 0.5f, 1}};
  frame.camera.height = width - 9;
  return frame;
}

RenderedImage Draw(Player& player, const PlaybackFrame& f) {
  RenderedImage image;
  player.RenderOver(f.params, f.camera, f.background, image);
  return image;
}

void ExpectSame(const RenderedImage& cpu, const RenderedImage& device) {
  ASSERT_EQ(cpu.width, device.width);
  ASSERT_EQ(cpu.height, device.height);
  test::ExpectSameImage(cpu.color, device.color, {}, "colour");
  test::ExpectSameImage(cpu.transmittance, device.transmittance, {}, "transmittance");
}

void ExpectSamePlayed(const AvatarModel& avatar, int frames, bool half_resolution = false) {
  Player cpu(avatar, Flame(), {half_resolution}),
      device(avatar, Flame(), OnDevice(half_resolution));
  for (int i = 0; i < frames; ++i) {
    SCOPED_TRACE(i);
    ExpectSame(Draw(cpu, FrameAt(i)), Draw(device, FrameAt(i)));
  }
}

AvatarModel FirstOnes(const AvatarModel& avatar, size_t count) {
  AvatarModel few = avatar;
  few.embedding.triangle.resize(count);
  few.embedding.barycentric.resize(count);
  for (int a = 0; a < kAttributeCount; ++a)
    few.gaussians.values[a].resize(count * size_t(few.gaussians.width(a)));
  few.gaussians.degrees.resize(std::min(few.gaussians.degrees.size(), count));
  return few;
}

TEST_F(PlayerParity, DrawsWhatTheCpuDraws) {
  const AvatarModel avatar = PaintedAvatar(Head(), 900);
  ExpectSamePlayed(avatar, 3);
  AvatarModel other = avatar;
  other.color_frame = ColorFrame::kWorld;
  ExpectSamePlayed(other, 1);
  ExpectSamePlayed(avatar, 1, true);
}

TEST_F(PlayerParity, DrawsOneGaussianAndNone) {
  const AvatarModel avatar = PaintedAvatar(Head(), 40);
  ExpectSamePlayed(FirstOnes(avatar, 1), 2);
  ExpectSamePlayed(FirstOnes(avatar, 0), 1);
}

// One pose from two sides, then another pose, then the first again.
TEST_F(PlayerParity, KeepsNothingOfTheLastImage) {
  const AvatarModel avatar = PaintedAvatar(Head(), 300);
  Player player(avatar, Flame(), OnDevice());
  PlaybackFrame turned = FrameAt(0);
  turned.camera = FrameAt(4).camera;
  for (const PlaybackFrame& frame : {FrameAt(0), turned, FrameAt(2), FrameAt(3, 31), FrameAt(0)}) {
    Player fresh(avatar, Flame(), OnDevice());
    EXPECT_EQ(Draw(player, frame).color, Draw(fresh, frame).color);
  }
}

TEST_F(PlayerParity, PlaysWithTheNextFramePlacedMeanwhile) {
  const AvatarModel avatar = PaintedAvatar(Head(), 300);
  Player player(avatar, Flame(), OnDevice()), one_by_one(avatar, Flame(), OnDevice());
  Playback playback(player);
  EXPECT_EQ(playback.Next(FrameAt(0)), nullptr);
  for (int i = 1; i <= 3; ++i) {
    const RenderedImage* picture = i < 3 ? playback.Next(FrameAt(i)) : playback.Finish();
    ASSERT_NE(picture, nullptr);
    EXPECT_EQ(picture->color, Draw(one_by_one, FrameAt(i - 1)).color);
  }
}

// Some of its Gaussians on the sheet that is not posed.
TEST_F(PlayerParity, DrawsABust) {
  AvatarModel avatar = PaintedAvatar(Head(), 300);
  avatar.bust = MeanBust(Flame(), {}, {}, {FrameAt(3).params});
  const size_t head_faces = avatar.mesh.faces.size();
  avatar.mesh = MakeCanonicalMesh(Flame(), {}, {}, avatar.bust);
  const size_t bust_faces = avatar.mesh.faces.size() - head_faces;
  for (size_t i = 0; i < avatar.size(); i += 3)
    avatar.embedding.triangle[i] = int32_t(head_faces + (7 * i) % bust_faces);
  ExpectSamePlayed(avatar, 2);
  BustFollow& follow = avatar.bust->follow.emplace();
  follow.matrix.fill(0.2f);
  follow.min.fill(-0.3f);
  follow.max.fill(0.3f);
  ExpectSamePlayed(avatar, 2);
}

TEST_F(PlayerParity, FollowsTheExpressionWithCorrections) {
  const AvatarModel avatar = test::WithCorrections(PaintedAvatar(Head(), 300), Flame(), 3);
  ExpectSamePlayed(avatar, 3);
  // The Gaussians of a placed avatar, asked for once another was placed.
  Player device(avatar, Flame(), OnDevice()), cpu(avatar, Flame());
  PosedAvatar first, second, alone;
  device.Pose(FrameAt(1).params, first);
  device.VerticesOf(first);
  device.Pose(FrameAt(3).params, second);
  cpu.Pose(FrameAt(1).params, alone);
  EXPECT_EQ(device.GaussiansOf(first).opacity_logit, cpu.GaussiansOf(alone).opacity_logit);
}

TEST_F(PlayerParity, IsLit) {
  AvatarModel avatar = test::WithCorrections(PaintedAvatar(Head(), 300), Flame(), 2);
  Light& light = avatar.light.emplace();
  for (size_t k = 0; k < light.size(); ++k) light[k] = 0.2f * float(std::sin(double(k)));
  ExpectSamePlayed(avatar, 3);
}

// A face that no tracker gives, then one at rest.
TEST_F(PlayerParity, DrawsAnExtremeFace) {
  const AvatarModel avatar = PaintedAvatar(Head(), 300);
  Player cpu(avatar, Flame()), device(avatar, Flame(), OnDevice());
  PlaybackFrame frame = FrameAt(1);
  for (float& x : frame.params.expression) x *= 30;
  for (auto& joint : frame.params.pose)
    for (float& x : joint) x *= 20;
  ExpectSame(Draw(cpu, frame), Draw(device, frame));
  frame.params = {};
  ExpectSame(Draw(cpu, frame), Draw(device, frame));
}

// One copy of the model's directions; everything else is a player's own.
TEST_F(PlayerParity, PlayersOfOneMakerDoNotDisturbEachOther) {
  const AvatarModel avatar = PaintedAvatar(Head(), 100);
  const PlayerSettings shared = OnDevice();
  Player fresh(avatar, Flame(), OnDevice()), first(avatar, Flame(), shared);
  Draw(first, FrameAt(1));
  auto second = std::make_unique<Player>(avatar, Flame(), shared);
  Draw(*second, FrameAt(2));
  second.reset();
  EXPECT_EQ(Draw(first, FrameAt(0)).color, Draw(fresh, FrameAt(0)).color);
}

TEST_F(PlayerParity, ImagesCanStay) {
  const AvatarModel avatar = PaintedAvatar(Head(), 200);
  Player player(avatar, Flame(), OnDevice());
  PosedAvatar placed;
  std::unique_ptr<DeviceImage> stays;
  for (const int i : {0, 0, 3}) {
    const PlaybackFrame f = FrameAt(i);
    player.Pose(f.params, placed);
    ASSERT_TRUE(player.DrawsOnDevice());
    player.DrawToStay(placed, f.camera, f.background, AlphaMode::kOpaque, stays);
    const RenderedImage& image = player.Draw(placed, f.camera, f.background);
    test::ExpectBytesOf<AlphaMode::kOpaque>(image, *stays);
  }
  Player half(avatar, Flame(), OnDevice(true)), cpu(avatar, Flame());
  for (Player* other : {&half, &cpu}) {
    EXPECT_FALSE(other->DrawsOnDevice());
    other->Pose(FrameAt(0).params, placed = {});
    const auto draw = [&] {
      other->DrawToStay(placed, FrameAt(0).camera, {0, 0, 0}, AlphaMode::kStraight, stays);
    };
    test::ExpectError(draw, {"image", "no device"});
  }
}

// For whoever needs the Gaussians beside the image, the plug-in's depth, or the mesh.
TEST_F(PlayerParity, GivesTheGaussiansThatTheCpuBinds) {
  const AvatarModel avatar = PaintedAvatar(Head(), 300);
  Player cpu(avatar, Flame()), device(avatar, Flame(), OnDevice());
  PosedAvatar on_cpu, on_device;
  for (const int i : {0, 2}) {
    cpu.Pose(FrameAt(i).params, on_cpu);
    device.Pose(FrameAt(i).params, on_device);
    EXPECT_EQ(cpu.VerticesOf(on_cpu), device.VerticesOf(on_device));
    EXPECT_EQ(cpu.GaussiansOf(on_cpu).position, device.GaussiansOf(on_device).position);
  }
}

TEST_F(PlayerParity, RefusesWhatTheCpuRefuses) {
  const AvatarModel avatar = PaintedAvatar(Head(), 60);
  Player player(avatar, Flame(), OnDevice());
  const RenderedImage before = Draw(player, FrameAt(0));
  PlaybackFrame bad = FrameAt(1);
  bad.params.pose[2][1] = std::numeric_limits<float>::quiet_NaN();
  test::ExpectError([&] { Draw(player, bad); }, {"pose"});
  bad = FrameAt(1);
  bad.camera.width = 0;
  test::ExpectError([&] { Draw(player, bad); }, {"camera"});
  EXPECT_EQ(Draw(player, FrameAt(0)).color, before.color);
  AvatarModel broken = avatar;
  broken.embedding.triangle[7] = 1 << 20;
  test::ExpectError([&] { Player(broken, Flame(), OnDevice()); }, {"triangle[7]"});
  AvatarModel released = avatar;
  released.embedding.released.emplace();
  test::ExpectError([&] { Player(released, Flame(), OnDevice()); }, {"released", "CPU"});
}

}  // namespace
}  // namespace cosplat
