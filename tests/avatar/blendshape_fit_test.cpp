// The map from blendshape scores to a head's parameters: what is fitted, what is said of frames not
// seen, and how an avatar is driven by it over VMC.
#include "avatar/train/blendshape_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "avatar/io/avatar_file.h"
#include "avatar/live/source.h"
#include "avatar/live/udp_socket.h"
#include "avatar/live/vmc_frame.h"
#include "flame/eyelids.h"
#include "tests/avatar/live/osc_builder.h"
#include "tests/avatar/meshes.h"
#include "tests/avatar/training_fixture.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_gaussians.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

// Tracked expressions are this uncertain, in FLAME's units and in radians.
constexpr float kExpressionNoise = 0.05f, kTurnNoise = 0.005f;

const std::vector<std::string> kScoreNames = {"jawOpen",
                                              "eyeBlinkLeft",
                                              "eyeBlinkRight",
                                              "eyeLookOutLeft",
                                              "mouthSmileLeft",
                                              "mouthSmileRight",
                                              "browInnerUp",
                                              "mouthPucker",
                                              "cheekPuff",
                                              "eyeLookUpLeft"};

const FlameModel& LiddedHead() {
  static const FlameModel model = WithEyelids(MadeHead().model);
  return model;
}

// A subject who talks, blinks and looks around: scores that change slowly, and faces that are
// linear in them but for the noise of a track. cheekPuff and eyeLookUpLeft do not vary.
struct Performance {
  BlendshapeSamples samples;

  explicit Performance(size_t frames, uint64_t seed, float noise = 1) {
    Rng rng{seed};
    samples.names = kScoreNames;
    std::vector<double> phase;
    for (size_t c = 0; c < kScoreNames.size(); ++c) phase.push_back(6 * rng.Uniform());
    for (size_t i = 0; i < frames; ++i) {
      std::vector<float>& scores = samples.scores.emplace_back();
      for (size_t c = 0; c < kScoreNames.size(); ++c)
        scores.push_back(
            c >= 8 ? 0.2f : float(0.4 + 0.4 * std::sin(phase[c] + 0.11 * double(i * (c + 2)))));
      samples.faces.push_back(FaceOf(scores));
      AddNoise(noise, rng, samples.faces.back());
      samples.frames.push_back(i);
    }
  }

  static FlameParams FaceOf(const std::vector<float>& s) {
    FlameParams face;
    face.expression.assign(size_t(LiddedHead().expression_count), 0.0f);
    face.expression[size_t(Expression::kSmileLeft)] = s[4];
    face.expression[size_t(Expression::kSmileRight)] = s[5] + 0.2f * s[4];
    face.expression[size_t(Expression::kBrowUp)] = 1.5f * s[6] - 0.3f;
    face.expression[size_t(Expression::kPucker)] = s[7];
    *(face.expression.end() - 2) = 0.9f * s[1];
    *(face.expression.end() - 1) = 0.9f * s[2];
    face.pose[2][0] = 0.3f * s[0] + 0.02f;
    face.pose[3][1] = face.pose[4][1] = 0.3f * s[3];
    return face;
  }

  static void AddNoise(float noise, Rng& rng, FlameParams& face) {
    for (float& x : face.expression) x += noise * kExpressionNoise * rng.Normal();
    for (size_t j = 2; j < kFlameJoints; ++j)
      for (float& x : face.pose[j]) x += noise * kTurnNoise * rng.Normal();
    face.pose[0] = {0.1f * rng.Normal(), 0, 0};  // the head's own pose is not the scores'
  }
};

const FlamePoser<float>& HeadPoser() {
  static const FlamePoser<float> poser(LiddedHead(), {});
  return poser;
}

FlameParams Driven(const BlendshapeMap& map, const std::vector<float>& scores) {
  BlendshapeScores named;
  for (size_t c = 0; c < scores.size(); ++c) named[kScoreNames[c]] = scores[c];
  FlameParams face;
  ApplyBlendshapes(map, named, face);
  return face;
}

TEST(BlendshapeFit, FindsALinearRelationThroughNoise) {
  const BlendshapeFit fit = FitBlendshapes(HeadPoser(), Performance(150, 1).samples);
  EXPECT_EQ(fit.varying, 8u);
  const Performance unseen(60, 2, 0);  // without noise: the truth
  double expression = 0, turn = 0;
  for (size_t i = 0; i < 60; ++i) {
    const FlameParams& truth = unseen.samples.faces[i];
    const FlameParams face = Driven(fit.map, unseen.samples.scores[i]);
    ASSERT_EQ(face.expression.size(), truth.expression.size());
    for (size_t e = 0; e < face.expression.size(); ++e)
      expression = std::max(expression, double(std::abs(face.expression[e] - truth.expression[e])));
    for (size_t j = 2; j < kFlameJoints; ++j)
      for (size_t k = 0; k < 3; ++k)
        turn = std::max(turn, double(std::abs(face.pose[j][k] - truth.pose[j][k])));
  }
  EXPECT_LT(expression, kExpressionNoise);  // 150 frames average the noise
  EXPECT_LT(turn, kTurnNoise);
}

TEST(BlendshapeFit, WhatItSaysOfHeldOutFramesHoldsOnOthers) {
  const Performance seen(150, 1), unseen(100, 2);
  const BlendshapeFit fit = FitBlendshapes(HeadPoser(), seen.samples);
  const BlendshapeFitFigures others = MeasureBlendshapes(HeadPoser(), fit, unseen.samples);
  EXPECT_EQ(fit.map.fit.frames, 150);
  EXPECT_GT(fit.map.fit.r2, 0.9f);
  EXPECT_LT(fit.map.fit.error, 0.5f * fit.map.fit.mean_face_error);
  EXPECT_NEAR(others.r2, fit.map.fit.r2, 0.05f);
  EXPECT_NEAR(others.error, fit.map.fit.error, 0.15f * fit.map.fit.error);
}

TEST(BlendshapeFit, ScoresThatSayNothingAreSaidToSayNothing) {
  Performance performance(120, 1);
  const Performance another(120, 7);
  performance.samples.scores = another.samples.scores;
  // Of scores at random phases, slow ones agree by chance: the ridge must be strong.
  const BlendshapeFit fit = FitBlendshapes(HeadPoser(), performance.samples);
  EXPECT_LT(fit.map.fit.r2, 0.3f);
  EXPECT_GE(fit.strength, 0.1);
}

TEST(BlendshapeFit, ScoresThatDoNotVaryDoWhatTheyDoOnAnyHead) {
  const BlendshapeFit fit = FitBlendshapes(HeadPoser(), Performance(60, 1).samples);
  EXPECT_EQ(FindBlendshape(fit.map, "cheekPuff"), -1);
  std::vector<float> scores(kScoreNames.size(), 0.2f);
  const FlameParams rest = Driven(fit.map, scores);
  scores[8] = 0.9f;  // cheekPuff
  EXPECT_EQ(Driven(fit.map, scores).expression, rest.expression);
  scores[9] = 0.9f;  // eyeLookUpLeft: as in GeneralBlendshapeMap
  EXPECT_NEAR(Driven(fit.map, scores).pose[3][0], rest.pose[3][0] - 0.3f * 0.7f, 1e-5f);
  EXPECT_EQ(ProblemOf(fit.map), "");
}

// A track whose jaw opens with the eyes' lids, by chance or by a mistake.
TEST(BlendshapeFit, JawAndEyesTurnByTheirOwnScores) {
  Performance performance(60, 1);
  for (size_t i = 0; i < 60; ++i)
    performance.samples.faces[i].pose[2][0] += 0.2f * performance.samples.scores[i][1];
  const BlendshapeFit fit = FitBlendshapes(HeadPoser(), performance.samples);
  std::vector<float> scores(kScoreNames.size(), 0.4f);
  const FlameParams rest = Driven(fit.map, scores);
  scores[1] = scores[2] = scores[3] = scores[6] = 0.8f;  // eyes and brows
  const FlameParams looks = Driven(fit.map, scores);
  EXPECT_NEAR(looks.pose[2][0], rest.pose[2][0], 1e-6f);
  EXPECT_NEAR(looks.pose[3][1], rest.pose[3][1] + 0.3f * 0.4f, 0.02f);
  scores[0] = scores[4] = scores[5] = scores[7] = 0.8f;  // jaw and mouth
  const FlameParams talks = Driven(fit.map, scores);
  EXPECT_NEAR(talks.pose[3][1], looks.pose[3][1], 1e-6f);
  EXPECT_NEAR(talks.pose[2][0], looks.pose[2][0] + 0.3f * 0.4f, 0.05f);
}

// Other trackers' names say nothing of the part: VRM's beside ARKit's.
TEST(BlendshapeFit, ScoresOfUnknownPartsMayMoveAll) {
  Performance performance(60, 1, 0);
  performance.samples.names[0] = "A";
  performance.samples.names[1] = "Blink_L";
  const BlendshapeFit fit = FitBlendshapes(HeadPoser(), performance.samples);
  BlendshapeScores scores{{"A", 0.4f}, {"Blink_L", 0.4f}};
  FlameParams rest, moved;
  ApplyBlendshapes(fit.map, scores, rest);
  scores["A"] = scores["Blink_L"] = 0.8f;
  ApplyBlendshapes(fit.map, scores, moved);
  EXPECT_NEAR(moved.pose[2][0], rest.pose[2][0] + 0.3f * 0.4f, 0.02f);
  EXPECT_NEAR(*(moved.expression.end() - 2), *(rest.expression.end() - 2) + 0.9f * 0.4f, 0.06f);
}

// A tracker of eyes alone still moves the jaw, as far as they say anything of it.
TEST(BlendshapeFit, WithoutScoresOfItsOwnTheJawFollowsTheOthers) {
  Performance performance(60, 1, 0);
  for (size_t i = 0; i < 60; ++i) {
    std::vector<float>& scores = performance.samples.scores[i];
    for (const size_t mouth : {0, 4, 5, 7}) scores[mouth] = 0.4f;
    performance.samples.faces[i].pose[2][0] = 0.2f * scores[1];
  }
  const BlendshapeFit fit = FitBlendshapes(HeadPoser(), performance.samples);
  std::vector<float> scores(kScoreNames.size(), 0.4f);
  const FlameParams rest = Driven(fit.map, scores);
  scores[1] = 0.8f;  // eyeBlinkLeft
  EXPECT_NEAR(Driven(fit.map, scores).pose[2][0], rest.pose[2][0] + 0.2f * 0.4f, 0.02f);
}

TEST(BlendshapeFit, IsTheSameEachTime) {
  const Performance performance(80, 1);
  const BlendshapeFit a = FitBlendshapes(HeadPoser(), performance.samples),
                      b = FitBlendshapes(HeadPoser(), performance.samples);
  EXPECT_EQ(a.map.matrix, b.map.matrix);
  EXPECT_EQ(a.map.offset, b.map.offset);
  EXPECT_EQ(a.map.fit.error, b.map.fit.error);
}

TEST(BlendshapeFit, TooLittleToFitIsAnError) {
  ExpectError([] { FitBlendshapes(HeadPoser(), Performance(29, 1).samples); },
              {"29 frames", "at least 30"});
  EXPECT_NO_THROW(FitBlendshapes(HeadPoser(), Performance(30, 1).samples));
  Performance still(40, 1);
  for (std::vector<float>& scores : still.samples.scores) scores.assign(scores.size(), 0.5f);
  ExpectError([&] { FitBlendshapes(HeadPoser(), still.samples); }, {"none of them varies"});
}

// Frames "a0", "a1", ... of a head in the middle of the image; the landmarks' images are twice as
// large as the video's.
struct ScoredVideo {
  std::vector<TrackedFrame> frames;
  LandmarkVideo landmarks;

  explicit ScoredVideo(int count) {
    landmarks.file = "marks.json";
    landmarks.width = landmarks.height = 2 * 96;
    landmarks.set = LandmarkSet::kIbug68;
    const std::vector<procedural::ScriptFrame> script = procedural::MakeScript({24, 4, 96, 0});
    for (int i = 0; i < count; ++i) {
      TrackedFrame& frame = frames.emplace_back();
      frame.name = "a" + std::to_string(i);
      frame.camera = script[size_t(i)].camera;
      frame.params = script[size_t(i)].params;
      LandmarkFrame& marks = landmarks.frames.emplace_back();
      marks.name = frame.name;
      marks.frame = i;
      marks.faces = {FaceAt(96, 0.01f * float(i))};
    }
  }

  static DetectedFace FaceAt(double x, float jaw_open) {
    DetectedFace face;
    face.points.assign(68, {x - 30, 60});
    face.points[67] = {x + 30, 130};
    face.blendshapes["jawOpen"] = jaw_open;
    return face;
  }
  BlendshapeSamples Match() const { return MatchScores(landmarks, frames, HeadPoser()); }
};

TEST(BlendshapeSamples, AreTheTrackedFramesWithScoresOnTheHead) {
  ScoredVideo video(8);
  video.landmarks.frames[1].faces.clear();
  video.landmarks.frames[2].faces[0].blendshapes.clear();
  video.landmarks.frames.erase(video.landmarks.frames.begin() + 3);
  // A second face, at the image's edge, in front of the first.
  auto& faces = video.landmarks.frames[3].faces;
  faces.insert(faces.begin(), ScoredVideo::FaceAt(10, 1));
  faces[1].blendshapes["tongueOut"] = 0.5f;
  const BlendshapeSamples samples = video.Match();
  EXPECT_EQ(samples.names, (std::vector<std::string>{"jawOpen", "tongueOut"}));
  EXPECT_EQ(samples.frames, (std::vector<size_t>{0, 4, 5, 6, 7}));
  EXPECT_EQ(samples.scores[1], (std::vector<float>{0.01f * 4, 0.5f}));
  EXPECT_EQ(samples.scores[2], (std::vector<float>{0.01f * 5, 0}));
  EXPECT_EQ(samples.faces[1].expression, video.frames[4].params.expression);
}

TEST(BlendshapeSamples, OfAnotherVideoAreAnError) {
  ScoredVideo renamed(4);
  for (TrackedFrame& frame : renamed.frames) frame.name += "b";
  ExpectError([&] { renamed.Match(); }, {"marks.json", "frames", "'a0'", "'a0b'"});
  ScoredVideo wide(4);
  wide.landmarks.width = 300;
  ExpectError([&] { wide.Match(); }, {"marks.json", "width", "300x192", "96x96"});
  ScoredVideo aside(4);
  for (LandmarkFrame& frame : aside.landmarks.frames)
    for (auto& point : frame.faces[0].points) point[0] -= 100;
  ExpectError([&] { aside.Match(); }, {"marks.json", "4 of 4 faces", "another video"});
}

// Distance between the middles of the upper and the lower half of a loop, metres.
double GapOf(const std::vector<float>& vertices, const std::vector<int>& loop) {
  const size_t a = size_t(loop[loop.size() / 4]), b = size_t(loop[3 * loop.size() / 4]);
  double sum = 0;
  for (size_t k = 0; k < 3; ++k)
    sum += std::pow(double(vertices[3 * a + k]) - vertices[3 * b + k], 2);
  return std::sqrt(sum);
}

struct Gaps {
  std::vector<double> mouth, lid;  // per frame, metres

  void Add(const FlameParams& face) {
    auto parameters = FlamePoser<float>::ParametersOf(face);
    parameters.pose[0] = parameters.pose[1] = {};
    std::vector<float> vertices;
    HeadPoser().Forward(parameters, vertices);
    mouth.push_back(GapOf(vertices, MadeHead().mesh.lip_loop));
    lid.push_back(GapOf(vertices, MadeHead().mesh.lid_loops[0]));
  }
};

double Correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double mean_a = 0, mean_b = 0, aa = 0, bb = 0, ab = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    mean_a += a[i] / double(a.size());
    mean_b += b[i] / double(a.size());
  }
  for (size_t i = 0; i < a.size(); ++i) {
    aa += std::pow(a[i] - mean_a, 2);
    bb += std::pow(b[i] - mean_b, 2);
    ab += (a[i] - mean_a) * (b[i] - mean_b);
  }
  return ab / std::sqrt(aa * bb);
}

double MeanDifference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum / double(a.size());
}

TEST(BlendshapeFit, ScoresSentByVmcMoveTheAvatarAsTheTrackDid) {
  const Performance performance(120, 1), without_noise(120, 1, 0);
  const TemporaryFolder folder;
  AvatarModel avatar = RandomAvatar(SphereMesh(1, 0.1f), 3, 3);
  avatar.gaussians = RandomGaussians(3, 0, Basis::kSh, 4);
  avatar.blendshapes = FitBlendshapes(HeadPoser(), performance.samples).map;
  WriteAvatarGlb(folder / "avatar.glb", avatar, nullptr);
  const AvatarModel read = ReadAvatarGlb(folder / "avatar.glb");
  ASSERT_TRUE(read.blendshapes);
  LiveSourceOptions options;
  options.flame = &LiddedHead();
  options.blendshapes = &*read.blendshapes;
  const auto source = OpenLiveSource("vmc://:0", options);
  UdpSocket sender = UdpSocket::ConnectTo(ParseDriveAddress(AddressOf(*source)));
  Gaps tracked, driven;
  for (size_t i = 0; i < performance.samples.size(); ++i) {
    BlendshapeScores scores;
    for (size_t c = 0; c < kScoreNames.size(); ++c)
      scores[kScoreNames[c]] = performance.samples.scores[i][c];
    ASSERT_TRUE(sender.Send(WriteVmcFrame(scores)));
    LiveFrame frame;
    ASSERT_TRUE(source->Poll(int64_t(i), frame)) << source->Counts().last_problem;
    const FlameParams expected = Driven(*avatar.blendshapes, performance.samples.scores[i]);
    EXPECT_EQ(frame.params.expression, expected.expression);
    EXPECT_EQ(frame.params.pose, expected.pose);
    tracked.Add(without_noise.samples.faces[i]);
    driven.Add(frame.params);
  }
  // Measured: 0.9999 and 0.999, off by 0.09 mm each.
  EXPECT_GT(Correlation(tracked.mouth, driven.mouth), 0.99);
  EXPECT_GT(Correlation(tracked.lid, driven.lid), 0.99);
  EXPECT_LT(MeanDifference(tracked.mouth, driven.mouth), 2e-4);
  EXPECT_LT(MeanDifference(tracked.lid, driven.lid), 2e-4);
}

}  // namespace
}  // namespace cosplat::test
