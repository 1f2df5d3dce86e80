// avatar/play/player.h and avatar/play/playback.h: what is not done again, and what runs beside
// each other, leaves no trace in the images.
#include "avatar/play/playback.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <limits>

#include "apps/study/avatar_stability/painted_avatar.h"
#include "assets/head/motion.h"
#include "splat/media/image_io.h"
#include "tests/support/expect_error.h"
#include "tests/support/restless_params.h"
#include "tests/support/same_bits.h"

namespace cosplat::test {
namespace {

const ProceduralHead& Head() {
  static const ProceduralHead head = MakeProceduralHeadParts();
  return head;
}
const FlameModel& Flame() { return Head().model; }
const AvatarModel& Painted() {
  static const AvatarModel avatar = PaintedAvatar(Head(), 1500);
  return avatar;
}

Camera CameraAt(float azimuth, int width, int height) {
  Camera camera = procedural::OrbitCamera(azimuth, 0.05f, 0.9f, width);
  camera.height = height;
  return camera;
}

PlaybackFrame FrameAt(int i) {
  return {RestlessParams(Flame(), i), CameraAt(0.1f * float(i), 50, 41), {0.2f, 0.5f, 1}};
}

bool SameImage(const RenderedImage& a, const RenderedImage& b) {
  return a.width == b.width && a.height == b.height && SameBits(a.color, b.color) &&
         SameBits(a.transmittance, b.transmittance);
}

RenderedImage FreshImage(const PlaybackFrame& f, PlayerSettings settings = {}) {
  Player player(Painted(), Flame(), settings);
  RenderedImage image;
  player.RenderOver(f.params, f.camera, f.background, image);
  return image;
}

// Changes one thing or several, or nothing.
void ChangeSomething(Rng& rng, int step, PlaybackFrame& f) {
  const FlameParams other = RestlessParams(Flame(), step);
  switch (int(9 * rng.Uniform())) {
    case 0:
      break;
    case 1:
      f.params.expression = other.expression;
      break;
    case 2:
      f.params.expression.resize(size_t(5 * rng.Uniform()));
      break;
    case 3:
      f.params.pose = other.pose;
      break;
    case 4:
      f.params.pose[0] = other.pose[0];  // the root alone: no pose direction changes
      break;
    case 5:
      f.params.translation = other.translation;
      break;
    case 6:
      f.camera = CameraAt(rng.Uniform(), 50, 41);
      break;
    case 7:
      f.background[1] = rng.Uniform();
      break;
    default:
      f = {other, CameraAt(rng.Uniform(), 33 + step % 7, 20 + step % 5), {1, 1, 1}};
  }
}

TEST(Player, WhatItRemembersNeverShows) {
  for (const bool half : {false, true}) {
    const PlayerSettings settings{half};
    Player player(Painted(), Flame(), settings);
    Rng rng{5};
    PlaybackFrame frame = FrameAt(0);
    RenderedImage image;
    for (int step = 0; step < 40; ++step) {
      ChangeSomething(rng, step, frame);
      player.RenderOver(frame.params, frame.camera, frame.background, image);
      ASSERT_TRUE(SameImage(image, FreshImage(frame, settings))) << step << " half " << half;
    }
  }
}

TEST(Player, AnEqualFrameIsNotDrawnAgain) {
  Player player(Painted(), Flame());
  PlaybackFrame frame = FrameAt(1);
  PosedAvatar placed;
  EXPECT_FALSE(placed.IsFor(frame.params));
  const auto work = [&] {
    player.times() = {};
    player.Pose(frame.params, placed);
    player.Draw(placed, frame.camera, frame.background);
    return player.times().seconds[size_t(Phase::kBlend)] > 0;
  };
  EXPECT_TRUE(work());
  EXPECT_TRUE(placed.IsFor(frame.params));
  EXPECT_FALSE(work());
  frame.params.shape = {1, 2, 3};  // the avatar has its own
  EXPECT_FALSE(work());
  frame.background[0] = 0.9f;
  EXPECT_TRUE(work());
  frame.camera.cx += 1;
  EXPECT_TRUE(work());
  frame.params.pose[1][2] += 0.1f;
  EXPECT_FALSE(placed.IsFor(frame.params));
  EXPECT_TRUE(work());
  EXPECT_FALSE(work());
}

TEST(Player, BytesAreThoseOfTheGeneralConversion) {
  Player player(Painted(), Flame());
  const PlaybackFrame frame = FrameAt(2);
  Image8 bytes(3, 100, 1);  // of another kind
  player.Render(frame.params, frame.camera, bytes);
  RenderedImage image;
  player.RenderOver(frame.params, frame.camera, {0, 0, 0}, image);
  const Image8 expected = ToBytes(image.ToStraightAlpha());
  EXPECT_EQ(bytes.width, expected.width);
  EXPECT_EQ(bytes.height, expected.height);
  EXPECT_EQ(bytes.channels, expected.channels);
  EXPECT_EQ(bytes.data, expected.data);
}

TEST(Player, RefusesToDrawWhatWasNotPlaced) {
  Player player(Painted(), Flame());
  const PosedAvatar placed;
  ExpectError([&] { player.Draw(placed, CameraAt(0, 8, 8), {0, 0, 0}); }, {"placed"});
}

TEST(Playback, GivesThePlayersImagesForAnyNumberOfThreads) {
  std::vector<PlaybackFrame> frames;
  for (int i = 0; i < 12; ++i) frames.push_back(FrameAt(i));
  frames[4].params = frames[3].params;  // only the camera moves
  frames[5] = frames[4];                // nothing does
  frames[8].params = frames[6].params;  // as two frames before
  std::vector<RenderedImage> expected;
  for (const PlaybackFrame& f : frames) expected.push_back(FreshImage(f));
  for (const size_t threads : {1, 2, 3}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Player player(Painted(), Flame());
    Playback playback(player);
    EXPECT_EQ(playback.Next(frames[0]), nullptr);
    for (size_t i = 1; i <= frames.size(); ++i) {
      const RenderedImage* picture =
          i < frames.size() ? playback.Next(frames[i]) : playback.Finish();
      ASSERT_NE(picture, nullptr) << i;
      EXPECT_TRUE(SameImage(*picture, expected[i - 1])) << i - 1 << " threads " << threads;
    }
    EXPECT_EQ(playback.Finish(), nullptr);
    EXPECT_EQ(playback.Next(frames[7]), nullptr);  // and again
    EXPECT_TRUE(SameImage(*playback.Finish(), expected[7]));
  }
}

TEST(Playback, AFrameThatCannotBeDrawnIsLostAlone) {
  std::vector<PlaybackFrame> frames;
  for (int i = 0; i < 8; ++i) frames.push_back(FrameAt(i));
  frames[2].params.pose[2][0] = std::numeric_limits<float>::quiet_NaN();
  frames[3].params.translation[1] = std::numeric_limits<float>::infinity();
  frames[5].camera.width = 0;
  frames[7].params.expression[0] = -std::numeric_limits<float>::infinity();
  Player player(Painted(), Flame());
  Playback playback(player);
  playback.Next(frames[0]);
  for (size_t i = 0; i < frames.size(); ++i) {
    const auto step = [&] {
      return i + 1 < frames.size() ? playback.Next(frames[i + 1]) : playback.Finish();
    };
    if (i == 2 || i == 3 || i == 5 || i == 7) {
      ExpectError([&] { step(); },
                  {i == 2   ? "pose"
                   : i == 3 ? "translation"
                   : i == 5 ? "camera"
                            : "expression"});
    } else {
      const RenderedImage* picture = step();
      ASSERT_NE(picture, nullptr) << i;
      EXPECT_TRUE(SameImage(*picture, FreshImage(frames[i]))) << i;
    }
  }
}

TEST(Playback, KeepsTheVerticesOfTheImageThatItReturned) {
  Player player(Painted(), Flame());
  Playback playback(player);
  for (int i = 0; i < 5; ++i) {
    const bool drawn = playback.Next(FrameAt(i)) != nullptr;
    if (!drawn) continue;
    PosedAvatar placed;
    Player alone(Painted(), Flame());
    alone.Pose(FrameAt(i - 1).params, placed);
    EXPECT_EQ(playback.vertices(), alone.VerticesOf(placed)) << i;
  }
}

}  // namespace
}  // namespace cosplat::test
