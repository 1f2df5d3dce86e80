// The namespace of the formulas. Included by every header of splat/math, guarded per SIMD target.
//
// Normally they are in cosplat::math. In a file that Highway re-includes once per instruction set
// (HWY_TARGET_INCLUDE), they are compiled once per target, inside that target's pragma, in
// cosplat::math::<target>: g++ inlines across functions only if their target options agree.
#undef COSPLAT_MATH_BEGIN
#undef COSPLAT_MATH_END
#if defined(HWY_NAMESPACE)
// The pragmas come last: g++ 14 loses what follows them in one macro.
#define COSPLAT_MATH_BEGIN                 \
  namespace cosplat::math::HWY_NAMESPACE { \
  HWY_BEFORE_NAMESPACE();
#define COSPLAT_MATH_END \
  }                      \
  HWY_AFTER_NAMESPACE();
#else
#define COSPLAT_MATH_BEGIN namespace cosplat::math {
#define COSPLAT_MATH_END }
#endif
#undef COSPLAT_HD
#if defined(__CUDACC__)
#define COSPLAT_HD __host__ __device__ inline
#else
#define COSPLAT_HD inline
#endif
