// Facts about FLAME on the real files, where they are at hand (they may not be redistributed).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "flame/model.h"
#include "flame/pose.h"
#include "flame/topology.h"
#include "splat/base/json.h"

namespace cosplat::test {
namespace {

const std::string kTracked = COSPLAT_SOURCE_DIR "/../shared/data/tracked/";

class RealFlame : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kTracked + "flame_like.pkl"))
      GTEST_SKIP() << "no " << kTracked << ": licensed data, not part of the project";
  }
};

TEST_F(RealFlame, PickleAndNpzPoseTheSameMesh) {
  const FlameModel a = LoadFlameModel(kTracked + "flame_like.pkl");
  const FlameModel b = LoadFlameModel(kTracked + "flame_for_tracks.npz");
  for (const FlameModel* m : {&a, &b}) {
    EXPECT_EQ(m->vertex_count, 5023);
    EXPECT_EQ(m->faces.size(), 9976u);
    EXPECT_EQ(m->shape_count, 60);
    EXPECT_EQ(m->expression_count, 50);
    EXPECT_EQ(m->parents, (std::array<int, kFlameJoints>{-1, 0, 1, 1, 1}));
    EXPECT_FALSE(m->redistributable);
  }
  FlamePoser<float>::Parameters frame;
  frame.expression = {1, -2, 0.5f};
  frame.pose = {{{0.1f, 0.4f, 0}, {0, 0, 0.2f}, {0.3f, 0, 0}, {0, 0.1f, 0}, {0, 0.1f, 0}}};
  std::vector<float> va, vb;
  FlamePoser<float>(a, {1, 0, -1}).Forward(frame, va);
  FlamePoser<float>(b, {1, 0, -1}).Forward(frame, vb);
  float worst = 0;
  for (size_t i = 0; i < va.size(); ++i) worst = std::max(worst, std::abs(va[i] - vb[i]));
  // Both hold the same float32 numbers, apart from the regressor's rounding: 0.1 micrometres.
  EXPECT_LT(worst, 1e-7f);
}

TEST_F(RealFlame, ThreePartsAndTwoOpenings) {
  const FlameModel model = LoadFlameModel(kTracked + "flame_for_tracks.npz");
  const MeshTopology t = BuildTopology(model.name, model.faces, model.vertex_count);
  std::vector<int> counts(t.component_count);
  for (int c : t.face_component) ++counts[c];
  std::sort(counts.begin(), counts.end());
  EXPECT_EQ(counts, (std::vector<int>{1088, 1088, 7800}));
  std::vector<size_t> loops;
  for (const auto& loop : t.boundary_loops) loops.push_back(loop.size());
  std::sort(loops.begin(), loops.end());
  EXPECT_EQ(loops, (std::vector<size_t>{30, 32}));  // neck, mouth
}

// Pixels of every vertex in a frame of the IMavatar layout (intrinsics in units of the image,
// OpenGL camera, mesh enlarged four times).
struct Projection {
  std::vector<std::array<double, 3>> pixels;  // x, y, depth
};

Projection Project(const JsonField& track, const JsonField& frame, const FlamePoser<float>& poser) {
  FlameParams params;
  params.expression = frame["expression"].Numbers();
  const auto pose = frame["pose"].Numbers(15);
  for (int j = 0; j < kFlameJoints; ++j)
    for (int i = 0; i < 3; ++i) params.pose[j][i] = pose[3 * j + i];
  std::vector<float> v;
  poser.Forward(FlamePoser<float>::ParametersOf(params), v);
  const auto k = track["intrinsics"].Numbers(4);
  const auto m = frame["world_mat"].Numbers(12);
  Projection out;
  for (size_t i = 0; i < v.size(); i += 3) {
    std::array<double, 3> p{};
    for (int r = 0; r < 3; ++r) {
      p[r] = m[4 * r + 3] / 4;
      for (int c = 0; c < 3; ++c) p[r] += m[4 * r + c] * v[i + c];
    }
    const double depth = -p[2];
    out.pixels.push_back(
        {512 * (std::abs(k[0]) * p[0] / depth + k[2]), 512 * (-k[1] * p[1] / depth + k[3]), depth});
  }
  return out;
}

// A point of the surface: face and weights of its corners.
struct Landmark {
  std::array<int32_t, 3> corners{};
  std::array<double, 3> weights{};
  double depth = INFINITY;
};

// The front-most surface point under a pixel.
Landmark Pick(const FlameModel& model, const Projection& projection, double x, double y) {
  Landmark best;
  for (const auto& face : model.faces) {
    const auto& a = projection.pixels[face[0]];
    const auto& b = projection.pixels[face[1]];
    const auto& c = projection.pixels[face[2]];
    const double area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    const double wb = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (y - a[1])) / area;
    const double wc = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / area;
    const double wa = 1 - wb - wc;
    const double depth = wa * a[2] + wb * b[2] + wc * c[2];
    if (wa >= 0 && wb >= 0 && wc >= 0 && depth < best.depth) best = {face, {wa, wb, wc}, depth};
  }
  return best;
}

// The track's own keypoints say where the surface lies in each image. Those picked on the mesh in
// the first frame are found again in the others, through other poses and expressions.
TEST_F(RealFlame, KeypointsPickedInOneFrameAreFoundInOthers) {
  const FlameModel model = LoadFlameModel(kTracked + "flame_for_tracks.npz");
  const std::string path = kTracked + "wojtek_imavatar/flame_params.json";
  const Json json = ReadJson(path);
  const JsonField track(path, json);
  std::vector<float> shape = track["shape_params"].Numbers();
  const FlamePoser<float> poser(model, shape);
  const JsonField frames = track["frames"];
  const auto keypoint = [&](size_t f, size_t i) {
    const auto k = frames[f]["flame_keypoints"][i].Numbers(2);
    return std::array<double, 2>{(k[0] + 1) * 256, (k[1] + 1) * 256};
  };
  const size_t count = frames[0]["flame_keypoints"].size();
  const Projection first = Project(track, frames[0], poser);
  std::vector<Landmark> landmarks;
  for (size_t i = 0; i < count; ++i)
    landmarks.push_back(Pick(model, first, keypoint(0, i)[0], keypoint(0, i)[1]));
  std::vector<double> errors;
  for (size_t f = 20; f < frames.size(); f += 20) {
    const Projection p = Project(track, frames[f], poser);
    for (size_t i = 0; i < count; ++i) {
      if (!std::isfinite(landmarks[i].depth)) continue;
      double x = 0, y = 0;
      for (int k = 0; k < 3; ++k) {
        x += landmarks[i].weights[k] * p.pixels[landmarks[i].corners[k]][0];
        y += landmarks[i].weights[k] * p.pixels[landmarks[i].corners[k]][1];
      }
      errors.push_back(std::hypot(x - keypoint(f, i)[0], y - keypoint(f, i)[1]));
    }
  }
  ASSERT_GT(errors.size(), 400u);
  std::sort(errors.begin(), errors.end());
  // Half of them to a hundredth of a pixel (3.5e-4 measured): the conventions are those of the
  // track. The rest were picked on a surface in front of theirs (lids, lips, the far cheek).
  EXPECT_LT(errors[errors.size() / 2], 0.01);
}

}  // namespace
}  // namespace cosplat::test
