// Element-wise stage: one Gaussian in the world -> one ProjectedSplat, and its derivative.
// world arrays -> ProjectKernel -> tile lists, blend -> SplatGradient -> ProjectVjpKernel ->
// gradients. Run<T>(rows) processes as many Gaussians as T has lanes. kAntialiased: of Gaussians
// with WorldGaussians::antialiased, compiled apart, so that others keep their instructions and
// bits.
#if defined(COSPLAT_SPLAT_KERNELS_PROJECT_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_KERNELS_PROJECT_H_
#undef COSPLAT_SPLAT_KERNELS_PROJECT_H_
#else
#define COSPLAT_SPLAT_KERNELS_PROJECT_H_
#endif

#include <cstddef>

#include "splat/math/blend.h"
#include "splat/math/dcsh.h"
#include "splat/math/pinhole.h"
#include "splat/math/rows.h"
#include "splat/render/kernels/projected_splat.h"
#include "splat/render/kernels/world_gaussians.h"

COSPLAT_MATH_BEGIN

template <class T>
COSPLAT_HD Vec3<T> Broadcast3(const float* p) {
  return {T(p[0]), T(p[1]), T(p[2])};
}

template <class T>
COSPLAT_HD Pinhole<T> ToPinhole(const ViewParameters& v) {
  Pinhole<T> p;
  for (int i = 0; i < 9; ++i) p.rotation.m[i] = T(v.rotation[i]);
  p.translation = Broadcast3<T>(v.translation);
  p.fx = T(v.fx);
  p.fy = T(v.fy);
  p.cx = T(v.cx);
  p.cy = T(v.cy);
  p.width = T(v.width);
  p.height = T(v.height);
  p.near_plane = T(v.near_plane);
  return p;
}

// Viewing direction in the frame that the colour is stored in: from the camera to the Gaussian,
// rotated by R(frame)^T if there is a surface frame.
template <class T>
struct ColorView {
  Vec3<T> offset;     // Gaussian - camera, world
  Quat<T> frame;      // as stored, not normalised; only if there are frames
  Vec3<T> direction;  // unit
};
template <class T>
COSPLAT_HD ColorView<T> ColorViewOf(const WorldGaussians& g,
                                    const ViewParameters& view,
                                    const Vec3<T>& position,
                                    const Rows& rows) {
  ColorView<T> c{position - Broadcast3<T>(view.center), {}, {}};
  c.direction = Normalize(c.offset);
  if (!g.color_frame) return c;
  c.frame = LoadQuat<T>(g.color_frame, rows);
  c.direction = TransposeTimes(RotationOf(Normalize(c.frame)), c.direction);
  return c;
}
// d_direction -> d_offset and d_frame. direction = R(unit frame)^T w, w = Normalize(offset):
// d_w = R d_direction, d_R = w d_direction^T.
template <class T>
COSPLAT_HD Vec3<T> ColorViewVjp(const ColorView<T>& c,
                                bool has_frame,
                                Vec3<T> d_direction,
                                Quat<T>& d_frame) {
  if (has_frame) {
    const Quat<T> unit = Normalize(c.frame);
    const Vec3<T> w = Normalize(c.offset);
    d_frame = NormalizeVjp(c.frame, RotationOfVjp(unit, Outer(w, d_direction)));
    d_direction = RotationOf(unit) * d_direction;
  }
  return NormalizeVjp(c.offset, d_direction);
}

// Highest band that the view evaluates for Gaussian i.
COSPLAT_HD int DegreeOf(const WorldGaussians& g, const ViewParameters& view, size_t i) {
  return g.degree && g.degree[i] < view.degree ? g.degree[i] : view.degree;
}
// The maximum over these Gaussians; the coefficients of the others up to there are zero.
COSPLAT_HD int HighestDegree(const WorldGaussians& g,
                             const ViewParameters& view,
                             const Rows& rows) {
  if (!g.degree) return view.degree;
  int highest = 0;
  for (size_t i = rows.first; i < rows.first + rows.count; ++i) {
    const int own = DegreeOf(g, view, i);
    highest = own > highest ? own : highest;
  }
  return highest;
}

// Calls f with the degree as a compile-time constant.
template <class F>
COSPLAT_HD auto WithDegree(int degree, const F& f) {
  switch (degree) {
    case 0:
      return f.template Run<0>();
    case 1:
      return f.template Run<1>();
    case 2:
      return f.template Run<2>();
    case 3:
      return f.template Run<3>();
    default:
      return f.template Run<4>();
  }
}

// Number of coefficients of bands 1 to kDegree, all channels; at least one, to size arrays.
template <int kDegree>
constexpr int kRestUsed = kDegree == 0 ? 1 : 3 * ((kDegree + 1) * (kDegree + 1) - 1);

template <class T>
struct ColorOf {
  const WorldGaussians& gaussians;
  const ViewParameters& view;
  Rows rows;
  Vec3<T> direction;

  template <int kDegree>
  COSPLAT_HD Vec3<T> Run() const {
    T dc[3], rest[kRestUsed<kDegree>];
    LoadRows<3>(gaussians.color_dc, 3, rows, dc);
    if constexpr (kDegree > 0)
      LoadRows<kRestUsed<kDegree>>(gaussians.color_rest, gaussians.rest_width, rows, rest);
    return EvaluateColor<kDegree>(direction, view.basis_constants, dc, rest);
  }
};

// Writes the coefficients' gradients (those of bands above kDegree are left unchanged) and returns
// d_direction. d_color must be zero for invisible Gaussians.
template <class T>
struct ColorVjpOf {
  const WorldGaussians& gaussians;
  const ViewParameters& view;
  const WorldGradients& out;
  Rows rows;
  Vec3<T> direction, color, d_color;

  template <int kDegree>
  COSPLAT_HD Vec3<T> Run() const {
    T rest[kRestUsed<kDegree>], d_dc[3], d_rest[kRestUsed<kDegree>];
    if constexpr (kDegree > 0)
      LoadRows<kRestUsed<kDegree>>(gaussians.color_rest, gaussians.rest_width, rows, rest);
    const Vec3<T> d_direction = EvaluateColorVjp<kDegree>(
        direction, view.basis_constants, rest, color, d_color, d_dc, d_rest);
    StoreRows<3>(d_dc, out.color_dc, 3, rows);
    if constexpr (kDegree > 0)
      StoreRows<kRestUsed<kDegree>>(d_rest, out.color_rest, gaussians.rest_width, rows);
    return d_direction;
  }
};

// The variance of the 3D smoothing filter; 0 without one.
template <class T>
COSPLAT_HD T SmoothingOf(const WorldGaussians& g, const Rows& rows) {
  return g.smoothing ? LoadScalar<T>(g.smoothing, rows) : T(0);
}

// A Gaussian's ellipse in the image, px.
template <class T>
struct Footprint {
  Vec2<T> center;
  Sym2<T> covariance;
  PowerForm<T> form;
  T reject_below;
  T half_x, half_y;  // half-extents of the exact bounding box of power >= reject_below
  T radius;          // 3 standard deviations along the longer axis
};
template <class T>
COSPLAT_HD Footprint<T> FootprintOf(const Pinhole<T>& camera,
                                    const Vec3<T>& p_in_cam,
                                    const Quat<T>& rotation,
                                    const Vec3<T>& scale_log,
                                    T opacity,
                                    T low_pass) {
  Footprint<T> f;
  const Vec3<T> scale{Exp(scale_log.x), Exp(scale_log.y), Exp(scale_log.z)};
  f.covariance = ProjectCovariance(camera, p_in_cam, Covariance(rotation, scale), low_pass);
  const Sym2<T> conic = Conic(f.covariance);
  f.center = ProjectPoint(camera, p_in_cam);
  f.form = {T(-0.5f) * conic.xx, -conic.xy, T(-0.5f) * conic.yy};
  f.reject_below = RejectBelow(opacity);
  // sqrt(t * variance), t = -2 reject_below.
  f.half_x = Sqrt(T(-2) * f.reject_below * f.covariance.xx);
  f.half_y = Sqrt(T(-2) * f.reject_below * f.covariance.yy);
  const T mid = T(0.5f) * (f.covariance.xx + f.covariance.yy);
  f.radius = T(3) * Sqrt(mid + Sqrt(Max(mid * mid - Determinant(f.covariance), T(0))));
  return f;
}

// Whether the footprint is non-degenerate, finite and on the image. Comparisons with NaN are false.
template <class T>
COSPLAT_HD auto CanBeDrawn(const Footprint<T>& f, const Pinhole<T>& camera) {
  const auto on_image =
      And(And(f.center.x + f.half_x > T(0), f.center.x - f.half_x < camera.width),
          And(f.center.y + f.half_y > T(0), f.center.y - f.half_y < camera.height));
  const auto finite = And(And(IsFinite(f.form.xx), IsFinite(f.form.xy)),
                          And(IsFinite(f.form.yy), And(IsFinite(f.half_x), IsFinite(f.half_y))));
  return And(And(on_image, finite), Determinant(f.covariance) > T(kMinDeterminant));
}

template <bool kAntialiased>
struct ProjectKernel {
  WorldGaussians gaussians;
  ViewParameters view;
  ProjectedSplat* splats;  // [count]; written for visible Gaussians, and others in their pack
  float* radii;            // [count]

  template <class T>
  COSPLAT_HD void Run(const Rows& rows) const {
    const Pinhole<T> camera = ToPinhole<T>(view);
    const Vec3<T> position = LoadVec3<T>(gaussians.position, rows);
    const Vec3<T> p = ToCamera(camera, position);
    auto drawn = p.z > camera.near_plane;
    if (!AnyTrue(drawn)) return DrawNone(rows);
    const Quat<T> q = LoadQuat<T>(gaussians.rotation, rows);
    const T opacity = OpacityOf(camera, p, q, rows);
    const Footprint<T> f = FootprintOf(camera, p, q, ScaleLogOf<T>(rows), opacity, LowPassOf<T>());
    drawn = And(drawn, And(Dot(q, q) > T(kMinQuaternionNorm2), opacity > T(kMinAlpha)));
    drawn = And(drawn, CanBeDrawn(f, camera));
    if (!AnyTrue(drawn)) return DrawNone(rows);
    Vec3<T> direction = ColorViewOf(gaussians, view, position, rows).direction;
    if (view.folds_direction) direction = Fold(direction);
    const Vec3<T> color = WithDegree(HighestDegree(gaussians, view, rows),
                                     ColorOf<T>{gaussians, view, rows, direction});
    drawn = And(And(drawn, IsFinite(color.x)), And(IsFinite(color.y), IsFinite(color.z)));
    const PowerRidges<T> ridges = RidgesOf(f.form);
    // In the order of ProjectedSplat's members.
    const T out[kProjectedFloats] = {f.center.x,
                                     f.center.y,
                                     f.form.xx,
                                     f.form.xy,
                                     f.form.yy,
                                     f.reject_below,
                                     ridges.x_per_y,
                                     ridges.y_per_x,
                                     opacity,
                                     color.x,
                                     color.y,
                                     color.z,
                                     f.half_x,
                                     f.half_y,
                                     p.z};
    StoreRows<kProjectedFloats>(out, &splats->x, kProjectedStride, rows);
    StoreWhere(drawn, f.radius, radii, rows);
  }

  template <class T>
  COSPLAT_HD T LowPassOf() const {
    return T(kAntialiased ? gaussians.low_pass_variance : kBlurVariance);
  }

  // After both filters.
  template <class T>
  COSPLAT_HD T OpacityOf(const Pinhole<T>& camera,
                         const Vec3<T>& p_in_cam,
                         const Quat<T>& q,
                         const Rows& rows) const {
    const T opacity = Sigmoid(LoadScalar<T>(gaussians.opacity_logit, rows));
    if constexpr (!kAntialiased) return opacity;
    const SmoothedScale<T> smoothed = SmoothedScaleOf<T>(rows);
    const Sym2<T> sharp = ProjectCovariance(camera, p_in_cam, Covariance(q, smoothed.scale), T(0));
    return opacity * smoothed.share * LowPassShare(sharp, LowPassOf<T>());
  }
  template <class T>
  COSPLAT_HD SmoothedScale<T> SmoothedScaleOf(const Rows& rows) const {
    const Vec3<T> log = LoadVec3<T>(gaussians.scale_log, rows);
    return SmoothScale(Vec3<T>{Exp(log.x), Exp(log.y), Exp(log.z)},
                       SmoothingOf<T>(gaussians, rows));
  }
  template <class T>
  COSPLAT_HD Vec3<T> ScaleLogOf(const Rows& rows) const {
    if constexpr (!kAntialiased) return LoadVec3<T>(gaussians.scale_log, rows);
    const Vec3<T> scale = SmoothedScaleOf<T>(rows).scale;
    return {Log(scale.x), Log(scale.y), Log(scale.z)};
  }

  COSPLAT_HD void DrawNone(const Rows& rows) const { ZeroRows(radii, 1, rows); }
};

// What the backward pass reads of a ProjectedSplat, and the derivatives that SplatGradient has.
template <class T>
struct SplatParts {
  Vec2<T> center;
  Sym2<T> conic;
  T opacity;
  Vec3<T> color;
};
template <class T>
COSPLAT_HD SplatParts<T> LoadSplat(const ProjectedSplat* splats, const Rows& rows) {
  constexpr size_t kPower = offsetof(ProjectedSplat, power_xx) / sizeof(float),
                   kOpacity = offsetof(ProjectedSplat, opacity) / sizeof(float),
                   kColor = offsetof(ProjectedSplat, r) / sizeof(float);
  T v[kProjectedFloats];
  LoadRows<kProjectedFloats>(&splats->x, kProjectedStride, rows, v);
  return {{v[0], v[1]},
          {T(-2) * v[kPower], -v[kPower + 1], T(-2) * v[kPower + 2]},
          v[kOpacity],
          {v[kColor], v[kColor + 1], v[kColor + 2]}};
}
template <class T>
COSPLAT_HD SplatParts<T> LoadSplatGradient(const SplatGradient* gradients, const Rows& rows) {
  T v[9];  // in the order of the members
  LoadRows<9>(&gradients->x, 9, rows, v);
  return {{v[0], v[1]}, {T(-0.5f) * v[2], -v[3], T(-0.5f) * v[4]}, v[5], {v[6], v[7], v[8]}};
}

// Writes the gradients of the Gaussians in `rows` (zero for invisible ones).
template <bool kAntialiased>
struct ProjectVjpKernel {
  WorldGaussians gaussians;
  ViewParameters view;
  const ProjectedSplat* splats;   // [count]
  const float* radii;             // [count]
  const SplatGradient* d_splats;  // [count]; used only where visible
  WorldGradients out;

  template <class T>
  COSPLAT_HD void Run(const Rows& rows) const {
    const auto drawn = LoadScalar<T>(radii, rows) > T(0);
    if (!AnyTrue(drawn)) return ZeroAll(rows);
    const SplatParts<T> splat = LoadSplat<T>(splats, rows),
                        d = LoadSplatGradient<T>(d_splats, rows);
    const Pinhole<T> camera = ToPinhole<T>(view);
    const Vec3<T> position = LoadVec3<T>(gaussians.position, rows);
    const Vec3<T> p = ToCamera(camera, position);
    const Quat<T> q = LoadQuat<T>(gaussians.rotation, rows);
    const Vec3<T> s_log = LoadVec3<T>(gaussians.scale_log, rows);
    const Vec3<T> stored{Exp(s_log.x), Exp(s_log.y), Exp(s_log.z)};
    Sym2<T> d_cov = ConicVjp(splat.conic, d.conic);
    Vec3<T> s = stored;
    [[maybe_unused]] Filters<T> filters;
    if constexpr (kAntialiased) {
      filters = FiltersOf(camera, p, q, stored, rows);
      s = filters.smoothed.scale;
      const Sym2<T> more = LowPassShareVjp(filters.sharp,
                                           T(gaussians.low_pass_variance),
                                           d.opacity * filters.opacity * filters.smoothed.share);
      d_cov = {d_cov.xx + more.xx, d_cov.xy + more.xy, d_cov.yy + more.yy};
    }
    Vec3<T> d_p = ProjectPointVjp(camera, p, d.center);
    Sym3<T> d_covariance;
    ProjectCovarianceVjp(camera, p, Covariance(q, s), d_cov, d_covariance, d_p);
    Quat<T> d_q;
    Vec3<T> d_s;
    CovarianceVjp(q, s, d_covariance, d_q, d_s);
    Vec3<T> d_position = TransposeTimes(camera.rotation, d_p);

    d_position += ColorVjp(drawn, position, splat.color, d.color, rows);

    StoreWhere(drawn, d_position, out.position, rows);
    StoreWhere(drawn, d_q, out.rotation, rows);
    if constexpr (kAntialiased) {
      const T d_smoothed = d.opacity * LowPassShare(filters.sharp, T(gaussians.low_pass_variance));
      const Vec3<T> d_scale_log = SmoothScaleVjp(
          stored, filters.variance, filters.smoothed, d_s, d_smoothed * filters.opacity);
      StoreWhere(drawn, d_scale_log, out.scale_log, rows);
      StoreWhere(drawn,
                 SigmoidVjp(filters.opacity, d_smoothed * filters.smoothed.share),
                 out.opacity_logit,
                 rows);
    } else {
      StoreWhere(drawn, Vec3<T>{d_s.x * s.x, d_s.y * s.y, d_s.z * s.z}, out.scale_log, rows);
      StoreWhere(drawn, SigmoidVjp(splat.opacity, d.opacity), out.opacity_logit, rows);
    }
    const T d_screen[2] = {Select(drawn, d.center.x, T(0)), Select(drawn, d.center.y, T(0))};
    StoreRows<2>(d_screen, out.screen, 2, rows);
  }

  // What the forward pass computed of both filters.
  template <class T>
  struct Filters {
    T variance;  // of the 3D smoothing filter
    SmoothedScale<T> smoothed;
    T opacity;      // as stored
    Sym2<T> sharp;  // covariance in the image before the low-pass filter
  };
  template <class T>
  COSPLAT_HD Filters<T> FiltersOf(const Pinhole<T>& camera,
                                  const Vec3<T>& p_in_cam,
                                  const Quat<T>& q,
                                  const Vec3<T>& stored,
                                  const Rows& rows) const {
    Filters<T> f;
    f.variance = SmoothingOf<T>(gaussians, rows);
    f.smoothed = SmoothScale(stored, f.variance);
    f.opacity = Sigmoid(LoadScalar<T>(gaussians.opacity_logit, rows));
    f.sharp = ProjectCovariance(camera, p_in_cam, Covariance(q, f.smoothed.scale), T(0));
    return f;
  }

  // Writes the gradients of the colour's parameters; returns the colour's part of d_position.
  template <class T, class Mask>
  COSPLAT_HD Vec3<T> ColorVjp(Mask drawn,
                              const Vec3<T>& position,
                              const Vec3<T>& color,
                              const Vec3<T>& d_shown,
                              const Rows& rows) const {
    const ColorView<T> color_view = ColorViewOf(gaussians, view, position, rows);
    // An invisible Gaussian may have no valid direction; its colour gradient is 0 times a basis
    // function, which must be finite.
    const Vec3<T>& seen = color_view.direction;
    Vec3<T> direction{
        Select(drawn, seen.x, T(0)), Select(drawn, seen.y, T(0)), Select(drawn, seen.z, T(0))};
    if (view.folds_direction) direction = Fold(direction);
    const Vec3<T> d_color{Select(drawn, d_shown.x, T(0)),
                          Select(drawn, d_shown.y, T(0)),
                          Select(drawn, d_shown.z, T(0))};
    Vec3<T> d_direction =
        WithDegree(HighestDegree(gaussians, view, rows),
                   ColorVjpOf<T>{gaussians, view, out, rows, direction, color, d_color});
    ZeroUnusedBands(rows);
    if (view.folds_direction) d_direction = FoldVjp(seen, d_direction);
    const bool has_frame = gaussians.color_frame != nullptr;
    Quat<T> d_frame;
    const Vec3<T> d_offset = ColorViewVjp(color_view, has_frame, d_direction, d_frame);
    if (has_frame) StoreWhere(drawn, d_frame, out.color_frame, rows);
    return d_offset;
  }

  // Zeroes the gradients of stored bands that the view or the Gaussian does not use. Runs after the
  // others, which write up to the highest degree of all rows.
  COSPLAT_HD void ZeroUnusedBands(const Rows& rows) const {
    const int width = gaussians.rest_width;
    for (size_t i = rows.first; i < rows.first + rows.count; ++i) {
      const int own = DegreeOf(gaussians, view, i);
      for (int k = 3 * ((own + 1) * (own + 1) - 1); k < width; ++k)
        out.color_rest[width * i + k] = 0;
    }
  }
  COSPLAT_HD void ZeroAll(const Rows& rows) const {
    ZeroRows(out.position, 3, rows);
    ZeroRows(out.rotation, 4, rows);
    ZeroRows(out.scale_log, 3, rows);
    ZeroRows(out.opacity_logit, 1, rows);
    ZeroRows(out.color_dc, 3, rows);
    ZeroRows(out.color_rest, gaussians.rest_width, rows);
    ZeroRows(out.screen, 2, rows);
    if (gaussians.color_frame) ZeroRows(out.color_frame, 4, rows);
  }
};

COSPLAT_MATH_END
#endif
