// Element-wise stage: one Gaussian in the world -> one ProjectedSplat, and its derivative.
// world arrays -> ProjectKernel -> tile lists, blend -> SplatGradient -> ProjectVjpKernel ->
// gradients.
#if defined(COSPLAT_SPLAT_KERNELS_PROJECT_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_KERNELS_PROJECT_H_
#undef COSPLAT_SPLAT_KERNELS_PROJECT_H_
#else
#define COSPLAT_SPLAT_KERNELS_PROJECT_H_
#endif

#include "splat/kernels/projected_splat.h"
#include "splat/kernels/world_gaussians.h"
#include "splat/math/blend.h"
#include "splat/math/dcsh.h"
#include "splat/math/pinhole.h"

COSPLAT_MATH_BEGIN

COSPLAT_HD Vec3<float> Load3(const float* p) { return {p[0], p[1], p[2]}; }
COSPLAT_HD Quat<float> LoadQuat(const float* p) { return {p[0], p[1], p[2], p[3]}; }
COSPLAT_HD void Store3(float* p, const Vec3<float>& v) {
  p[0] = v.x;
  p[1] = v.y;
  p[2] = v.z;
}
COSPLAT_HD bool IsFinite(float x) { return Abs(x) < 3e38f; }

COSPLAT_HD Pinhole<float> ToPinhole(const ViewParameters& v) {
  Pinhole<float> p;
  for (int i = 0; i < 9; ++i) p.rotation.m[i] = v.rotation[i];
  p.translation = Load3(v.translation);
  p.fx = v.fx;
  p.fy = v.fy;
  p.cx = v.cx;
  p.cy = v.cy;
  p.width = v.width;
  p.height = v.height;
  return p;
}

// Viewing direction in the frame that the colour is stored in: from the camera to the Gaussian,
// turned by R(frame)^T where there is a surface frame.
COSPLAT_HD Vec3<float> ColorDirection(const WorldGaussians& g,
                                      const ViewParameters& view,
                                      size_t i) {
  const Vec3<float> d = Normalize(Load3(g.position + 3 * i) - Load3(view.center));
  if (!g.color_frame) return d;
  return TransposeTimes(RotationOf(Normalize(LoadQuat(g.color_frame + 4 * i))), d);
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

struct ColorOf {
  Vec3<float> direction;
  const float *constants, *dc, *rest;
  template <int kDegree>
  COSPLAT_HD Vec3<float> Run() const {
    return EvaluateColor<kDegree>(direction, constants, dc, rest);
  }
};

struct ColorVjpOf {
  Vec3<float> direction;
  const float *constants, *rest;
  Vec3<float> color, d_color;
  float *d_dc, *d_rest;
  template <int kDegree>
  COSPLAT_HD Vec3<float> Run() const {
    return EvaluateColorVjp<kDegree>(direction, constants, rest, color, d_color, d_dc, d_rest);
  }
};

struct ProjectKernel {
  WorldGaussians gaussians;
  ViewParameters view;
  ProjectedSplat* splats;  // [count]

  COSPLAT_HD void operator()(size_t i) const {
    ProjectedSplat& out = splats[i];
    out.radius = 0;
    const Pinhole<float> camera = ToPinhole(view);
    const Vec3<float> p = ToCamera(camera, Load3(gaussians.position + 3 * i));
    if (!(p.z > kNearPlane)) return;
    const Quat<float> q = LoadQuat(gaussians.rotation + 4 * i);
    if (!(Dot(q, q) > kMinQuaternionNorm2)) return;
    const Vec3<float> s = Load3(gaussians.scale_log + 3 * i);
    const float opacity = Sigmoid(gaussians.opacity_logit[i]);
    if (!(opacity > kMinAlpha)) return;
    const Sym2<float> cov =
        ProjectCovariance(camera, p, Covariance(q, Vec3<float>{Exp(s.x), Exp(s.y), Exp(s.z)}));
    if (!(cov.xx * cov.yy - cov.xy * cov.xy > kMinDeterminant)) return;
    const Sym2<float> conic = Conic(cov);
    const Vec2<float> center = ProjectPoint(camera, p);
    out.x = center.x;
    out.y = center.y;
    out.power_xx = -0.5f * conic.xx;
    out.power_xy = -conic.xy;
    out.power_yy = -0.5f * conic.yy;
    out.opacity = opacity;
    out.reject_below = RejectBelow(opacity);
    // Exact box of the ellipse power >= reject_below: sqrt(t * variance), t = -2 reject_below.
    out.half_x = Sqrt(-2 * out.reject_below * cov.xx);
    out.half_y = Sqrt(-2 * out.reject_below * cov.yy);
    out.depth = p.z;
    const Vec3<float> color = WithDegree(view.degree,
                                         ColorOf{ColorDirection(gaussians, view, i),
                                                 view.basis_constants,
                                                 gaussians.color_dc + 3 * i,
                                                 gaussians.color_rest + gaussians.rest_width * i});
    out.r = color.x;
    out.g = color.y;
    out.b = color.z;
    const bool on_image = out.x + out.half_x > 0 && out.x - out.half_x < view.width &&
                          out.y + out.half_y > 0 && out.y - out.half_y < view.height;
    const bool finite = IsFinite(out.x) && IsFinite(out.y) && IsFinite(conic.xx) &&
                        IsFinite(conic.xy) && IsFinite(conic.yy) && IsFinite(out.half_x) &&
                        IsFinite(out.half_y) && IsFinite(color.x) && IsFinite(color.y) &&
                        IsFinite(color.z);
    if (!on_image || !finite) return;
    const float mid = 0.5f * (cov.xx + cov.yy);
    const float spread = Sqrt(Max(mid * mid - (cov.xx * cov.yy - cov.xy * cov.xy), 0.0f));
    out.radius = 3 * Sqrt(mid + spread);
  }
};

// Writes the gradient of Gaussian i (all zero when it was not drawn).
struct ProjectVjpKernel {
  WorldGaussians gaussians;
  ViewParameters view;
  const ProjectedSplat* splats;   // [count]
  const SplatGradient* d_splats;  // [count]; read only where drawn
  WorldGradients out;

  COSPLAT_HD void operator()(size_t i) const {
    ZeroColor(i);
    if (!(splats[i].radius > 0)) return ZeroGeometry(i);
    const SplatGradient& d = d_splats[i];
    const Pinhole<float> camera = ToPinhole(view);
    const Vec3<float> position = Load3(gaussians.position + 3 * i);
    const Vec3<float> p = ToCamera(camera, position);
    const Quat<float> q = LoadQuat(gaussians.rotation + 4 * i);
    const Vec3<float> s_log = Load3(gaussians.scale_log + 3 * i);
    const Vec3<float> s{Exp(s_log.x), Exp(s_log.y), Exp(s_log.z)};
    const Sym3<float> covariance = Covariance(q, s);
    const Sym2<float> conic{-2 * splats[i].power_xx, -splats[i].power_xy, -2 * splats[i].power_yy};
    const Sym2<float> d_cov =
        ConicVjp(conic, Sym2<float>{-0.5f * d.power_xx, -d.power_xy, -0.5f * d.power_yy});
    Vec3<float> d_p = ProjectPointVjp(camera, p, Vec2<float>{d.x, d.y});
    Sym3<float> d_covariance;
    ProjectCovarianceVjp(camera, p, covariance, d_cov, d_covariance, d_p);
    Quat<float> d_q;
    Vec3<float> d_s;
    CovarianceVjp(q, s, d_covariance, d_q, d_s);
    Vec3<float> d_position = TransposeTimes(camera.rotation, d_p);
    d_position += ColorVjp(i, position);
    Store3(out.position + 3 * i, d_position);
    out.rotation[4 * i] = d_q.w;
    out.rotation[4 * i + 1] = d_q.x;
    out.rotation[4 * i + 2] = d_q.y;
    out.rotation[4 * i + 3] = d_q.z;
    Store3(out.scale_log + 3 * i, Vec3<float>{d_s.x * s.x, d_s.y * s.y, d_s.z * s.z});
    out.opacity_logit[i] = SigmoidVjp(splats[i].opacity, d.opacity);
    out.screen[2 * i] = d.x;
    out.screen[2 * i + 1] = d.y;
  }

  // Colour's gradient; returns its part of d_position.
  COSPLAT_HD Vec3<float> ColorVjp(size_t i, const Vec3<float>& position) const {
    const SplatGradient& d = d_splats[i];
    const Vec3<float> u = ColorDirection(gaussians, view, i);
    Vec3<float> d_u = WithDegree(view.degree,
                                 ColorVjpOf{u,
                                            view.basis_constants,
                                            gaussians.color_rest + gaussians.rest_width * i,
                                            Vec3<float>{splats[i].r, splats[i].g, splats[i].b},
                                            Vec3<float>{d.r, d.g, d.b},
                                            out.color_dc + 3 * i,
                                            out.color_rest + gaussians.rest_width * i});
    const Vec3<float> offset = position - Load3(view.center);
    if (gaussians.color_frame) {
      // u = R^T w: d_w = R d_u, d_R = w d_u^T.
      const Quat<float> frame = LoadQuat(gaussians.color_frame + 4 * i);
      const Quat<float> unit = Normalize(frame);
      const Vec3<float> w = Normalize(offset);
      const Quat<float> d_frame = NormalizeVjp(frame, RotationOfVjp(unit, Outer(w, d_u)));
      out.color_frame[4 * i] = d_frame.w;
      out.color_frame[4 * i + 1] = d_frame.x;
      out.color_frame[4 * i + 2] = d_frame.y;
      out.color_frame[4 * i + 3] = d_frame.z;
      d_u = RotationOf(unit) * d_u;
    }
    return NormalizeVjp(offset, d_u);
  }

  COSPLAT_HD void ZeroColor(size_t i) const {
    for (int k = 0; k < 3; ++k) out.color_dc[3 * i + k] = 0;
    for (int k = 0; k < gaussians.rest_width; ++k) out.color_rest[gaussians.rest_width * i + k] = 0;
  }
  COSPLAT_HD void ZeroGeometry(size_t i) const {
    for (int k = 0; k < 3; ++k) out.position[3 * i + k] = out.scale_log[3 * i + k] = 0;
    for (int k = 0; k < 4; ++k) out.rotation[4 * i + k] = 0;
    if (gaussians.color_frame)
      for (int k = 0; k < 4; ++k) out.color_frame[4 * i + k] = 0;
    out.opacity_logit[i] = out.screen[2 * i] = out.screen[2 * i + 1] = 0;
  }
};

COSPLAT_MATH_END
#endif
