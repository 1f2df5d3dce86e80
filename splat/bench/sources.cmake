# cosplat::bench: what `cosplat bench` measures of the machine, the blend loop and the training step.
cosplat_library(bench
  ${CMAKE_CURRENT_LIST_DIR}/dense_tile.cpp
  ${CMAKE_CURRENT_LIST_DIR}/fma_peak.cpp
  ${CMAKE_CURRENT_LIST_DIR}/half_adam.cpp
  ${CMAKE_CURRENT_LIST_DIR}/held_memory.cpp
  ${CMAKE_CURRENT_LIST_DIR}/machine.cpp
  ${CMAKE_CURRENT_LIST_DIR}/pair_counts.cpp
  ${CMAKE_CURRENT_LIST_DIR}/step_timer.cpp
  ${CMAKE_CURRENT_LIST_DIR}/synthetic_view.cpp)
target_link_libraries(cosplat_bench PUBLIC cosplat::render cosplat::splat
                      PRIVATE hwy::hwy TBB::tbb)
# The instruction sets of the blend loop (splat/CMakeLists.txt).
set_source_files_properties(
  ${CMAKE_CURRENT_LIST_DIR}/fma_peak.cpp ${CMAKE_CURRENT_LIST_DIR}/machine.cpp
  PROPERTIES COMPILE_OPTIONS "-O3" COMPILE_DEFINITIONS
  "HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SSE4|HWY_AVX3_DL)")
# Built as the optimiser's loop is, which it is compared with.
set_source_files_properties(
  ${CMAKE_CURRENT_LIST_DIR}/half_adam.cpp
  PROPERTIES COMPILE_OPTIONS "-O3;-fno-trapping-math;-fno-math-errno" COMPILE_DEFINITIONS
  "HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SSE4|HWY_AVX3_DL)")
