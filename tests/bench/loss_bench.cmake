add_executable(cosplat_bench_loss loss_bench.cpp)
target_link_libraries(cosplat_bench_loss PRIVATE cosplat::splat cosplat::options hwy::hwy TBB::tbb)
# The instruction sets that the loss is built for (splat/CMakeLists.txt).
target_compile_definitions(cosplat_bench_loss PRIVATE
  "HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SSE4|HWY_AVX3_DL)")
