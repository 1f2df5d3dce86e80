// A head that moves in front of a camera that stands still, with everything that trackers store of
// it, computed in double precision from the definitions alone: no code of flame/ is used but
// Rodrigues' formula and, for the head's own deformation, the poser.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "flame/math/rodrigues.h"
#include "flame/pose.h"
#include "flame/track.h"
#include "tests/flame/all_frames.h"
#include "tests/flame/random_model.h"

namespace cosplat::test {

using math::Mat3;
using math::Vec3;

constexpr int kHeadFrames = 12;
constexpr int kHeadSide = 512;  // px, of the image
constexpr double kHeadFocal = 2400;
constexpr std::array<double, 2> kHeadCenter = {260, 249};

// A random model of a head's size. Shape directions are as many as FLAME's first ones.
inline FlameModel HeadModel() {
  FlameModel model = RandomModel(40, 5, 6, 3);
  for (float& x : model.template_vertices) x *= 0.08f;
  for (auto* directions :
       {&model.shape_directions, &model.expression_directions, &model.pose_directions})
    for (float& x : *directions) x *= 0.08f;
  return model;
}

struct HeadFrame {
  std::vector<float> expression;
  Vec3<double> root, jaw, left_eye, right_eye;  // axis-angle
  Vec3<double> translation;                     // metres, after the root's rotation
  std::array<float, 2> eyelids;
};

inline std::vector<float> HeadShape() { return {0.7f, -0.4f, 0.2f, 0.1f, -0.3f}; }

inline HeadFrame HeadAt(int i) {
  const double a = 0.3 * i;
  HeadFrame frame;
  for (int k = 0; k < 6; ++k) frame.expression.push_back(float(0.6 * std::sin(a + k)));
  frame.root = {0.3 * std::sin(a), 0.5 * std::cos(a), 0.15 * std::sin(2 * a)};
  frame.jaw = {0.2 + 0.1 * std::sin(a), 0.02, -0.01};
  frame.left_eye = {0.1 * std::cos(a), 0.2 * std::sin(a), 0};
  frame.right_eye = {0.1 * std::cos(a), 0.25 * std::sin(a), 0.01};
  frame.translation = {0.02 * std::sin(a), 0.01 * i / kHeadFrames, 0.03 * std::cos(a)};
  frame.eyelids = {float(0.5 + 0.5 * std::sin(a)), float(0.5 + 0.4 * std::cos(a))};
  return frame;
}

// OpenCV's camera in front of the head, at rest: cam_from_world.
inline const Mat3<double> kHeadCameraRotation = {{1, 0, 0, 0, -1, 0, 0, 0, -1}};
inline const Vec3<double> kHeadCameraTranslation = {0.01, -0.02, 1.1};

// The root's joint: regressed after shape and expression.
inline Vec3<double> RootJointOf(const FlameModel& model, const HeadFrame& frame) {
  const size_t rows = 3 * size_t(model.vertex_count);
  Vec3<double> joint{};
  for (size_t v = 0; v < size_t(model.vertex_count); ++v)
    for (size_t i = 0; i < 3; ++i) {
      double x = model.template_vertices[3 * v + i];
      for (size_t k = 0; k < HeadShape().size(); ++k)
        x += double(HeadShape()[k]) * model.shape_directions[k * rows + 3 * v + i];
      for (size_t k = 0; k < frame.expression.size(); ++k)
        x += double(frame.expression[k]) * model.expression_directions[k * rows + 3 * v + i];
      joint[i] += x * model.joint_regressor[v];
    }
  return joint;
}

// Vertices with the root at rest: what trackers that move the camera deform.
inline std::vector<Vec3<double>> RestVertices(const FlameModel& model, const HeadFrame& frame) {
  FlamePoser<double> poser(model, HeadShape());
  FlamePoser<double>::Parameters parameters;
  parameters.expression.assign(frame.expression.begin(), frame.expression.end());
  parameters.pose[2] = {frame.jaw.x, frame.jaw.y, frame.jaw.z};
  parameters.pose[3] = {frame.left_eye.x, frame.left_eye.y, frame.left_eye.z};
  parameters.pose[4] = {frame.right_eye.x, frame.right_eye.y, frame.right_eye.z};
  std::vector<double> flat;
  poser.Forward(parameters, flat);
  std::vector<Vec3<double>> vertices;
  for (size_t i = 0; i < flat.size(); i += 3)
    vertices.push_back({flat[i], flat[i + 1], flat[i + 2]});
  return vertices;
}

// The same vertices in the world: turned about the root's joint, then moved.
inline std::vector<Vec3<double>> WorldVertices(const FlameModel& model, const HeadFrame& frame) {
  const Mat3<double> rotation = flame_math::Rodrigues(frame.root);
  const Vec3<double> joint = RootJointOf(model, frame);
  std::vector<Vec3<double>> vertices = RestVertices(model, frame);
  for (Vec3<double>& v : vertices) {
    v = rotation * (v - joint);
    for (int i = 0; i < 3; ++i) v[i] += joint[i] + frame.translation[i];
  }
  return vertices;
}

// cam_from_head of a tracker that keeps the root at rest: R = C R_root, and
// t = C (J - R_root J + translation) + c.
struct HeadCamera {
  Mat3<double> rotation;
  Vec3<double> translation;
};
inline HeadCamera CameraAboutHead(const FlameModel& model, const HeadFrame& frame) {
  const Mat3<double> rotation = flame_math::Rodrigues(frame.root);
  const Vec3<double> joint = RootJointOf(model, frame);
  const Vec3<double> place = joint - rotation * joint + frame.translation;
  return {kHeadCameraRotation * rotation, kHeadCameraRotation * place + kHeadCameraTranslation};
}

using Pixel = std::array<double, 2>;

// Where the real camera sees the head: the truth that every layout must reproduce.
inline std::vector<Pixel> HeadPixels(const FlameModel& model, int i) {
  std::vector<Pixel> pixels;
  for (const Vec3<double>& v : WorldVertices(model, HeadAt(i))) {
    const Vec3<double> p = kHeadCameraRotation * v + kHeadCameraTranslation;
    pixels.push_back(
        {kHeadFocal * p[0] / p[2] + kHeadCenter[0], kHeadFocal * p[1] / p[2] + kHeadCenter[1]});
  }
  return pixels;
}

// Where a track's camera sees the mesh of its parameters.
inline std::vector<Pixel> TrackPixels(const FlameModel& model,
                                      const std::vector<float>& shape,
                                      const TrackedFrame& frame,
                                      std::vector<Vec3<double>>* in_camera = nullptr) {
  const FlamePoser<double> poser(model, shape);
  std::vector<double> v;
  poser.Forward(FlamePoser<double>::ParametersOf(frame.params), v);
  const Camera& c = frame.camera;
  std::vector<Pixel> pixels;
  for (size_t i = 0; i < v.size(); i += 3) {
    Vec3<double> q;
    for (int r = 0; r < 3; ++r) {
      q[r] = c.translation[r];
      for (int k = 0; k < 3; ++k) q[r] += double(c.rotation[3 * r + k]) * v[i + k];
    }
    EXPECT_GT(q[2], 0);
    if (in_camera) in_camera->push_back(q);
    pixels.push_back({c.fx * q[0] / q[2] + c.cx, c.fy * q[1] / q[2] + c.cy});
  }
  return pixels;
}

inline double LargestDifference(const std::vector<Pixel>& a, const std::vector<Pixel>& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0;
  for (size_t i = 0; i < a.size(); ++i)
    for (int k = 0; k < 2; ++k) largest = std::max(largest, std::abs(a[i][k] - b[i][k]));
  return largest;
}

inline void ExpectSkipped(const TrackedVideo& video,
                          size_t i,
                          const std::string& name,
                          const std::vector<std::string>& words) {
  ASSERT_LT(i, video.skipped.size());
  EXPECT_EQ(video.skipped[i].name, name);
  EXPECT_EQ(video.skipped[i].reason.find('\n'), std::string::npos);
  for (const std::string& word : words)
    EXPECT_NE(video.skipped[i].reason.find(word), std::string::npos)
        << "'" << video.skipped[i].reason << "' lacks '" << word << "'";
}

}  // namespace cosplat::test
