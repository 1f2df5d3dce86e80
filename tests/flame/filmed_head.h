// The made head before a camera, for the tests of flame/fit/.
#pragma once

#include <cmath>

#include "assets/head/motion.h"
#include "assets/head/procedural_head.h"
#include "assets/head/video.h"
#include "flame/fit/fit_landmarks.h"
#include "flame/fit/frame_field.h"
#include "flame/pose.h"
#include "splat/base/rng.h"

namespace cosplat::test {

// The made head's frames as a camera and a detector see them. Each point has noise of its own, and
// all of a frame have some in common, as a detector's have.
struct FilmedHead {
  static constexpr int kSize = 320;
  ProceduralHead head = MakeProceduralHeadParts();
  LandmarkEmbedding embedding = MadeHeadLandmarks(head);
  FlamePoser<float> poser{head.model, {}};
  std::vector<procedural::ScriptFrame> script;
  std::vector<std::optional<ObservedFace>> faces;
  std::vector<Image8> images;

  FilmedHead(int frames, double noise, double shift) : script(MakeScript(frames)) {
    for (EmbeddedLandmark& point : embedding) point.looseness = 7.5;  // a detector's
    Rng rng{1};
    for (const procedural::ScriptFrame& frame : script) {
      std::vector<float> vertices;
      poser.Forward(FlamePoser<float>::ParametersOf(frame.params), vertices);
      images.push_back(RenderProceduralHead(head, vertices, frame.params, frame.camera));
      ObservedFace face;
      const double left = shift * rng.Normal(), down = shift * rng.Normal();
      for (const EmbeddedLandmark& point : embedding) {
        const auto [x, y] = Project(frame.camera, &vertices[3 * size_t(point.vertices[0])]);
        const double dx = noise * rng.Normal(), dy = noise * rng.Normal();
        face.points.push_back({x + left + dx, y + down + dy});
      }
      face.weights.assign(face.points.size(), 1);
      face.size = 125;
      face.follows = !faces.empty();
      faces.push_back(face);
    }
  }
  static std::vector<procedural::ScriptFrame> MakeScript(int frames) {
    // The beginning of a longer one, at its speed.
    auto script = procedural::MakeScript({120, 20, kSize, 0});
    script.resize(size_t(frames));
    return script;
  }
  static std::array<double, 2> Project(const Camera& c, const float* v) {
    std::array<double, 3> p;
    for (int r = 0; r < 3; ++r)
      p[r] = c.rotation[3 * r] * v[0] + c.rotation[3 * r + 1] * v[1] +
             c.rotation[3 * r + 2] * v[2] + c.translation[r];
    return {c.fx * p[0] / p[2] + c.cx, c.fy * p[1] / p[2] + c.cy};
  }
  LandmarkFit Fit(bool with_images) const {
    LandmarkFitOptions options;
    options.focal = script[0].camera.fx;
    if (with_images) options.image = [&](size_t f) { return images[f]; };
    return FitLandmarks(head.model, embedding, faces, kSize, kSize, options);
  }
  // The true numbers of PointsOnFlame, and how the camera sees them.
  std::vector<double> Numbers(size_t f) const {
    const FlameParams& params = script[f].params;
    std::vector<double> numbers(params.translation.begin(), params.translation.end());
    for (const auto& joint : params.pose) numbers.insert(numbers.end(), joint.begin(), joint.end());
    numbers.insert(numbers.end(), params.expression.begin(), params.expression.end());
    numbers.resize(size_t(kFitExpression + head.model.expression_count));
    return numbers;
  }
  internal::FrameView View(size_t f) const {
    const Camera& camera = script[f].camera;
    internal::FrameView view;
    view.lens = {camera.cx, camera.cy};
    view.box = {0, 0, kSize, kSize};
    view.face_size = 125;
    for (size_t r = 0; r < 3; ++r) {
      const double sign = r == 0 ? 1 : -1;  // from OpenCV's axes to OpenGL's
      view.translation[r] = sign * camera.translation[r];
      for (size_t k = 0; k < 3; ++k) view.rotation[3 * r + k] = sign * camera.rotation[3 * r + k];
    }
    return view;
  }
  double LogFocal() const { return std::log(double(script[0].camera.fx)); }
  // Mean distance of the embedded points from where they are, px.
  double Error(const LandmarkFit& fit) const {
    double sum = 0;
    for (size_t f = 0; f < script.size(); ++f) {
      std::vector<float> vertices;
      poser.Forward(FlamePoser<float>::ParametersOf(script[f].params), vertices);
      for (size_t p = 0; p < embedding.size(); ++p) {
        const auto [x, y] =
            Project(script[f].camera, &vertices[3 * size_t(embedding[p].vertices[0])]);
        const auto& found = fit.frames[f]->points[p];
        sum += std::hypot(found[0] - x, found[1] - y) / double(embedding.size());
      }
    }
    return sum / double(script.size());
  }
};

}  // namespace cosplat::test
