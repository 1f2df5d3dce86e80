// Embedding of Gaussians on the posed surface and its derivative, one Gaussian per row. The CPU
// runs these kernels on SIMD packs (avatar/surface/packs.cpp), a device with one thread per row
// (avatar/surface/cuda/kernels.cu). Formulas: avatar/math/embed.h and rigid_embed.h.
#if defined(COSPLAT_AVATAR_KERNELS_EMBED_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_AVATAR_KERNELS_EMBED_H_
#undef COSPLAT_AVATAR_KERNELS_EMBED_H_
#else
#define COSPLAT_AVATAR_KERNELS_EMBED_H_
#endif

#include "avatar/math/correct.h"
#include "avatar/math/embed.h"
#include "avatar/math/light.h"
#include "avatar/math/rigid_embed.h"
#include "avatar/surface/kernels/arrays.h"
#include "avatar/surface/kernels/gather.h"

COSPLAT_MATH_BEGIN

template <class T>
COSPLAT_HD_FORCED LaneRows<T> FacesOf(const EmbeddedArrays& gaussians, const Rows& rows) {
  return RowPerLane<T>(rows, [&](size_t i) { return gaussians.triangle[i]; });
}
// Vertex c of each face.
template <class T>
COSPLAT_HD_FORCED LaneRows<T> CornersOf(const EmbeddedArrays& gaussians,
                                        const LaneRows<T>& faces,
                                        int c) {
  LaneRows<T> corner;
  for (size_t l = 0; l < kLaneCount<T>; ++l) corner[l] = gaussians.faces[3 * size_t(faces[l]) + c];
  return corner;
}

// The arguments of Embed.
template <class T>
struct EmbedInput {
  Three<SurfaceVertex<T>> vertices;
  Three<T> canonical_area;
  EmbeddedGaussian<T> gaussian;
};

template <class T>
COSPLAT_HD_FORCED EmbedInput<T> LoadEmbedInput(const EmbeddedArrays& gaussians, const Rows& rows) {
  EmbedInput<T> in;
  const LaneRows<T> faces = FacesOf<T>(gaussians, rows);
  for (int c = 0; c < 3; ++c) {
    const LaneRows<T> corner = CornersOf<T>(gaussians, faces, c);
    T v[kSurfaceVertexFloats];
    GatherRows<kSurfaceVertexFloats>(gaussians.vertices, kSurfaceVertexFloats, corner, v);
    in.vertices[c] = SurfaceVertexOf(v);
  }
  T area[4];
  GatherRows<4>(gaussians.canonical_areas, 4, faces, area);
  in.canonical_area = {{area[0], area[1], area[2]}};
  LoadRows<2>(gaussians.barycentric, 2, rows, in.gaussian.barycentric);
  in.gaussian.offset = LoadVec3<T>(gaussians.offset, rows);
  in.gaussian.rotation = LoadQuat<T>(gaussians.rotation, rows);
  in.gaussian.scale_log = LoadVec3<T>(gaussians.scale_log, rows);
  return in;
}

template <class T>
COSPLAT_HD_FORCED Correction<T> LoadCorrection(const CorrectionArrays& corrections,
                                               const Rows& rows) {
  T sum[kCorrectionWidth];
  for (int i = 0; i < kCorrectionWidth; ++i) sum[i] = T(0.0f);
  const size_t width = corrections.count * kCorrectionWidth;
  for (size_t k = 0; k < corrections.count; ++k) {
    T basis[kCorrectionWidth];
    LoadRows<kCorrectionWidth>(corrections.bases + k * kCorrectionWidth, width, rows, basis);
    const T weight(corrections.weights[k]);
    for (int i = 0; i < kCorrectionWidth; ++i) sum[i] = sum[i] + weight * basis[i];
  }
  return CorrectionOf(sum);
}

// The light's terms at the corners of the Gaussians' triangles, less their mean.
template <class T>
COSPLAT_HD_FORCED Three<LightTerms<T>> LightTermsAtCorners(const EmbedInput<T>& in,
                                                           const EmbeddedArrays& gaussians,
                                                           const Rows& rows) {
  const LaneRows<T> faces = FacesOf<T>(gaussians, rows);
  Three<LightTerms<T>> corners;
  for (int c = 0; c < 3; ++c) {
    corners[c] = LightTermsOf(in.vertices[c].normal);
    if (!gaussians.light.mean) continue;
    T mean[kLightTerms];
    GatherRows<kLightTerms>(
        gaussians.light.mean, kLightTerms, CornersOf<T>(gaussians, faces, c), mean);
    for (int k = 0; k < kLightTerms; ++k) corners[c].y[k] = corners[c].y[k] - mean[k];
  }
  return corners;
}

// Those at the Gaussians: where they are on the triangle, so that a walk, which makes (du, dv) part
// of (u, v), changes nothing.
template <class T>
COSPLAT_HD_FORCED LightTerms<T> LightTermsAt(const EmbedInput<T>& in,
                                             const Three<LightTerms<T>>& corners) {
  const Three<T> weights = BarycentricOf(in.gaussian);
  LightTerms<T> sum;
  for (int k = 0; k < kLightTerms; ++k) sum.y[k] = T(0.0f);
  for (int c = 0; c < 3; ++c)
    for (int k = 0; k < kLightTerms; ++k) sum.y[k] = sum.y[k] + weights[c] * corners[c].y[k];
  return sum;
}
template <class T>
COSPLAT_HD_FORCED LightTerms<T> LightTermsAt(const EmbedInput<T>& in,
                                             const EmbeddedArrays& gaussians,
                                             const Rows& rows) {
  return LightTermsAt(in, LightTermsAtCorners(in, gaussians, rows));
}

template <class T>
COSPLAT_HD_FORCED PosedGaussian<T> EmbedInFrame(const EmbedInput<T>& in,
                                                const EmbeddedArrays& gaussians,
                                                const PosedArrays<float>& out,
                                                const Rows& rows) {
  const bool corrected = gaussians.corrections.count > 0, lit = gaussians.light.coefficients;
  if (!corrected && !lit) return Embed(in.vertices, in.canonical_area, in.gaussian);
  Vec3<T> color = LoadVec3<T>(gaussians.color_dc, rows);
  PosedGaussian<T> posed;
  if (corrected) {
    const Correction<T> c = LoadCorrection<T>(gaussians.corrections, rows);
    const T opacity[1] = {LoadScalar<T>(gaussians.opacity_logit, rows) + c.opacity_logit};
    StoreRows<1>(opacity, out.opacity_logit, 1, rows);
    color += c.color_dc;
    posed = EmbedCorrected(in.vertices, in.canonical_area, in.gaussian, c);
  } else {
    posed = Embed(in.vertices, in.canonical_area, in.gaussian);
  }
  if (lit)
    color = Lit(color,
                LogLight(LightTermsAt<T>(in, gaussians, rows), gaussians.light.coefficients),
                gaussians.light.black);
  StoreVec3(color, out.color_dc, rows);
  return posed;
}

// color: the Gaussians' own, corrected. Returns its derivative, given that of the lit colour, and
// that of (du, dv) in d_offset; adds to the corners' normals unless they are null.
template <class T>
COSPLAT_HD_FORCED Vec3<T> LightVjp(const EmbedInput<T>& in,
                                   const EmbeddedArrays& gaussians,
                                   const Vec3<T>& color,
                                   const Vec3<T>& d_lit,
                                   const EmbeddedGradients& out,
                                   Three<SurfaceVertex<T>>* d_corners,
                                   T d_offset[2],
                                   const Rows& rows) {
  const LightArrays& light = gaussians.light;
  const Three<LightTerms<T>> corners = LightTermsAtCorners(in, gaussians, rows);
  const Vec3<T> log_light = LogLight(LightTermsAt(in, corners), light.coefficients);
  Vec3<T> d_color, d_log_light;
  LitVjp(color, log_light, light.black, d_lit, d_color, d_log_light);
  StoreVec3(d_color, out.color_dc, rows);
  StoreVec3(d_log_light, out.log_light, rows);
  const LightTerms<T> d_terms = LogLightVjp<T>(light.coefficients, d_log_light);
  Three<T> d_weights{{T(0.0f), T(0.0f), T(0.0f)}};
  for (int c = 0; c < 3; ++c)
    for (int k = 0; k < kLightTerms; ++k)
      d_weights[c] = d_weights[c] + d_terms.y[k] * corners[c].y[k];
  d_offset[0] = d_weights[0] - d_weights[2];
  d_offset[1] = d_weights[1] - d_weights[2];
  if (!d_corners) return d_color;
  const Three<T> weights = BarycentricOf(in.gaussian);
  for (int c = 0; c < 3; ++c) {
    LightTerms<T> d_vertex;
    for (int k = 0; k < kLightTerms; ++k) d_vertex.y[k] = weights[c] * d_terms.y[k];
    (*d_corners)[c].normal += LightTermsOfVjp(in.vertices[c].normal, d_vertex);
  }
  return d_color;
}

template <class T>
COSPLAT_HD_FORCED void Run(const EmbedKernel& kernel, const Rows& rows) {
  const PosedArrays<float>& out = kernel.out;
  const EmbedInput<T> in = LoadEmbedInput<T>(kernel.gaussians, rows);
  const PosedGaussian<T> posed = EmbedInFrame(in, kernel.gaussians, out, rows);
  StoreVec3(posed.position, out.position, rows);
  StoreQuat(posed.rotation, out.rotation, rows);
  StoreVec3(posed.scale_log, out.scale_log, rows);
  StoreQuat(posed.frame, out.frame, rows);
}

template <class T>
COSPLAT_HD_FORCED void StoreCorners(const Three<SurfaceVertex<T>>& d,
                                    float* corners,
                                    const Rows& rows) {
  for (int c = 0; c < 3; ++c)
    StoreSurfaceVertex(d[c], corners + c * kSurfaceVertexFloats, 3 * kSurfaceVertexFloats, rows);
}

// Writes the derivative of every basis: weight_k d_c.
template <class T>
COSPLAT_HD_FORCED void StoreBases(const Correction<T>& d_c,
                                  const CorrectionArrays& corrections,
                                  float* d_bases,
                                  const Rows& rows) {
  T d[kCorrectionWidth];
  CorrectionOfVjp(d_c, d);
  const size_t width = corrections.count * kCorrectionWidth;
  for (size_t k = 0; k < corrections.count; ++k) {
    const T weight(corrections.weights[k]);
    T d_basis[kCorrectionWidth];
    for (int i = 0; i < kCorrectionWidth; ++i) d_basis[i] = weight * d[i];
    StoreRows<kCorrectionWidth>(d_basis, d_bases + k * kCorrectionWidth, width, rows);
  }
}

template <class T>
COSPLAT_HD_FORCED void Run(const EmbedVjpKernel& kernel, const Rows& rows) {
  const auto& [gaussians, d_posed, out] = kernel;
  const T zero(0.0f);
  const EmbedInput<T> in = LoadEmbedInput<T>(gaussians, rows);
  PosedGaussian<T> d{LoadVec3<T>(d_posed.position, rows),
                     LoadQuat<T>(d_posed.rotation, rows),
                     LoadVec3<T>(d_posed.scale_log, rows),
                     {zero, zero, zero, zero}};
  if (d_posed.frame) d.frame = LoadQuat<T>(d_posed.frame, rows);
  EmbeddedGaussian<T> d_local;
  Three<SurfaceVertex<T>> d_corners;
  for (int c = 0; c < 3; ++c)
    d_corners[c] = {{zero, zero, zero}, {zero, zero, zero}, {zero, zero, zero, zero}, zero};
  Three<SurfaceVertex<T>>* const to_corners = out.corners ? &d_corners : nullptr;
  const bool corrected = gaussians.corrections.count > 0, lit = gaussians.light.coefficients;
  Vec3<T> d_color{zero, zero, zero};
  T d_offset[2] = {zero, zero};  // by the light
  if (corrected || lit) d_color = LoadVec3<T>(d_posed.color_dc, rows);
  Correction<T> c;
  if (corrected) c = LoadCorrection<T>(gaussians.corrections, rows);
  if (lit) {
    Vec3<T> color = LoadVec3<T>(gaussians.color_dc, rows);
    if (corrected) color += c.color_dc;
    d_color = LightVjp(in, gaussians, color, d_color, out, to_corners, d_offset, rows);
  }
  if (corrected) {
    Correction<T> d_c;
    d_c.opacity_logit = LoadScalar<T>(d_posed.opacity_logit, rows);
    d_c.color_dc = d_color;
    EmbedCorrectedVjp(in.vertices, in.canonical_area, in.gaussian, c, d, d_local, d_c, to_corners);
    StoreBases(d_c, gaussians.corrections, out.corrections, rows);
  } else {
    EmbedVjp(in.vertices, in.canonical_area, in.gaussian, d, d_local, to_corners);
  }
  d_local.offset.x = d_local.offset.x + d_offset[0];
  d_local.offset.y = d_local.offset.y + d_offset[1];
  StoreVec3(d_local.offset, out.offset, rows);
  StoreQuat(d_local.rotation, out.rotation, rows);
  StoreVec3(d_local.scale_log, out.scale_log, rows);
  if (out.corners) StoreCorners(d_corners, out.corners, rows);
}

template <class T>
COSPLAT_HD_FORCED RigidFace<T> LoadRigidFace(const EmbeddedArrays& gaussians,
                                             const LaneRows<T>& faces) {
  Vec3<T> p[3];
  for (int c = 0; c < 3; ++c) {
    T v[4];  // the position and an unused number
    GatherRows<4>(gaussians.vertices, kSurfaceVertexFloats, CornersOf<T>(gaussians, faces, c), v);
    p[c] = {v[0], v[1], v[2]};
  }
  return RigidFaceOf(p[0], p[1], p[2]);
}

template <class T>
COSPLAT_HD_FORCED void Run(const RigidEmbedKernel& kernel, const Rows& rows) {
  const EmbeddedArrays& in = kernel.gaussians;
  const LaneRows<T> faces = FacesOf<T>(in, rows);
  const RigidGaussian<T> local{LoadVec3<T>(in.offset, rows),
                               LoadQuat<T>(in.rotation, rows),
                               LoadVec3<T>(in.scale_log, rows)};
  const RigidGaussian<T> posed = RigidEmbed(LoadRigidFace<T>(in, faces), local);
  T face[kPosedFaceFloats];
  GatherRows<kPosedFaceFloats>(kernel.posed_faces, kPosedFaceFloats, faces, face);
  StoreVec3(posed.position, kernel.out.position, rows);
  StoreQuat(posed.rotation, kernel.out.rotation, rows);
  StoreVec3(posed.scale_log, kernel.out.scale_log, rows);
  StoreQuat(PosedFaceOf(face).rotation, kernel.out.frame, rows);
}

// One vertex per index: sums the contributions of the Gaussians around it in a fixed order, by face
// and then by Gaussian.
struct SumAtVertexKernel {
  SurfaceArrays s;
  FaceListArrays lists;
  const float* d_corners;  // [N, 3, kSurfaceVertexFloats]
  float* d_surface;        // [V, kSurfaceVertexFloats]

  COSPLAT_HD void operator()(size_t v) const {
    float sum[kSurfaceVertexFloats] = {};
    for (int32_t k = s.vertex_face_begin[v]; k < s.vertex_face_begin[v + 1]; ++k) {
      const size_t f = size_t(s.vertex_faces[k]);
      const size_t corner = size_t(CornerOf(s.faces + 3 * f, v));
      for (uint32_t j = lists.begin[f]; j < lists.begin[f + 1]; ++j) {
        const float* d = d_corners + kSurfaceVertexFloats * (3 * size_t(lists.index[j]) + corner);
        for (size_t i = 0; i < kSurfaceVertexFloats; ++i) sum[i] += d[i];
      }
    }
    for (size_t i = 0; i < kSurfaceVertexFloats; ++i)
      d_surface[kSurfaceVertexFloats * v + i] = sum[i];
  }
};

COSPLAT_MATH_END
#endif
