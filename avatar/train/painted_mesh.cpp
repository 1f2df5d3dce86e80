#include "avatar/train/painted_mesh.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "avatar/math/one_euro.h"
#include "avatar/train/hair_shell.h"
#include "avatar/train/nearby.h"
#include "avatar/train/wide_views.h"
#include "splat/media/signed_distance.h"

namespace cosplat {
namespace {

using math::Vec3;

// A vertex is known from this weight of its best frame on.
constexpr float kKnown = 0.5f;
// In units of HeadRegions. Guesses of the scalp are hair from well within it and above the ears;
// from so far below the eyes on they are of the same height, since collars and necks go around.
constexpr float kHair = 0.2f, kAboveEars = 0.35f, kColorKernel = 0.05f, kBelowEyes = 1;
constexpr float kAcross = 0.25f;    // of a distance that is not along the head's height
constexpr float kOtherSide = 0.1f;  // what a colour from the other side of the head costs
// How much of the alpha the reach of a part leaves out, and the most beyond the face: glasses,
// metres for a scale of 1.
constexpr double kBeyondReach = 0.003;
constexpr float kGlasses = 0.008f;
// The inside of a mouth beside the lips.
constexpr float kDark = 0.2f;

float PixelsPerMetre(const MeshInFrame& shown, const Camera& camera) {
  const size_t count = shown.vertices.size() / 3;
  Vec3<float> center{0, 0, 0};
  for (size_t v = 0; v < count; ++v) center += shown.Vertex(v) * (1 / float(count));
  return camera.fx / std::max(Project(camera, center).depth, camera.near_plane);
}

// Calls visit(pixel, part, px) for each pixel outside of the mesh, with the part of the head that
// is nearest and how far it is.
template <class Visit>
void ForOutside(const std::vector<MeshPixel>& mesh,
                const Faces& faces,
                const std::vector<HeadPart>& parts,
                const Camera& camera,
                const Visit& visit) {
  std::array<Image, kHeadParts> distances;
  tbb::parallel_for(size_t(0), kHeadParts, [&](size_t part) {
    Image8 mask(camera.width, camera.height, 1);
    for (size_t i = 0; i < mesh.size(); ++i)
      if (mesh[i].face >= 0 && parts[size_t(faces[size_t(mesh[i].face)][0])] == HeadPart(part))
        mask.data[i] = 255;
    distances[part] = SignedDistance(mask, 128);
  });
  for (size_t i = 0; i < mesh.size(); ++i) {
    if (mesh[i].face >= 0) continue;
    size_t nearest = 0;
    for (size_t part = 1; part < kHeadParts; ++part)
      if (distances[part].data[i] < distances[nearest].data[i]) nearest = part;
    visit(i, nearest, distances[nearest].data[i]);
  }
}

}  // namespace

PaintedMesh::PaintedMesh(const FlameModel& flame,
                         const CanonicalMesh& mesh,
                         const std::vector<MeshInFrame>& frames,
                         float scale)
    : faces_(mesh.faces),
      mouth_begin_(size_t(flame.own_vertex_count())),
      bowl_begin_(size_t(flame.vertex_count - flame.mouth.bowl)),
      mouth_end_(size_t(flame.vertex_count)),
      scale_(scale),
      regions_(FindHeadRegions(flame, mesh)),
      hair_(FindHairShell(frames, faces_, regions_, scale)) {
  std::vector<MeshInFrame> with_hair;
  for (const MeshInFrame& seen : frames) with_hair.push_back(WithHair(seen));
  LearnColors(with_hair);
  LearnReach(with_hair);
}

BodyInFrame PaintedMesh::BodyIn(const MeshInFrame& seen) const {
  Vec3<float> sum{0, 0, 0};
  float count = 0;
  for (size_t v = 0; v < regions_.head_vertices; ++v) {
    if (regions_.part[v] != HeadPart::kBody) continue;
    sum += seen.Vertex(v);
    ++count;
  }
  return {seen.frame, sum * (1 / std::max(count, 1.0f))};
}

MeshInFrame PaintedMesh::WithHair(const MeshInFrame& seen) const {
  const std::vector<Vec3<float>> normals = NormalsOf(seen.vertices, faces_);
  MeshInFrame moved = seen;
  for (size_t v = 0; v < hair_.size(); ++v)
    for (int k = 0; k < 3; ++k) moved.vertices[3 * v + size_t(k)] += hair_[v] * normals[v][k];
  return moved;
}

Vec3<float> PaintedMesh::ColorIn(const MeshInFrame& seen,
                                 const FrameOnMesh& shown,
                                 const MeshPixel& at) const {
  const std::array<int32_t, 3>& f = faces_[size_t(at.face)];
  const Vec3<float> a = seen.Vertex(size_t(f[0])), b = seen.Vertex(size_t(f[1])),
                    c = seen.Vertex(size_t(f[2]));
  const FrameOnMesh::Sample sample =
      shown.At(a * at.u + b * at.v + c * (1 - at.u - at.v), math::Cross(b - a, c - a));
  return sample.color * sample.weight + ColorAt(at) * (1 - sample.weight);
}

void PaintedMesh::LearnColors(const std::vector<MeshInFrame>& frames) {
  const size_t count = regions_.rest.size();
  colors_.assign(count, {0, 0, 0});
  in_frame_.assign(count, 0);
  std::vector<float> sums(count, 0), best(count, 0);
  for (const MeshInFrame& seen : frames) {
    const FrameOnMesh on_mesh(seen, faces_, scale_);
    const std::vector<Vec3<float>> normals = NormalsOf(seen.vertices, faces_);
    tbb::parallel_for(size_t(0), count, [&](size_t v) {
      const FrameOnMesh::Sample sample = on_mesh.At(seen.Vertex(v), normals[v]);
      const float weight = sample.weight * sample.weight;
      colors_[v] += sample.color * weight;
      sums[v] += weight;
      best[v] = std::max(best[v], sample.weight);
      const Camera& camera = seen.frame->camera;
      const float share = InFrameShare(camera, Project(camera, seen.Vertex(v)), scale_);
      in_frame_[v] = std::max(in_frame_[v], share);
    });
  }
  for (size_t v = 0; v < count; ++v)
    if (sums[v] > 0) colors_[v] = colors_[v] * (1 / sums[v]);
  GuessColors(best);
  PaintMouth(best);
  MeasureGuesses(best);
}

void PaintedMesh::MeasureGuesses(const std::vector<float>& best) {
  double all = 0, guessed = 0;
  for (const std::array<int32_t, 3>& f : faces_) {
    const size_t a = size_t(f[0]), b = size_t(f[1]), c = size_t(f[2]);
    if (regions_.IsBust(a) || regions_.IsBust(b) || regions_.IsBust(c)) continue;
    const std::vector<Vec3<float>>& p = regions_.rest;
    const Vec3<float> across = math::Cross(p[b] - p[a], p[c] - p[a]);
    const double area = std::sqrt(math::Dot(across, across));
    all += area;
    for (const size_t v : {a, b, c}) guessed += best[v] < kKnown ? area / 3 : 0;
  }
  guessed_share_ = all > 0 ? float(guessed / all) : 0;
}

// No light reaches it. What frames show between lips that are nearly shut is teeth or lips, even
// where the mesh has neither.
void PaintedMesh::PaintMouth(const std::vector<float>& best) {
  std::vector<size_t> face;
  for (size_t v = 0; v < mouth_begin_; ++v)
    if (best[v] >= kKnown) face.push_back(v);
  if (face.empty()) return;
  for (size_t v = bowl_begin_; v < mouth_end_; ++v) {
    const auto distance = [&](size_t k) {
      const Vec3<float> d = regions_.rest[v] - regions_.rest[k];
      return std::sqrt(math::Dot(d, d));
    };
    colors_[v] = Nearby(face, colors_, kColorKernel * regions_.unit, distance) * kDark;
  }
}

// Hair from hair, cloth of the bust from the bust, and all else from what is near, on either side.
void PaintedMesh::GuessColors(const std::vector<float>& best) {
  enum Source { kBust, kHairSource, kElse, kSources };
  const size_t count = best.size();
  const auto source = [&](size_t v) {
    return regions_.IsBust(v) ? kBust : regions_.within_scalp[v] > 0 ? kHairSource : kElse;
  };
  std::array<std::vector<size_t>, kSources> known;
  std::vector<size_t> all;
  for (size_t v = 0; v < count; ++v) {
    if (best[v] < kKnown) continue;
    all.push_back(v);
    if (source(v) != kHairSource ||
        (regions_.within_scalp[v] > kHair &&
         regions_.rest[v].y > regions_.eye_height + kAboveEars * regions_.unit))
      known[source(v)].push_back(v);
  }
  if (all.empty()) return;
  for (std::vector<size_t>& of_source : known)
    if (of_source.empty()) of_source = all;
  std::vector<Vec3<float>> guesses(count, Vec3<float>{0, 0, 0});
  tbb::parallel_for(size_t(0), count, [&](size_t v) {
    if (best[v] >= kKnown) return;
    const Vec3<float>& p = regions_.rest[v];
    const float below_eyes = (regions_.eye_height - p.y) / regions_.unit;
    const float across = 1 - (1 - kAcross) * math::Ease(below_eyes - kBelowEyes);
    const auto distance = [&](float x, float y, float z) {
      return std::sqrt(across * across * (x * x + z * z) + y * y);
    };
    guesses[v] = Nearby(known[source(v)], colors_, kColorKernel * regions_.unit, [&](size_t k) {
      const Vec3<float>& q = regions_.rest[k];
      return std::min(distance(q.x - p.x, q.y - p.y, q.z - p.z),
                      distance(q.x + p.x, q.y - p.y, q.z - p.z) + kOtherSide * regions_.unit);
    });
  });
  for (size_t v = 0; v < count; ++v) {
    const float share = math::Ease(best[v] / kKnown);
    colors_[v] = colors_[v] * share + guesses[v] * (1 - share);
  }
}

void PaintedMesh::LearnReach(const std::vector<MeshInFrame>& frames) {
  const float step = 0.001f * scale_;                 // metres
  std::array<std::vector<double>, kHeadParts> alpha;  // by distance, in steps
  double all = 0;
  for (const MeshInFrame& seen : frames) {
    const Camera& camera = seen.frame->camera;
    const float pixels = PixelsPerMetre(seen, camera);
    const std::vector<MeshPixel> mesh = DrawMesh(seen.vertices, faces_, camera);
    for (size_t i = 0; i < mesh.size(); ++i) all += seen.Alpha(i);
    ForOutside(mesh, faces_, regions_.part, camera, [&](size_t i, size_t part, float distance) {
      if (seen.Alpha(i) == 0 || !std::isfinite(distance)) return;
      const size_t k = size_t(std::max(distance, 0.0f) / (pixels * step));
      alpha[part].resize(std::max(alpha[part].size(), k + 1));
      alpha[part][k] += seen.Alpha(i);
    });
  }
  for (size_t part = 0; part < kHeadParts; ++part) {
    size_t steps = alpha[part].size();
    for (double beyond = 0; steps > 0; --steps) {
      beyond += alpha[part][steps - 1];
      if (beyond > kBeyondReach * all) break;
    }
    reach_[part] = float(steps) * step;
  }
  float& of_face = reach_[size_t(HeadPart::kFace)];
  of_face = std::min(of_face, kGlasses * scale_);
}

Image8 PaintedMesh::BeyondMesh(const MeshInFrame& shown,
                               const std::vector<MeshPixel>& mesh,
                               const Camera& camera) const {
  const float pixels = PixelsPerMetre(shown, camera);
  Image8 beyond(camera.width, camera.height, 1);
  ForOutside(mesh, faces_, regions_.part, camera, [&](size_t i, size_t part, float distance) {
    if (distance < reach_[part] * pixels + 1) beyond.data[i] = 255;
  });
  return beyond;
}

}  // namespace cosplat
