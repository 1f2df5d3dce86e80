// apps/viewer/session.h and what it is made of: time, sliders, keys, live input.
#include "apps/viewer/session.h"

#include <gtest/gtest.h>

#include "apps/viewer/detail.h"
#include "apps/viewer/key_bindings.h"
#include "apps/viewer/time_history.h"
#include "avatar/math/turn.h"
#include "tests/support/expect_error.h"
#include "tests/viewer/viewer_fixture.h"

namespace cosplat::test {
namespace {

using viewer::Action;
using viewer::Detail;
using viewer::Driver;
using viewer::FaceControls;
using viewer::Session;
using viewer::Timeline;
using viewer::View;

constexpr int64_t kSecond = 1'000'000'000;
constexpr size_t kJaw = 2;

Session DrivenSession(int frames) {
  Session session(PaintedHead());
  session.SetSequence(OpeningMouth(frames), 25);
  return session;
}

TEST(Timeline, AdvancesLoopsAndStops) {
  Timeline timeline(50, 25);
  timeline.Advance(1);
  EXPECT_EQ(timeline.frame(), 0);  // does not play yet
  timeline.Play();
  timeline.Advance(0.5);
  EXPECT_EQ(timeline.frame(), 12);
  timeline.speed = 2;
  timeline.Advance(0.25);
  EXPECT_EQ(timeline.frame(), 25);
  timeline.Advance(100.02);
  EXPECT_EQ(timeline.frame(), 26);  // 5001 frames on: round and round
  timeline.loops = false;
  timeline.Advance(100);
  EXPECT_EQ(timeline.frame(), 49);
  EXPECT_FALSE(timeline.playing());
  timeline.Toggle();  // from the beginning again
  EXPECT_EQ(timeline.frame(), 0);
  EXPECT_TRUE(timeline.playing());
}

// The camera is before the head at first.
TEST(Session, SaysWhereNobodyFilmed) {
  viewer::Content content = PaintedHead();
  EXPECT_FALSE(Session(content).IsBeyondFilm());
  content.avatar->model.filmed = FilmedFrom{{-0.1f, 0.2f}, {-0.1f, 0.1f}, {}};
  Session session(content);
  EXPECT_FALSE(session.IsBeyondFilm());
  session.camera.Orbit(0.35f, 0);  // to the head's left
  EXPECT_FALSE(session.IsBeyondFilm());
  session.camera.Orbit(-0.7f, 0);
  EXPECT_TRUE(session.IsBeyondFilm());
  // The head turns there.
  FlameParams turned = session.Face();
  turned.pose[0] =
      math::AxisAngleOf(math::Multiply(math::QuatOfAxisAngle(std::array<float, 3>{0, -0.3f, 0}),
                                       math::QuatOfAxisAngle(turned.pose[0])));
  session.SetSequence({turned}, 25);
  EXPECT_FALSE(session.IsBeyondFilm());
  session.camera.Orbit(0, 0.6f);
  EXPECT_TRUE(session.IsBeyondFilm());
}

TEST(Timeline, ScrubsWithinItsFrames) {
  Timeline timeline(10, 25);
  timeline.Seek(99);
  EXPECT_EQ(timeline.frame(), 9);
  timeline.Play();
  timeline.Step(-3);
  EXPECT_EQ(timeline.frame(), 6);
  EXPECT_FALSE(timeline.playing());
  timeline.Step(-30);
  EXPECT_EQ(timeline.frame(), 0);
  Timeline none;
  none.Play();
  none.Advance(1);
  none.Step(1);
  EXPECT_EQ(none.frame(), 0);
  EXPECT_FALSE(none.playing());
}

TEST(FaceControls, SlidersMakeTheFace) {
  FlameParams rest;
  rest.pose[0] = {0.1f, 0.2f, 0.3f};
  rest.translation = {1, 2, 3};
  FaceControls controls(5, rest, {});
  EXPECT_EQ(controls.expressions().size(), 5u);
  controls.expressions()[3].value = 1.5f;
  for (auto& joint : controls.joints())
    if (joint.name == "Jaw open") joint.value = 0.25f;
  const FlameParams face = controls.Face();
  EXPECT_EQ(face.expression, (std::vector<float>{0, 0, 0, 1.5f, 0}));
  EXPECT_EQ(face.pose[kJaw][0], 0.25f);
  EXPECT_EQ(face.pose[0], rest.pose[0]);
  EXPECT_EQ(face.translation, rest.translation);
  controls.SetNeutral();
  EXPECT_EQ(controls.Face().expression, std::vector<float>(5, 0));
}

TEST(FaceControls, RandomFacesDifferAndStayInRange) {
  FaceControls controls(30, {}, {});
  Rng rng;
  controls.SetRandom(rng);
  const FlameParams first = controls.Face();
  controls.SetRandom(rng);
  EXPECT_NE(first.expression, controls.Face().expression);
  for (const auto* sliders : {&controls.expressions(), &controls.joints()})
    for (const auto& slider : *sliders) {
      EXPECT_GE(slider.value, slider.min);
      EXPECT_LE(slider.value, slider.max);
    }
}

TEST(FaceControls, ReachesSomewhatBeyondTraining) {
  TrainedRange trained;
  trained.expression_least = {-2, 0.2f};
  trained.expression_most = {6, 0.4f};
  FaceControls controls(3, {}, trained);  // the third was never seen
  EXPECT_FLOAT_EQ(controls.expressions()[0].min, -4);
  EXPECT_FLOAT_EQ(controls.expressions()[0].max, 8);
  EXPECT_FLOAT_EQ(controls.expressions()[1].min, -0.5f);
  EXPECT_FLOAT_EQ(controls.expressions()[1].max, 0.9f);
  Rng rng;
  for (int i = 0; i < 20; ++i) {
    controls.SetRandom(rng);
    EXPECT_GE(controls.Face().expression[0], -2);
    EXPECT_LE(controls.Face().expression[0], 6);
  }
}

TEST(FaceControls, TurnsTheHeadAboutItsRest) {
  FlameParams rest;
  rest.pose[0] = {3.1f, 0, 0};  // as in worlds whose y is down
  FaceControls controls(0, rest, {});
  for (auto& joint : controls.joints())
    if (joint.name == "Head turn") joint.value = 0.4f;
  const FlameParams face = controls.Face();
  EXPECT_NE(face.pose[0], rest.pose[0]);
  FaceControls other(0, rest, {});
  other.SetFace(face);
  for (const auto& joint : other.joints())
    EXPECT_NEAR(joint.value, joint.name == "Head turn" ? 0.4f : 0, 1e-5);
}

TEST(FaceControls, TakesAFaceWithinItsRanges) {
  FaceControls controls(3, {}, {});
  FlameParams face;
  face.expression = {0.5f, 100};  // fewer than sliders; beyond the range
  face.pose[kJaw][0] = 0.2f;
  controls.SetFace(face);
  EXPECT_EQ(controls.Face().expression, (std::vector<float>{0.5f, 3, 0}));
  EXPECT_EQ(controls.Face().pose[kJaw][0], 0.2f);
}

TEST(Session, PlaysItsSequenceInTime) {
  Session session = DrivenSession(50);
  EXPECT_EQ(session.driver, Driver::kSequence);
  session.Advance(5 * kSecond);  // the first call is the beginning
  EXPECT_EQ(session.timeline.frame(), 0);
  session.Advance(6 * kSecond);
  EXPECT_EQ(session.timeline.frame(), 25);
  EXPECT_EQ(session.ShotFor(8, 8).face.pose[kJaw][0], OpeningMouth(50)[25].pose[kJaw][0]);
  session.Do(Action::kTogglePlay);
  session.Advance(7 * kSecond);
  EXPECT_EQ(session.timeline.frame(), 25);
  session.Do(Action::kStepForward);
  EXPECT_EQ(session.timeline.frame(), 26);
  session.Do(Action::kToStart);
  EXPECT_EQ(session.timeline.frame(), 0);
}

TEST(Session, SlidersTakeOverTheFaceThatIsShown) {
  Session session = DrivenSession(10);
  session.timeline.Seek(5);
  const float jaw = session.Face().pose[kJaw][0];
  session.TakeSliders();
  EXPECT_EQ(session.driver, Driver::kSliders);
  EXPECT_FLOAT_EQ(session.Face().pose[kJaw][0], jaw);
  session.Do(Action::kNeutralFace);
  EXPECT_EQ(session.Face().pose[kJaw][0], 0);
  session.Do(Action::kRandomFace);
  EXPECT_NE(session.Face().expression, std::vector<float>(session.Face().expression.size(), 0));
  session.Do(Action::kTogglePlay);  // the sequence again
  EXPECT_EQ(session.driver, Driver::kSequence);
}

TEST(Session, KeysChangeWhatTheySay) {
  Session session(PaintedHead());
  session.Do(Action::kViewWire);
  EXPECT_EQ(session.view(), View::kWire);
  session.Do(Action::kViewEllipsoids);
  EXPECT_EQ(session.ShotFor(8, 8).view, View::kEllipsoids);
  session.Do(Action::kToggleTransparent);
  EXPECT_TRUE(session.ShotFor(8, 8).transparent);
  session.Do(Action::kTogglePanels);
  EXPECT_FALSE(session.panels_open);
  session.Do(Action::kToggleHelp);
  EXPECT_TRUE(session.help_open);
  session.Do(Action::kToggleLoop);
  EXPECT_FALSE(session.timeline.loops);
  const Camera home = session.ShotFor(8, 8).camera;
  session.camera.Orbit(1, 0);
  EXPECT_NE(session.ShotFor(8, 8).camera.rotation, home.rotation);
  session.Do(Action::kResetView);
  EXPECT_EQ(session.ShotFor(8, 8).camera.rotation, home.rotation);
  session.Do(Action::kTogglePlay);  // nothing to play
  EXPECT_EQ(session.driver, Driver::kSliders);
}

TEST(Session, ScenesHaveNoMeshAndNoFace) {
  Session session(SmallScene());
  EXPECT_FALSE(session.is_avatar());
  EXPECT_EQ(session.gaussian_count(), 300u);
  session.Do(Action::kViewTriangles);
  EXPECT_EQ(session.view(), View::kSplats);
  session.Do(Action::kRandomFace);
  EXPECT_TRUE(session.ShotFor(8, 8).face.expression.empty());
}

TEST(Session, ViewsHaveNames) {
  EXPECT_EQ(viewer::ViewFromString("wire", "--view"), View::kWire);
  ExpectError([] { viewer::ViewFromString("mesh", "--view"); }, {"--view", "'mesh'", "ellipsoids"});
}

TEST(KeyBindings, NoKeyAndNoActionTwice) {
  const auto& bindings = viewer::KeyBindings();
  for (size_t i = 0; i < bindings.size(); ++i)
    for (size_t k = 0; k < i; ++k) {
      EXPECT_NE(bindings[i].key, bindings[k].key);
      EXPECT_NE(bindings[i].action, bindings[k].action);
    }
}

TEST(Detail, FullAtRestAndAsFineAsKeepsUpOtherwise) {
  Detail detail;
  EXPECT_EQ(detail.Divisor(true), 1);  // nothing is known yet
  detail.Drawn(1, 20);
  EXPECT_EQ(detail.Divisor(true), 1);
  detail.Drawn(1, 90);
  EXPECT_EQ(detail.Divisor(true), 2);
  EXPECT_EQ(detail.Divisor(false), 1);
  detail.Drawn(2, 60);
  EXPECT_EQ(detail.Divisor(true), 4);
  detail.Drawn(4, 500);  // no coarser than that
  EXPECT_EQ(detail.Divisor(true), 4);
  detail.Drawn(1, 30);
  EXPECT_EQ(detail.Divisor(true), 1);
}

TEST(TimeHistory, KeepsTheLastOnes) {
  viewer::TimeHistory history;
  EXPECT_EQ(history.Median(), 0);
  for (int i = 1; i <= 400; ++i) history.Add(float(i));
  EXPECT_EQ(history.Values().size(), viewer::TimeHistory::kLength);
  EXPECT_EQ(history.Values().back(), 400);
  EXPECT_EQ(history.Values().front(), 251);
  EXPECT_EQ(history.Median(), 326);
}

}  // namespace
}  // namespace cosplat::test
