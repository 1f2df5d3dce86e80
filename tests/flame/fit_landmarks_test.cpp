// flame/fit/: from landmarks to FLAME's parameters.
#include "flame/fit/fit_landmarks.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "assets/head/video.h"
#include "flame/fit/points_on_flame.h"
#include "flame/math/rodrigues.h"
#include "flame/model.h"
#include "flame/pose.h"
#include "splat/base/rng.h"
#include "tests/flame/random_model.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

using test::ExpectError;

constexpr int kSize = 512;

// A face whose every point lies somewhere inside a triangle.
LandmarkEmbedding InsideFaces(const FlameModel& model, int count) {
  Rng rng{5};
  LandmarkEmbedding embedding;
  for (int i = 0; i < count; ++i) {
    const auto& f = model.faces[size_t(rng.Below(model.faces.size()))];
    const double u = rng.Uniform() / 2, v = rng.Uniform() / 2;
    embedding.push_back({i, {f[0], f[1], f[2]}, {1 - u - v, u, v}});
  }
  return embedding;
}

struct RandomFrame {
  FlameModel model = test::RandomModel(40, 5, 6, 3);
  LandmarkEmbedding embedding = InsideFaces(model, 12);
  PointsOnFlame points{model, embedding, 5, 6};
  std::vector<double> shape, frame;

  RandomFrame() {
    Rng rng{9};
    for (int k = 0; k < points.shape_count(); ++k) shape.push_back(rng.Normal());
    for (int k = 0; k < points.frame_size(); ++k) frame.push_back(0.4 * rng.Normal());
  }
  FlamePoser<double>::Parameters Parameters() const {
    FlamePoser<double>::Parameters p;
    std::copy_n(frame.begin(), 3, p.translation.begin());
    for (size_t j = 0; j < kFlameJoints; ++j)
      std::copy_n(frame.begin() + kFitPose + 3 * long(j), 3, p.pose[j].begin());
    p.expression.assign(frame.begin() + kFitExpression, frame.end());
    return p;
  }
};

TEST(PointsOnFlame, LieWhereThePoserPutsThem) {
  const RandomFrame random;
  const std::vector<float> shape(random.shape.begin(), random.shape.end());
  RandomFrame exact = random;
  exact.shape.assign(shape.begin(), shape.end());
  std::vector<double> vertices;
  FlamePoser<double>(random.model, shape).Forward(random.Parameters(), vertices);
  PointsOnFlame::Tape tape;
  random.points.Pose(exact.shape.data(), random.frame.data(), tape);
  for (size_t p = 0; p < random.embedding.size(); ++p)
    for (size_t i = 0; i < 3; ++i) {
      double expected = 0;
      for (size_t k = 0; k < 3; ++k)
        expected += random.embedding[p].barycentric[k] *
                    vertices[3 * size_t(random.embedding[p].vertices[k]) + i];
      EXPECT_NEAR(tape.points[p][i], expected, 1e-9);
    }
}

TEST(PointsOnFlame, DerivativeIsThatOfDifferences) {
  const RandomFrame random;
  const std::array<double, 3> d_point{0.3, -0.7, 0.5};
  const auto value = [&](const std::vector<double>& shape, const std::vector<double>& frame) {
    PointsOnFlame::Tape tape;
    random.points.Pose(shape.data(), frame.data(), tape);
    double sum = 0;
    for (size_t i = 0; i < 3; ++i) sum += d_point[i] * tape.points[7][i];
    return sum;
  };
  PointsOnFlame::Tape tape;
  random.points.Pose(random.shape.data(), random.frame.data(), tape);
  std::vector<double> d_shape(random.shape.size()), d_frame(random.frame.size());
  random.points.Backward(tape, 7, d_point, d_shape.data(), d_frame.data());
  constexpr double kStep = 1e-6;
  for (size_t k = 0; k < d_shape.size(); ++k) {
    auto more = random.shape, less = random.shape;
    more[k] += kStep, less[k] -= kStep;
    EXPECT_NEAR(
        d_shape[k], (value(more, random.frame) - value(less, random.frame)) / (2 * kStep), 1e-7);
  }
  for (size_t k = 0; k < d_frame.size(); ++k) {
    auto more = random.frame, less = random.frame;
    more[k] += kStep, less[k] -= kStep;
    EXPECT_NEAR(
        d_frame[k], (value(random.shape, more) - value(random.shape, less)) / (2 * kStep), 1e-7);
  }
}

TEST(PointsOnFlame, APartOfThemHasOneShape) {
  const RandomFrame random;
  const PointsOnFlame part = random.points.Part({7, 2}, random.shape.data());
  EXPECT_EQ(part.shape_count(), 0);
  ASSERT_EQ(part.point_count(), 2);
  PointsOnFlame::Tape all, tape;
  random.points.Pose(random.shape.data(), random.frame.data(), all);
  part.Pose(nullptr, random.frame.data(), tape);
  const std::array<double, 3> d_point{0.3, -0.7, 0.5};
  std::vector<double> expected(random.frame.size()), d_frame = expected;
  random.points.Backward(all, 7, d_point, nullptr, expected.data());
  part.Backward(tape, 0, d_point, nullptr, d_frame.data());
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(tape.points[0][i], all.points[7][i], 1e-12);
    EXPECT_NEAR(tape.points[1][i], all.points[2][i], 1e-12);
  }
  for (size_t k = 0; k < d_frame.size(); ++k) EXPECT_NEAR(d_frame[k], expected[k], 1e-12);
}

// What a detector sees of the made head, with a pixel of noise, and the truth.
struct SeenHead {
  ProceduralHead head = MakeProceduralHeadParts();
  LandmarkEmbedding embedding = MadeHeadLandmarks(head);
  std::vector<procedural::ScriptFrame> script;
  std::vector<std::optional<ObservedFace>> faces;

  explicit SeenHead(int frames, double noise = 1) {
    script = procedural::MakeScript({frames, frames / 6, kSize, 0});
    const FlamePoser<float> poser(head.model, {});
    Rng rng{1};
    for (const procedural::ScriptFrame& frame : script) {
      std::vector<float> vertices;
      poser.Forward(FlamePoser<float>::ParametersOf(frame.params), vertices);
      faces.push_back(Seen(frame.camera, vertices, noise, rng));
    }
  }

  ObservedFace Seen(const Camera& c, const std::vector<float>& vertices, double noise, Rng& rng) {
    ObservedFace face;
    for (const EmbeddedLandmark& point : embedding) {
      const float* v = &vertices[3 * size_t(point.vertices[0])];
      std::array<double, 3> p;
      for (int r = 0; r < 3; ++r)
        p[r] = c.rotation[3 * r] * v[0] + c.rotation[3 * r + 1] * v[1] +
               c.rotation[3 * r + 2] * v[2] + c.translation[r];
      const double x = noise * rng.Normal(), y = noise * rng.Normal();
      face.points.push_back({c.fx * p[0] / p[2] + c.cx + x, c.fy * p[1] / p[2] + c.cy + y});
    }
    face.weights.assign(face.points.size(), 1);
    face.size = 200;
    face.follows = !faces.empty();
    return face;
  }

  LandmarkFit Fit(const LandmarkFitOptions& options = {}) const {
    return FitLandmarks(head.model, embedding, faces, kSize, kSize, options);
  }
};

// The head's rotation in the camera.
math::Mat3<double> HeadRotation(const FlameParams& params, const Camera& camera) {
  math::Mat3<double> rotation;
  for (size_t i = 0; i < 9; ++i) rotation.m[i] = camera.rotation[i];
  for (size_t j = 0; j < 2; ++j) {
    const auto& w = params.pose[j];
    rotation = rotation * flame_math::Rodrigues(math::Vec3<double>{w[0], w[1], w[2]});
  }
  return rotation;
}

double DegreesBetween(const math::Mat3<double>& a, const math::Mat3<double>& b) {
  double trace = 0;
  for (size_t i = 0; i < 9; ++i) trace += a.m[i] * b.m[i];
  return std::acos(std::clamp((trace - 1) / 2, -1.0, 1.0)) * 180 / M_PI;
}

// The mesh with the head at rest: what shape, expression, jaw and eyes make of it.
std::vector<float> RestMesh(const FlamePoser<float>& poser, FlameParams params) {
  params.pose[0] = params.pose[1] = {};
  params.translation = {};
  std::vector<float> vertices;
  poser.Forward(FlamePoser<float>::ParametersOf(params), vertices);
  return vertices;
}

TEST(FitLandmarks, FindsTheMadeHeadFromNoisyLandmarks) {
  const SeenHead seen(120);
  const LandmarkFit fit = seen.Fit();
  const FlamePoser<float> poser(seen.head.model, {});
  double degrees = 0, worst = 0, distance = 0;
  size_t moved = 0;
  const std::vector<float> rest = RestMesh(poser, {});
  for (size_t f = 0; f < seen.script.size(); ++f) {
    ASSERT_TRUE(fit.frames[f]);
    const double d = DegreesBetween(HeadRotation(fit.frames[f]->params, fit.camera),
                                    HeadRotation(seen.script[f].params, seen.script[f].camera));
    degrees += d / double(seen.script.size());
    worst = std::max(worst, d);
    const std::vector<float> found = RestMesh(poser, fit.frames[f]->params);
    const std::vector<float> truth = RestMesh(poser, seen.script[f].params);
    for (size_t v = 0; v < found.size(); v += 3) {
      const auto apart = [&](const std::vector<float>& other) {
        return std::hypot(
            truth[v] - other[v], truth[v + 1] - other[v + 1], truth[v + 2] - other[v + 2]);
      };
      if (apart(rest) < 1e-3) continue;  // not driven in this frame
      distance += apart(found);
      ++moved;
    }
  }
  distance /= double(moved);
  const double focal_error = std::abs(fit.camera.fx / seen.script[0].camera.fx - 1);
  std::printf(
      "rotation %.3f degrees (largest %.3f), driven vertices %.2f mm, focal %.1f %%, %.2f px\n",
      degrees,
      worst,
      1e3 * distance,
      100 * focal_error,
      fit.error);
  EXPECT_LT(degrees, 0.5);
  EXPECT_LT(worst, 2);
  EXPECT_LT(distance, 0.01 * 0.25);  // of a head 25 cm high
  EXPECT_LT(focal_error, 0.03);
  EXPECT_LT(fit.error, 1.4);
}

// A part of the frames, at half their resolution, gives the same head and lens.
TEST(FitLandmarks, FitsAPartOfTheFrames) {
  SeenHead seen(12);
  const LandmarkFit whole = seen.Fit();
  const FrameCrop crop{{90, 30, 400, 440}, kSize, kSize, 200, 220};
  for (auto& face : seen.faces) {
    for (auto& [x, y] : face->points) x = (x - crop.part.x) / 2, y = (y - crop.part.y) / 2;
    face->size /= 2;
  }
  LandmarkFitOptions options;
  options.crop = crop;
  const LandmarkFit fit =
      FitLandmarks(seen.head.model, seen.embedding, seen.faces, crop.width, crop.height, options);
  const Camera back = crop.WholeCamera(fit.camera);
  EXPECT_NEAR(back.fx / whole.camera.fx, 1, 1e-4);
  EXPECT_NEAR(back.cx, whole.camera.cx, 1e-3);
  EXPECT_NEAR(back.cy, whole.camera.cy, 1e-3);
  for (size_t f = 0; f < seen.faces.size(); ++f)
    for (size_t p = 0; p < seen.embedding.size(); ++p) {
      const auto point = crop.InFrame(fit.frames[f]->points[p]);
      EXPECT_NEAR(point[0], whole.frames[f]->points[p][0], 0.01);
      EXPECT_NEAR(point[1], whole.frames[f]->points[p][1], 0.01);
    }
}

TEST(FitLandmarks, SameBitsForAnyNumberOfThreads) {
  const SeenHead seen(12);
  const auto fit = [&](size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return seen.Fit();
  };
  const LandmarkFit one = fit(1), three = fit(3);
  EXPECT_EQ(one.camera.fx, three.camera.fx);
  EXPECT_EQ(one.shape, three.shape);
  for (size_t f = 0; f < seen.faces.size(); ++f) {
    EXPECT_EQ(one.frames[f]->params.expression, three.frames[f]->params.expression);
    EXPECT_EQ(one.frames[f]->params.pose, three.frames[f]->params.pose);
    EXPECT_EQ(one.frames[f]->params.translation, three.frames[f]->params.translation);
  }
}

TEST(FitLandmarks, KeepsTheFocalLengthThatIsGiven) {
  const SeenHead seen(6);
  LandmarkFitOptions options;
  options.focal = 900;
  EXPECT_FLOAT_EQ(seen.Fit(options).camera.fx, 900);
}

// Single points that a detector puts elsewhere do not move the face.
TEST(FitLandmarks, IsRobustAgainstWrongPoints) {
  SeenHead seen(12, 0.3);
  const LandmarkFit clean = seen.Fit();
  for (std::optional<ObservedFace>& face : seen.faces)
    for (size_t p = 20; p < 26; ++p) face->points[p][0] += 60;
  const LandmarkFit fit = seen.Fit();
  for (size_t f = 0; f < seen.faces.size(); ++f)
    EXPECT_LT(DegreesBetween(HeadRotation(fit.frames[f]->params, fit.camera),
                             HeadRotation(clean.frames[f]->params, clean.camera)),
              3);
}

TEST(FitLandmarks, FramesWithoutAFaceHaveNone) {
  SeenHead seen(8);
  seen.faces[3].reset();
  const LandmarkFit fit = seen.Fit();
  EXPECT_FALSE(fit.frames[3]);
  EXPECT_TRUE(fit.frames[4]);
  for (size_t f = 2; f < seen.faces.size(); ++f) seen.faces[f].reset();
  ExpectError([&] { seen.Fit(); }, {"faces found: 2", "at least 3"});
}

LandmarkFrame FrameOfFaces(int f, const std::vector<std::array<double, 3>>& squares) {
  LandmarkFrame frame{std::to_string(f), f, {}, ""};
  for (const auto& [x, y, side] : squares) {
    DetectedFace face;
    for (int i = 0; i < 68; ++i)
      face.points.push_back({x + side * (i % 2), y + side * (i / 2 % 2)});
    frame.faces.push_back(face);
  }
  return frame;
}

TEST(ChooseFaces, StaysWithTheLargestFaceOfTheStart) {
  LandmarkVideo video;
  video.file = "marks.json";
  video.width = video.height = kSize;
  video.set = LandmarkSet::kIbug68;
  video.frames.push_back(FrameOfFaces(0, {{300, 100, 60}, {100, 100, 100}}));
  // Now the other one is larger, and stands first.
  video.frames.push_back(FrameOfFaces(1, {{290, 100, 120}, {110, 105, 95}}));
  video.frames.push_back(FrameOfFaces(2, {}));
  video.frames.push_back(FrameOfFaces(3, {{120, 105, 95}}));
  // A cut: only a face elsewhere.
  video.frames.push_back(FrameOfFaces(4, {{350, 300, 50}}));
  video.frames.push_back(FrameOfFaces(5, {{351, 300, 50}}));
  const ChosenFaces chosen = ChooseFaces(video);
  const auto left = [&](size_t f) { return chosen.faces[f]->points[0][0]; };
  EXPECT_EQ(left(0), 100);
  EXPECT_EQ(left(1), 110);
  EXPECT_FALSE(chosen.faces[2]);
  EXPECT_EQ(left(3), 120);
  EXPECT_EQ(left(4), 350);
  const bool follows[] = {false, true, false, false, false, true};
  for (size_t f : {0, 1, 3, 4, 5}) EXPECT_EQ(chosen.faces[f]->follows, follows[f]) << f;
  EXPECT_EQ(chosen.cuts, 1);
  ASSERT_EQ(chosen.skipped.size(), 1u);
  EXPECT_EQ(chosen.skipped[0].name, "2");
  for (size_t f = 0; f < 5; ++f) video.frames[f].faces.clear();
  ExpectError([&] { ChooseFaces(video); }, {"marks.json", "has no face"});
}

// Where the landmarks are on the template.
std::map<int, std::array<double, 3>> PlacesOf(const FlameModel& model,
                                              const LandmarkEmbedding& embedding) {
  std::map<int, std::array<double, 3>> places;
  for (const EmbeddedLandmark& landmark : embedding)
    for (size_t k = 0; k < 3; ++k)
      for (size_t i = 0; i < 3; ++i)
        places[landmark.landmark][i] +=
            landmark.barycentric[k] * model.template_vertices[3 * size_t(landmark.vertices[k]) + i];
  return places;
}

TEST(LandmarkEmbedding, NeedsFlamesTopology) {
  const FlameModel made = MakeProceduralHead();
  ExpectError([&] { FlameLandmarks(made, LandmarkSet::kMediapipe478); },
              {made.name, "faces", "--landmark-embedding"});
}

TEST(LandmarkEmbedding, LiesOnTheMadeHeadsFace) {
  const FlameModel made = MakeHeadForPeople();
  const LandmarkEmbedding all = FlameLandmarks(made, LandmarkSet::kMediapipe478);
  EXPECT_EQ(all.size(), FlameLandmarks(made, LandmarkSet::kMediapipe468).size() + 2);
  EXPECT_GE(FlameLandmarks(made, LandmarkSet::kIbug68).size(), 44u);
  auto places = PlacesOf(made, all);
  ASSERT_EQ(places.size(), all.size()) << "a landmark is there twice";
  // Canthi, corners of the mouth, wings of the nose, irises, lids, rims of the lips.
  const std::pair<int, int> pairs[] = {
      {33, 263}, {133, 362}, {61, 291}, {129, 358}, {468, 473}, {159, 386}, {82, 312}, {87, 317}};
  for (const auto& [right, left] : pairs) {
    ASSERT_TRUE(places.count(right) && places.count(left)) << right;
    EXPECT_LT(places[right][0], -0.005) << right;
    EXPECT_NEAR(places[right][0], -places[left][0], 1e-3) << right;
    for (size_t i = 1; i < 3; ++i) EXPECT_NEAR(places[right][i], places[left][i], 1e-3) << right;
  }
  EXPECT_NEAR(places[13][1], places[14][1], 1e-3) << "the lips meet at rest";
  for (const auto& [landmark, at] : places) EXPECT_LE(at[2], places[4][2] + 1e-3) << landmark;
}

// On FLAME itself, where its file is: both sides of the face are where they should be.
TEST(LandmarkEmbedding, LiesOnFlamesFace) {
  const std::string path = COSPLAT_SOURCE_DIR "/../shared/data/tracked/flame_like.pkl";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent";
  const FlameModel flame = LoadFlameModel(path);
  const LandmarkEmbedding all = FlameLandmarks(flame, LandmarkSet::kMediapipe478);
  EXPECT_EQ(all.size(), FlameLandmarks(flame, LandmarkSet::kMediapipe468).size() + 2);
  EXPECT_EQ(FlameLandmarks(flame, LandmarkSet::kIbug68).size(), 49u);
  auto places = PlacesOf(flame, all);
  EXPECT_EQ(places.size(), all.size());  // none twice
  // Outer corners of the eyes, corners of the mouth, pupils: right and left; nose in between.
  for (const auto& [right, left] : {std::pair(33, 263), std::pair(61, 291), std::pair(468, 473)}) {
    EXPECT_LT(places.at(right)[0], -0.01);
    EXPECT_NEAR(places.at(right)[0], -places.at(left)[0], 0.003);
    EXPECT_NEAR(places.at(right)[1], places.at(left)[1], 0.003);
  }
  EXPECT_NEAR(places.at(4)[0], 0, 0.002);
  for (const auto& [landmark, place] : places) EXPECT_GT(place[2], 0) << landmark;
}

}  // namespace
}  // namespace cosplat
