#include "flame/io/landmarks.h"

#include <algorithm>
#include <cmath>

#include "assets/head/video.h"
#include "flame/pose.h"
#include "splat/base/npz.h"
#include "splat/base/rng.h"

namespace cosplat {
namespace {

using procedural::Part;
using procedural::Vec;
using procedural::VertexLabel;

constexpr size_t kMadeLandmarks = 107;
constexpr double kFramesPerSecondOfHead = 25;

// The front of the face, of which detectors know points.
bool IsFace(const ProceduralHead& head, const std::vector<Vec>& normals, size_t v) {
  constexpr float kFront = 0.35f;
  return head.mesh.labels[v].part == Part::kSkin && normals[v][2] > kFront;
}

int Frontmost(const ProceduralHead& head, Part part) {
  int front = -1;
  for (size_t v = 0; v < head.mesh.positions.size(); ++v)
    if (head.mesh.labels[v].part == part &&
        (front < 0 || head.mesh.positions[v][2] > head.mesh.positions[size_t(front)][2]))
      front = int(v);
  return front;
}

void AddEvery(size_t stride, const std::vector<int>& loop, std::vector<int>& picked) {
  for (size_t i = 0; i < loop.size(); i += stride) picked.push_back(loop[i]);
}

float SquaredDistance(const Vec& a, const Vec& b) {
  float sum = 0;
  for (int i = 0; i < 3; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

// Each time the vertex of the face that is furthest from all that are picked.
void AddFurthest(const ProceduralHead& head, std::vector<int>& picked) {
  const std::vector<Vec>& positions = head.mesh.positions;
  const std::vector<Vec> normals = procedural::VertexNormals(positions, head.mesh.faces);
  std::vector<float> distance(positions.size(), 1e9f);
  const auto pick = [&](int p) {
    for (size_t v = 0; v < positions.size(); ++v)
      distance[v] = std::min(distance[v], SquaredDistance(positions[v], positions[size_t(p)]));
  };
  for (size_t v = 0; v < positions.size(); ++v)
    if (!IsFace(head, normals, v)) distance[v] = 0;
  for (int p : picked) pick(p);
  while (picked.size() < kMadeLandmarks) {
    picked.push_back(int(std::max_element(distance.begin(), distance.end()) - distance.begin()));
    pick(picked.back());
  }
}

LandmarkFrame SeenBy(const TrackedFrame& frame,
                     const std::vector<float>& vertices,
                     const LandmarkEmbedding& embedding,
                     double noise,
                     Rng& rng) {
  const Camera& c = frame.camera;
  DetectedFace face;
  for (const EmbeddedLandmark& landmark : embedding) {
    const float* v = &vertices[3 * size_t(landmark.vertices[0])];
    double p[3];
    for (int r = 0; r < 3; ++r)
      p[r] = double(c.rotation[3 * r]) * v[0] + double(c.rotation[3 * r + 1]) * v[1] +
             double(c.rotation[3 * r + 2]) * v[2] + c.translation[r];
    const double x = c.fx * p[0] / p[2] + c.cx, y = c.fy * p[1] / p[2] + c.cy;
    const double dx = noise * rng.Normal(), dy = noise * rng.Normal();
    face.points.push_back({x + dx, y + dy});
  }
  return {frame.name, 0, {face}, ""};
}

void WriteEmbedding(const std::string& path,
                    const FlameModel& model,
                    const LandmarkEmbedding& embedding) {
  std::vector<int32_t> indices, faces;
  std::vector<float> barycentric;
  for (const EmbeddedLandmark& landmark : embedding) {
    const int vertex = landmark.vertices[0];
    size_t face = 0, corner = 3;
    for (; face < model.faces.size(); ++face) {
      const auto& f = model.faces[face];
      corner = size_t(std::find(f.begin(), f.end(), vertex) - f.begin());
      if (corner < 3) break;
    }
    indices.push_back(landmark.landmark);
    faces.push_back(int32_t(face));
    for (size_t k = 0; k < 3; ++k) barycentric.push_back(k == corner ? 1.0f : 0.0f);
  }
  Npz npz(path);
  npz.Add("landmark_indices", {indices.size()}, indices);
  npz.Add("lmk_face_idx", {faces.size()}, faces);
  npz.Add("lmk_b_coords", {faces.size(), 3}, barycentric);
  npz.Write(path);
}

}  // namespace

LandmarkEmbedding MadeHeadLandmarks(const ProceduralHead& head) {
  std::vector<int> picked{Frontmost(head, Part::kRightEye), Frontmost(head, Part::kLeftEye)};
  AddEvery(2, head.mesh.lip_loop, picked);
  for (const std::vector<int>& lids : head.mesh.lid_loops) AddEvery(2, lids, picked);
  AddFurthest(head, picked);
  LandmarkEmbedding embedding;
  for (size_t i = 0; i < picked.size(); ++i)
    embedding.push_back({int(i), {picked[i], picked[i], picked[i]}, {1, 0, 0}});
  return embedding;
}

void WriteMadeLandmarks(const std::string& folder,
                        const ProceduralHead& head,
                        const std::vector<TrackedFrame>& frames,
                        const MakeHeadOptions& options) {
  const LandmarkEmbedding embedding = MadeHeadLandmarks(head);
  const FlamePoser<float> poser(head.model, {});
  LandmarkVideo video;
  video.source = folder;
  video.width = video.height = options.size;
  video.frames_per_second = kFramesPerSecondOfHead;
  video.set = LandmarkSet::kOther;
  Rng rng{options.seed};
  for (size_t f = 0; f < frames.size(); ++f) {
    std::vector<float> vertices;
    poser.Forward(FlamePoser<float>::ParametersOf(frames[f].params), vertices);
    video.frames.push_back(SeenBy(frames[f], vertices, embedding, options.landmark_noise, rng));
    video.frames.back().frame = int(f);
    video.frames.back().matte = folder + "/mask/" + frames[f].name + ".png";
  }
  WriteLandmarks(folder + "/landmarks.json", video);
  WriteEmbedding(folder + "/landmark_embedding.npz", head.model, embedding);
}

}  // namespace cosplat
