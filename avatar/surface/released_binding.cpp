#include "avatar/math/released_embed.h"
#include "avatar/surface/binding.h"
#include "splat/device/for_each.h"

namespace cosplat {
namespace {

using math::Quat;
using math::Three;
using math::Vec3;
using ReleasedFace = math::ReleasedFace<float>;
using EmbeddedGaussian = math::EmbeddedGaussian<float>;

struct FaceState {
  Quat<float> rotation;  // canonical to posed, with the sign that the conversion gives
  float area, canonical_area;
};

FaceState StateOf(const Surface& surface, size_t face) {
  Vec3<float> rest[3], posed[3];
  for (int c = 0; c < 3; ++c) {
    rest[c] = surface.canonical()[surface.faces()[face][c]].position;
    posed[c] = surface.vertices()[surface.faces()[face][c]].position;
  }
  const auto frame = math::FaceFrame(rest[0], rest[1], rest[2]);
  return {math::FaceRotation(posed[0], posed[1], posed[2], frame),
          math::Length(math::AreaVector(posed[0], posed[1], posed[2])),
          math::Length(math::AreaVector(rest[0], rest[1], rest[2]))};
}

// The release's data of a posed mesh, other than positions and normals.
struct ReleasedSurface {
  std::vector<FaceState> faces;        // [F]
  std::vector<Quat<float>> rotations;  // [V] blended over adjacent faces by canonical area

  explicit ReleasedSurface(const Surface& surface)
      : faces(surface.faces().size()), rotations(surface.vertex_count()) {
    ParallelFor(faces.size(), [&](size_t f) { faces[f] = StateOf(surface, f); });
    ParallelFor(rotations.size(), [&](size_t v) { rotations[v] = RotationAt(surface, v); });
  }

  Quat<float> RotationAt(const Surface& surface, size_t v) const {
    const MeshTopology& topology = surface.topology();
    std::vector<Quat<float>> q;
    std::vector<float> weight;
    float total = 0;
    for (int32_t k = topology.vertex_face_begin[v]; k < topology.vertex_face_begin[v + 1]; ++k) {
      const FaceState& face = faces[topology.vertex_faces[k]];
      q.push_back(face.rotation);
      weight.push_back(face.canonical_area);
      total += face.canonical_area;
    }
    // Scale to a sum of 1, because the floor in Normalize is meant for quaternions of order 1.
    if (total > 0)
      for (float& w : weight) w /= total;
    return math::UnalignedBlend(q.data(), weight.data(), int(q.size()));
  }
};

struct Input {
  Three<SurfaceVertex> corners;
  ReleasedFace face;
  EmbeddedGaussian gaussian;
};

Vec3<float> Vec3At(const Buffer<float>& array, size_t i) {
  return {array[3 * i], array[3 * i + 1], array[3 * i + 2]};
}
Quat<float> QuatAt(const Buffer<float>& array, size_t i) {
  return {array[4 * i], array[4 * i + 1], array[4 * i + 2], array[4 * i + 3]};
}

Input InputOf(const Gaussians& gaussians,
              const Embedding& embedding,
              const Surface& surface,
              const ReleasedSurface& released,
              size_t i) {
  const int32_t triangle = embedding.triangle[i];
  Input in;
  for (int c = 0; c < 3; ++c) {
    const int32_t v = surface.faces()[triangle][c];
    in.corners[c] = surface.vertices()[v];
    in.corners[c].rotation = released.rotations[v];
  }
  const FaceState& face = released.faces[triangle];
  in.face = {face.area, face.canonical_area, embedding.released->unit};
  in.gaussian = {embedding.barycentric[i][0],
                 embedding.barycentric[i][1],
                 Vec3At(gaussians.values[kPosition], i),
                 QuatAt(gaussians.values[kRotation], i),
                 Vec3At(gaussians.values[kScaleLog], i)};
  return in;
}

void Put(const Vec3<float>& v, float* row) {
  row[0] = v.x;
  row[1] = v.y;
  row[2] = v.z;
}
void Put(const Quat<float>& q, float* row) {
  row[0] = q.w;
  row[1] = q.x;
  row[2] = q.y;
  row[3] = q.z;
}

}  // namespace

void BindReleased(const Gaussians& gaussians,
                  const Embedding& embedding,
                  const Surface& surface,
                  PosedGaussians& out) {
  const ReleasedSurface released(surface);
  ParallelFor(gaussians.size(), [&](size_t i) {
    const Input in = InputOf(gaussians, embedding, surface, released, i);
    const auto posed = math::ReleasedEmbed(in.corners, in.face, in.gaussian);
    Put(posed.position, &out.position[3 * i]);
    Put(posed.rotation, &out.rotation[4 * i]);
    Put(posed.scale_log, &out.scale_log[3 * i]);
    Put(posed.frame, &out.frame[4 * i]);
  });
}

void BindReleasedBackward(const Gaussians& gaussians,
                          const Embedding& embedding,
                          const Surface& surface,
                          const PosedGaussians& d_posed,
                          Gaussians& d_gaussians) {
  const ReleasedSurface released(surface);
  ParallelFor(gaussians.size(), [&](size_t i) {
    const Input in = InputOf(gaussians, embedding, surface, released, i);
    const math::PosedGaussian<float> d{Vec3At(d_posed.position, i),
                                       QuatAt(d_posed.rotation, i),
                                       Vec3At(d_posed.scale_log, i),
                                       {0, 0, 0, 0}};
    EmbeddedGaussian d_local;
    math::ReleasedEmbedVjp(in.corners, in.face, in.gaussian, d, d_local);
    Put(d_local.offset, &d_gaussians.values[kPosition][3 * i]);
    Put(d_local.rotation, &d_gaussians.values[kRotation][4 * i]);
    Put(d_local.scale_log, &d_gaussians.values[kScaleLog][3 * i]);
  });
}

}  // namespace cosplat
