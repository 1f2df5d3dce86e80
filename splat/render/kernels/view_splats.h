// Element-wise stage: one Gaussian in the world -> the splat that another renderer draws for a
// view, splat/render/view_splats.h.
#if defined(COSPLAT_SPLAT_KERNELS_VIEW_SPLATS_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_KERNELS_VIEW_SPLATS_H_
#undef COSPLAT_SPLAT_KERNELS_VIEW_SPLATS_H_
#else
#define COSPLAT_SPLAT_KERNELS_VIEW_SPLATS_H_
#endif

#include <limits>

#include "splat/render/kernels/project.h"

COSPLAT_MATH_BEGIN

struct ViewSplatKernel {
  static constexpr float kUnseen = std::numeric_limits<float>::infinity();

  WorldGaussians gaussians;
  ViewParameters view;
  float blur_variance;  // px^2, added to both variances of the footprint by way of the scales
  float* centers;       // [count, 4]
  float* colors;        // [count, 4]
  float* scales;        // [count, 4]
  float* rotations;     // [count, 4]
  float* depths;        // [count] world units; infinite where it cannot be seen

  template <class T>
  COSPLAT_HD void Run(const Rows& rows) const {
    const Vec3<T> position = LoadVec3<T>(gaussians.position, rows);
    const T depth = ToCamera(ToPinhole<T>(view), position).z;
    const Quat<T> q = LoadQuat<T>(gaussians.rotation, rows);
    const T opacity = Sigmoid(LoadScalar<T>(gaussians.opacity_logit, rows));
    Vec3<T> direction = ColorViewOf(gaussians, view, position, rows).direction;
    if (view.folds_direction) direction = Fold(direction);
    const Vec3<T> color = WithDegree(HighestDegree(gaussians, view, rows),
                                     ColorOf<T>{gaussians, view, rows, direction});
    // An isotropic Gaussian of this variance at this depth has that footprint; added to an
    // anisotropic one, it changes the scales only.
    const T widening = T(blur_variance / (view.fx * view.fy)) * depth * depth;
    const Vec3<T> s = LoadVec3<T>(gaussians.scale_log, rows);
    const Vec3<T> scale{Widened(s.x, widening), Widened(s.y, widening), Widened(s.z, widening)};

    auto drawn = And(depth > T(view.near_plane), Dot(q, q) > T(kMinQuaternionNorm2));
    drawn = And(drawn, And(IsFinite(color.x), And(IsFinite(color.y), IsFinite(color.z))));
    drawn = And(drawn, And(IsFinite(scale.x), And(IsFinite(scale.y), IsFinite(scale.z))));
    const Quat<T> unit = Normalize(q);
    const T none(0), one(1);
    const T center[4] = {position.x, position.y, position.z, none};
    const T shown[4] = {Select(drawn, color.x, none),
                        Select(drawn, color.y, none),
                        Select(drawn, color.z, none),
                        Select(drawn, opacity, none)};
    const T size[4] = {Select(drawn, scale.x, one),
                       Select(drawn, scale.y, one),
                       Select(drawn, scale.z, one),
                       none};
    const T turn[4] = {Select(drawn, unit.w, one),
                       Select(drawn, unit.x, none),
                       Select(drawn, unit.y, none),
                       Select(drawn, unit.z, none)};
    StoreRows<4>(center, centers, 4, rows);
    StoreRows<4>(shown, colors, 4, rows);
    StoreRows<4>(size, scales, 4, rows);
    const T key[1] = {Select(drawn, depth, T(kUnseen))};
    StoreRows<4>(turn, rotations, 4, rows);
    StoreRows<1>(key, depths, 1, rows);
  }

 private:
  template <class T>
  COSPLAT_HD static T Widened(const T& scale_log, const T& variance) {
    return Sqrt(Exp(T(2) * scale_log) + variance);
  }
};

COSPLAT_MATH_END
#endif
