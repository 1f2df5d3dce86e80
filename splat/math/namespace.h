// Where the formulas live. Included by every header of splat/math, guarded per SIMD target.
//
// Ordinarily they are in cosplat::math. A file that Highway re-includes once per instruction set
// (HWY_TARGET_INCLUDE) gets them once per target, compiled inside that target's pragma, in
// cosplat::math::<target>: g++ inlines across functions only when their target options agree.
#undef COSPLAT_MATH_BEGIN
#undef COSPLAT_MATH_END
#if defined(HWY_NAMESPACE)
#define COSPLAT_MATH_BEGIN \
  HWY_BEFORE_NAMESPACE();  \
  namespace cosplat::math::HWY_NAMESPACE {
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
