// Perspective projection of a Gaussian: centre, 2D covariance (EWA) and its inverse, the conic.
// Sources: Zwicker et al. 2002 (EWA splatting), eq. 29-31; Kerbl et al. 2023, eq. 5.
#if defined(COSPLAT_SPLAT_MATH_PINHOLE_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_MATH_PINHOLE_H_
#undef COSPLAT_SPLAT_MATH_PINHOLE_H_
#else
#define COSPLAT_SPLAT_MATH_PINHOLE_H_
#endif

#include "splat/config.h"
#include "splat/math/gaussian.h"

COSPLAT_MATH_BEGIN

// cam_from_world and intrinsics, px. OpenCV axes: +z forward, y down.
template <class T>
struct Pinhole {
  Mat3<T> rotation;
  Vec3<T> translation;
  T fx, fy, cx, cy, width, height;
  T near_plane;  // smallest depth that is drawn
};

template <class T>
COSPLAT_HD Vec3<T> ToCamera(const Pinhole<T>& camera, const Vec3<T>& p_in_world) {
  return camera.rotation * p_in_world + camera.translation;
}

// Pixel position of a point in front of the camera.
template <class T>
COSPLAT_HD Vec2<T> ProjectPoint(const Pinhole<T>& camera, const Vec3<T>& p_in_cam) {
  const T inv_z = T(1) / p_in_cam.z;
  return {camera.fx * p_in_cam.x * inv_z + camera.cx, camera.fy * p_in_cam.y * inv_z + camera.cy};
}
template <class T>
COSPLAT_HD Vec3<T> ProjectPointVjp(const Pinhole<T>& camera,
                                   const Vec3<T>& p_in_cam,
                                   const Vec2<T>& d) {
  const T inv_z = T(1) / p_in_cam.z;
  const T dx = d.x * camera.fx * inv_z;
  const T dy = d.y * camera.fy * inv_z;
  return {dx, dy, -(dx * p_in_cam.x + dy * p_in_cam.y) * inv_z};
}

// Symmetric 2x2 matrix; gradients as for Sym3.
template <class T>
struct Sym2 {
  T xx, xy, yy;
};

// The non-zero entries of the projection's Jacobian at a point:
//   [ x  0  xz ]
//   [ 0  y  yz ]
// evaluated at x/z and y/z clamped to 15 % (each side) beyond the image, about the principal point;
// otherwise a splat near the camera's plane would cover everything.
template <class T>
struct ProjectionJacobian {
  T x, xz, y, yz;
};

// x/z or y/z and its clamped value.
template <class T>
struct ClampedSlope {
  T value;
  T inside;  // 1 where not clamped, else 0
};
template <class T>
COSPLAT_HD ClampedSlope<T> ClampSlope(T slope, T focal, T center, T size) {
  const T margin = T(kJacobianMargin) * size / focal;
  const T high = (size - center) / focal + margin;
  const T low = -center / focal - margin;
  const T value = Clamp(slope, low, high);
  return {value, Select(slope > high, T(0), Select(slope < low, T(0), T(1)))};
}

template <class T>
COSPLAT_HD ProjectionJacobian<T> JacobianAt(const Pinhole<T>& camera, const Vec3<T>& p) {
  const T inv_z = T(1) / p.z;
  const ClampedSlope<T> sx = ClampSlope(p.x * inv_z, camera.fx, camera.cx, camera.width);
  const ClampedSlope<T> sy = ClampSlope(p.y * inv_z, camera.fy, camera.cy, camera.height);
  return {camera.fx * inv_z,
          -camera.fx * sx.value * inv_z,
          camera.fy * inv_z,
          -camera.fy * sy.value * inv_z};
}
// A clamped coordinate has no gradient: moving it further out does not change the Jacobian.
template <class T>
COSPLAT_HD Vec3<T> JacobianAtVjp(const Pinhole<T>& camera,
                                 const Vec3<T>& p,
                                 const ProjectionJacobian<T>& d) {
  const T inv_z = T(1) / p.z;
  const T inv_z2 = inv_z * inv_z;
  const T slope_x = p.x * inv_z;
  const T slope_y = p.y * inv_z;
  const ClampedSlope<T> sx = ClampSlope(slope_x, camera.fx, camera.cx, camera.width);
  const ClampedSlope<T> sy = ClampSlope(slope_y, camera.fy, camera.cy, camera.height);
  const T d_sx = -camera.fx * inv_z * d.xz * sx.inside;
  const T d_sy = -camera.fy * inv_z * d.yz * sy.inside;
  const T d_inv_z = camera.fx * (d.x - sx.value * d.xz) + camera.fy * (d.y - sy.value * d.yz);
  return {
      d_sx * inv_z, d_sy * inv_z, -(d_inv_z * inv_z2) - (d_sx * slope_x + d_sy * slope_y) * inv_z};
}

// Pixels per world unit at a point, in the view's denser direction; 0 for a point behind the camera
// or more than kJacobianMargin beyond the image.
template <class T>
COSPLAT_HD T SamplingRate(const Pinhole<T>& camera, const Vec3<T>& p_in_cam) {
  const Vec2<T> at = ProjectPoint(camera, p_in_cam);
  const T margin_x = T(kJacobianMargin) * camera.width;
  const T margin_y = T(kJacobianMargin) * camera.height;
  const auto seen = And(And(p_in_cam.z > camera.near_plane,
                            Abs(at.x - T(0.5f) * camera.width) < T(0.5f) * camera.width + margin_x),
                        Abs(at.y - T(0.5f) * camera.height) < T(0.5f) * camera.height + margin_y);
  return Select(seen, Max(camera.fx, camera.fy) / p_in_cam.z, T(0));
}

// Rows of J W: image axes expressed in the world.
template <class T>
struct ImageAxes {
  Vec3<T> u, v;
};
template <class T>
COSPLAT_HD ImageAxes<T> ImageAxesAt(const Pinhole<T>& camera, const ProjectionJacobian<T>& j) {
  const Mat3<T>& w = camera.rotation;
  return {
      {j.x * w.m[0] + j.xz * w.m[6], j.x * w.m[1] + j.xz * w.m[7], j.x * w.m[2] + j.xz * w.m[8]},
      {j.y * w.m[3] + j.yz * w.m[6], j.y * w.m[4] + j.yz * w.m[7], j.y * w.m[5] + j.yz * w.m[8]}};
}

// Covariance in the image, px^2: J W Sigma W^T J^T plus the variance of a low-pass filter.
template <class T>
COSPLAT_HD Sym2<T> ProjectCovariance(const Pinhole<T>& camera,
                                     const Vec3<T>& p_in_cam,
                                     const Sym3<T>& covariance,
                                     T low_pass) {
  const ImageAxes<T> axes = ImageAxesAt(camera, JacobianAt(camera, p_in_cam));
  const Vec3<T> su = covariance * axes.u;
  const Vec3<T> sv = covariance * axes.v;
  return {Dot(axes.u, su) + low_pass, Dot(axes.u, sv), Dot(axes.v, sv) + low_pass};
}
// Writes d_covariance; adds to d_p_in_cam.
template <class T>
COSPLAT_HD void ProjectCovarianceVjp(const Pinhole<T>& camera,
                                     const Vec3<T>& p_in_cam,
                                     const Sym3<T>& covariance,
                                     const Sym2<T>& d,
                                     Sym3<T>& d_covariance,
                                     Vec3<T>& d_p_in_cam) {
  const ImageAxes<T> axes = ImageAxesAt(camera, JacobianAt(camera, p_in_cam));
  const Vec3<T>& u = axes.u;
  const Vec3<T>& v = axes.v;
  const T two(2);
  d_covariance = {d.xx * u.x * u.x + d.xy * u.x * v.x + d.yy * v.x * v.x,
                  two * (d.xx * u.x * u.y + d.yy * v.x * v.y) + d.xy * (u.x * v.y + u.y * v.x),
                  two * (d.xx * u.x * u.z + d.yy * v.x * v.z) + d.xy * (u.x * v.z + u.z * v.x),
                  d.xx * u.y * u.y + d.xy * u.y * v.y + d.yy * v.y * v.y,
                  two * (d.xx * u.y * u.z + d.yy * v.y * v.z) + d.xy * (u.y * v.z + u.z * v.y),
                  d.xx * u.z * u.z + d.xy * u.z * v.z + d.yy * v.z * v.z};
  const Vec3<T> su = covariance * u;
  const Vec3<T> sv = covariance * v;
  const Vec3<T> d_u = su * (two * d.xx) + sv * d.xy;
  const Vec3<T> d_v = sv * (two * d.yy) + su * d.xy;
  const Mat3<T>& w = camera.rotation;
  const Vec3<T> w0{w.m[0], w.m[1], w.m[2]}, w1{w.m[3], w.m[4], w.m[5]}, w2{w.m[6], w.m[7], w.m[8]};
  const ProjectionJacobian<T> d_j = {Dot(d_u, w0), Dot(d_u, w2), Dot(d_v, w1), Dot(d_v, w2)};
  d_p_in_cam += JacobianAtVjp(camera, p_in_cam, d_j);
}

template <class T>
COSPLAT_HD T Determinant(const Sym2<T>& c) {
  return c.xx * c.yy - c.xy * c.xy;
}

// The renderer's low-pass filter: a covariance after convolution with an isotropic Gaussian of
// `variance`, px^2. Its derivative is the identity.
template <class T>
COSPLAT_HD Sym2<T> LowPass(const Sym2<T>& c, T variance) {
  return {c.xx + variance, c.xy, c.yy + variance};
}

// The share of its opacity that a Gaussian keeps in that filter, so that its sum over the image
// stays what it was: sqrt(det(c) / det(LowPass(c))). Source: Yu et al. 2024 (Mip-Splatting), the 2D
// Mip filter.
template <class T>
COSPLAT_HD T LowPassShare(const Sym2<T>& c, T variance) {
  return Sqrt(Max(Determinant(c) / Determinant(LowPass(c, variance)), T(kMinLowPassRatio)));
}
template <class T>
COSPLAT_HD Sym2<T> LowPassShareVjp(const Sym2<T>& c, T variance, T d_share) {
  const Sym2<T> b = LowPass(c, variance);
  const T inv_after = T(1) / Determinant(b);
  const T ratio = Determinant(c) * inv_after;
  const T share = Sqrt(Max(ratio, T(kMinLowPassRatio)));
  const T d_ratio = Select(ratio > T(kMinLowPassRatio), T(0.5f) * d_share / share, T(0));
  const T d_before = d_ratio * inv_after;
  const T d_after = -(d_before * ratio);
  return {d_before * c.yy + d_after * b.yy,
          T(-2) * c.xy * (d_before + d_after),
          d_before * c.xx + d_after * b.xx};
}

// Inverse of a positive definite 2x2 covariance, px^-2.
template <class T>
COSPLAT_HD Sym2<T> Conic(const Sym2<T>& c) {
  const T inv_det = T(1) / Determinant(c);
  return {c.yy * inv_det, -c.xy * inv_det, c.xx * inv_det};
}
// dA^-1 = -A^-1 dA A^-1, given the conic itself.
template <class T>
COSPLAT_HD Sym2<T> ConicVjp(const Sym2<T>& conic, const Sym2<T>& d) {
  const T a = conic.xx, b = conic.xy, c = conic.yy;
  const T two(2);
  return {-(a * a * d.xx + a * b * d.xy + b * b * d.yy),
          -(two * a * b * d.xx + (a * c + b * b) * d.xy + two * b * c * d.yy),
          -(b * b * d.xx + b * c * d.xy + c * c * d.yy)};
}

COSPLAT_MATH_END
#endif
