// How far a fit of landmarks is from them.
#include <algorithm>
#include <cmath>

#include "flame/eyelids.h"
#include "flame/fit/fit_landmarks.h"
#include "flame/pose.h"

namespace cosplat {
namespace {

// The mean distance of the model's landmarks from those seen, weighted as in the fit.
void MeasureFrame(const FlamePoser<float>& poser,
                  const LandmarkEmbedding& embedding,
                  const ObservedFace& face,
                  const Camera& camera,
                  FittedFrame& frame) {
  FlameParams params = frame.params;
  EyelidsToExpression(poser.model(), params);
  std::vector<float> vertices;
  poser.Forward(FlamePoser<float>::ParametersOf(params), vertices);
  frame.points.clear();
  double sum = 0, weights = 0;
  for (const EmbeddedLandmark& landmark : embedding) {
    double at[3];
    for (size_t r = 0; r < 3; ++r) {
      at[r] = camera.translation[r];
      for (size_t k = 0; k < 3; ++k)
        for (size_t i = 0; i < 3; ++i)
          at[r] += camera.rotation[3 * r + k] * landmark.barycentric[i] *
                   vertices[3 * size_t(landmark.vertices[i]) + k];
    }
    const double x = camera.cx + camera.fx * at[0] / at[2];
    const double y = camera.cy + camera.fy * at[1] / at[2];
    frame.points.push_back({x, y});
    const auto& seen = face.points[size_t(landmark.landmark)];
    const double weight = face.weights[size_t(landmark.landmark)];
    sum += weight * std::hypot(x - seen[0], y - seen[1]);
    weights += weight;
  }
  frame.error = sum / weights;
  frame.turned = DegreesTurned(frame.params, camera);
}

}  // namespace

void MeasureFit(const FlameModel& model,
                const LandmarkEmbedding& embedding,
                const std::vector<std::optional<ObservedFace>>& faces,
                LandmarkFit& fit) {
  const FlamePoser<float> poser(model, fit.shape, fit.static_offset);
  double sum = 0;
  int count = 0;
  for (size_t f = 0; f < faces.size(); ++f) {
    if (!fit.frames[f]) continue;
    MeasureFrame(poser, embedding, *faces[f], fit.camera, *fit.frames[f]);
    sum += fit.frames[f]->error;
    ++count;
  }
  fit.error = sum / count;
}

}  // namespace cosplat
