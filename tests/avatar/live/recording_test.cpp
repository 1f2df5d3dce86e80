#include "avatar/live/recording.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "avatar/model/avatar_mesh.h"
#include "flame/io/landmarks.h"
#include "splat/base/npz.h"
#include "tests/flame/metrical_fixture.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::TemporaryFolder;

constexpr int64_t kSecond = 1'000'000'000;

// A driving sequence whose frame i has expression (i, 2 i) and a root that turns about y.
struct Sequence {
  TemporaryFolder folder;
  std::vector<float> expression, rotation, translation;

  explicit Sequence(int count = 5) {
    for (int i = 0; i < count; ++i) {
      expression.insert(expression.end(), {float(i), 2.0f * float(i)});
      rotation.insert(rotation.end(), {0, 0.1f * float(i), 0});
      translation.insert(translation.end(), {0, 0.01f * float(i), 3});
    }
  }

  std::string Write(float frames_per_second = 0) const {
    const size_t count = expression.size() / 2;
    Npz npz(folder / "talk.npz");
    npz.Add("expr", {count, 2}, expression);
    npz.Add("rot", {count, 3}, rotation);
    npz.Add("tra", {count, 3}, translation);
    if (frames_per_second != 0) npz.Add("fps", {}, std::vector<float>{frames_per_second});
    npz.Write(npz.path());
    return npz.path();
  }
};

// Numbers of the frames that polls at these times give; -1: none.
std::vector<int> FramesAt(LiveSource& source, const std::vector<int64_t>& times) {
  std::vector<int> numbers;
  LiveFrame frame;
  for (const int64_t time : times)
    numbers.push_back(source.Poll(time, frame) ? int(frame.params.expression[0]) : -1);
  return numbers;
}

// Frame i's jawOpen is i / 10; frame 2 has no face.
std::string WriteScores(const TemporaryFolder& folder) {
  LandmarkVideo video;
  video.width = video.height = 100;
  video.frames_per_second = 20;
  video.set = LandmarkSet::kIbug68;
  for (int i = 0; i < 5; ++i) {
    LandmarkFrame& frame = video.frames.emplace_back();
    frame.name = std::to_string(i);
    frame.frame = i;
    if (i == 2) continue;
    DetectedFace& small = frame.faces.emplace_back();
    small.points.assign(68, {50, 50});
    small.blendshapes["jawOpen"] = 1;
    frame.faces.push_back(small);
    frame.faces[1].points[0] = {50, 80};
    frame.faces[1].blendshapes["jawOpen"] = 0.1f * float(i);
  }
  WriteLandmarks(folder / "marks.json", video);
  return folder / "marks.json";
}

TEST(Recording, OfBlendshapeScoresMovesTheFaceByTheMap) {
  const TemporaryFolder folder;
  LiveSourceOptions options;
  options.rest.translation = {0, 0, 3};
  const Recording general = LoadRecording(WriteScores(folder), options);
  EXPECT_EQ(general.frames_per_second, 20);
  ASSERT_EQ(general.frames.size(), 4u);
  EXPECT_EQ(general.frames[2].timestep, 3);
  EXPECT_FLOAT_EQ(general.frames[2].params.pose[2][0], 0.15f);  // of the larger face
  EXPECT_EQ(general.frames[2].params.translation[2], 3);
  BlendshapeMap map = GeneralBlendshapeMap(nullptr);
  for (float& x : map.matrix) x *= 2;
  options.blendshapes = &map;
  EXPECT_FLOAT_EQ(LoadRecording(folder / "marks.json", options).frames[2].params.pose[2][0], 0.3f);
}

TEST(Recording, LandmarksWithoutScoresDriveNothing) {
  const TemporaryFolder folder;
  LandmarkVideo video = ReadLandmarks(WriteScores(folder));
  for (LandmarkFrame& frame : video.frames)
    for (DetectedFace& face : frame.faces) face.blendshapes.clear();
  WriteLandmarks(folder / "marks.json", video);
  ExpectError([&] { OpenLiveSource(folder / "marks.json"); },
              {"marks.json", "blendshapes", "no face has any"});
}

TEST(Recording, PlaysAtItsOwnRate) {
  const Sequence sequence;
  const auto source = OpenLiveSource(sequence.Write(10));
  EXPECT_EQ(source->Description(), "recorded sequence talk.npz, 5 frames at 10 per second");
  const int64_t start = 7 * kSecond, step = kSecond / 10;
  EXPECT_EQ(FramesAt(*source,
                     {start,
                      start + step / 2,
                      start + step,
                      start + step,
                      start + 3 * step,
                      start + 2 * step,
                      start + 4 * step,
                      start + 50 * step}),
            (std::vector<int>{0, -1, 1, -1, 3, -1, 4, -1}));
  EXPECT_TRUE(source->Ended());
  EXPECT_EQ(source->Counts().frames, 4u);
  EXPECT_EQ(source->Counts().replaced, 1u);
}

TEST(Recording, NoFrameIsLostToAHostThatRoundsItsTimes) {
  const Sequence sequence(300);
  const auto source = OpenLiveSource(sequence.Write(30));
  LiveFrame frame;
  for (int64_t i = 0; i < 300; ++i) {
    ASSERT_TRUE(source->Poll(i * kSecond / 30, frame)) << i;
    ASSERT_EQ(frame.sequence, uint64_t(i));
    ASSERT_NEAR(double(frame.time_ns), double(i * kSecond / 30), 2);
  }
  EXPECT_TRUE(source->Ended());
}

TEST(Recording, LoopsAndCountsOn) {
  const Sequence sequence(3);
  LiveSourceOptions options;
  options.loop = true;
  options.frames_per_second = 1;
  const auto source = OpenLiveSource(sequence.Write(10), options);
  EXPECT_EQ(FramesAt(*source, {0, kSecond, 2 * kSecond, 3 * kSecond, 7 * kSecond}),
            (std::vector<int>{0, 1, 2, 0, 1}));
  LiveFrame frame;
  EXPECT_TRUE(source->Poll(1'000'000 * kSecond + kSecond / 2, frame));
  EXPECT_EQ(frame.sequence, 1'000'000u);
  EXPECT_EQ(frame.time_ns, 1'000'000 * kSecond);
  EXPECT_FALSE(source->Ended());
}

TEST(Recording, AFrameThatCannotBeUsedLeavesItsTime) {
  Sequence sequence(5);
  sequence.expression[2 * 2] = std::numeric_limits<float>::quiet_NaN();
  const auto source = OpenLiveSource(sequence.Write(1));
  EXPECT_EQ(FramesAt(*source, {0, kSecond, 2 * kSecond, 3 * kSecond, 4 * kSecond}),
            (std::vector<int>{0, 1, -1, 3, 4}));
}

TEST(Recording, SaysWhatDoesNotMove) {
  Sequence sequence(5);
  sequence.expression[2 * 2] = std::numeric_limits<float>::quiet_NaN();
  sequence.expression[2 * 3] = 900;
  const std::string path = sequence.Write();
  std::string said;
  for (const std::string& note : LoadRecording(path, {}).notes) said += note + "\n";
  for (const char* part : {"has no neck_rot, which stays at rest",
                           "has no jaw_rot",
                           "1 of 5 frames cannot be used",
                           "has expressions of up to 900"})
    EXPECT_NE(said.find(path + ": " + part), std::string::npos) << part << "\n" << said;
  EXPECT_EQ(said.find("has no rot"), std::string::npos) << said;
  Npz npz = Npz::Read(path);
  npz.Add("jaw_rot", {5, 3}, std::vector<float>(15, 12.0f));
  npz.Write(path);
  said.clear();
  for (const std::string& note : LoadRecording(path, {}).notes) said += note + "\n";
  EXPECT_NE(said.find("jaw or eyes by 12 radians"), std::string::npos) << said;
  npz.Add("expr", {5, 0}, std::vector<float>{});
  npz.Write(path);
  ExpectError([&] { LoadRecording(path, {}); }, {"expr", "no coefficients"});
}

TEST(Recording, TurnsAboutTheAvatarsRest) {
  const Sequence sequence(3);
  LiveSourceOptions options;
  options.rest.pose[0] = {0, 0.5f, 0};
  options.rest.translation = {1, 0, 0};
  const auto source = OpenLiveSource(sequence.Write(1), options);
  LiveFrame frame;
  ASSERT_TRUE(source->Poll(0, frame));
  EXPECT_NEAR(frame.params.pose[0][1], 0.4f, 1e-6f);  // the mean of 0, 0.1 and 0.2 is 0.1
  EXPECT_NEAR(frame.params.translation[0], 1, 1e-6f);
  EXPECT_NEAR(frame.params.translation[1], -0.01f, 1e-6f);
  EXPECT_NEAR(frame.params.translation[2], 0, 1e-6f);
}

TEST(Recording, ClocksAtTheirLimits) {
  const Sequence sequence(3);
  LiveSourceOptions options;
  options.loop = true;
  const auto source = OpenLiveSource(sequence.Write(10'000), options);
  LiveFrame frame;
  EXPECT_TRUE(source->Poll(std::numeric_limits<int64_t>::min(), frame));
  EXPECT_TRUE(source->Poll(std::numeric_limits<int64_t>::max(), frame));
  EXPECT_FALSE(source->Poll(0, frame));
}

// A tracker that moves the camera: without the model the head would seem to stand still.
TEST(Recording, AFixedHeadIsMovedByTheAvatarsModel) {
  const test::Metrical track;
  const std::string path = track.Write();
  ExpectError([&] { OpenLiveSource(path); }, {path, "the FLAME model is needed"});
  LiveSourceOptions options;
  options.flame = &track.model;
  const Recording recording = LoadRecording(path, options);
  ASSERT_EQ(recording.frames.size(), size_t(test::kHeadFrames));
  std::vector<FlameParams> expected;
  for (int i = 0; i < test::kHeadFrames; ++i) {
    expected.emplace_back();
    for (size_t k = 0; k < 3; ++k) expected.back().pose[0][k] = float(test::HeadAt(i).root[k]);
  }
  expected = Retarget(expected, {});
  for (size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(recording.frames[i].params.eyelids, test::HeadAt(int(i)).eyelids);
    for (size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(recording.frames[i].params.pose[0][k], expected[i].pose[0][k], 1e-5);
  }
}

TEST(Recording, BadDrivesAreNamed) {
  const Sequence sequence;
  ExpectError([] { OpenLiveSource("no/such.npz"); }, {"no/such.npz", "does not exist"});
  ExpectError([&] { OpenLiveSource(sequence.Write(-5)); }, {"talk.npz", "fps", "negative"});
  ExpectError([&] { OpenLiveSource(sequence.Write(1e-20f)); }, {"talk.npz", "frames per second"});
  LiveSourceOptions options;
  options.frames_per_second = std::numeric_limits<double>::infinity();
  ExpectError([&] { OpenLiveSource(sequence.Write(), options); }, {"talk.npz", "inf"});
}

}  // namespace
}  // namespace cosplat
