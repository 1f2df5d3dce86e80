# cosplat::study: ways in which splatting fails, the naive form beside ours (`cosplat study
# --stability`, docs/stability.md). Nothing else links it.
cosplat_library(study
  ${CMAKE_CURRENT_LIST_DIR}/basis_cases.cpp
  ${CMAKE_CURRENT_LIST_DIR}/basis_floats.cpp
  ${CMAKE_CURRENT_LIST_DIR}/basis_forms.cpp
  ${CMAKE_CURRENT_LIST_DIR}/basis_packs.cpp
  ${CMAKE_CURRENT_LIST_DIR}/blending_cases.cpp
  ${CMAKE_CURRENT_LIST_DIR}/exact_basis.cpp
  ${CMAKE_CURRENT_LIST_DIR}/naive_render.cpp
  ${CMAKE_CURRENT_LIST_DIR}/projection_cases.cpp
  ${CMAKE_CURRENT_LIST_DIR}/stability.cpp
  ${CMAKE_CURRENT_LIST_DIR}/test_scene.cpp
  ${CMAKE_CURRENT_LIST_DIR}/training_cases.cpp)
target_link_libraries(cosplat_study PUBLIC cosplat::splat PRIVATE hwy::hwy TBB::tbb)
# One sample at a time, to compare packs with.
set_source_files_properties(
  ${CMAKE_CURRENT_LIST_DIR}/basis_floats.cpp
  PROPERTIES COMPILE_OPTIONS "-O3;-fno-tree-vectorize;-fno-math-errno")
# The instruction sets of the blend loop (splat/CMakeLists.txt).
set_source_files_properties(
  ${CMAKE_CURRENT_LIST_DIR}/basis_packs.cpp
  PROPERTIES COMPILE_OPTIONS "-O3;-fno-trapping-math;-fno-math-errno" COMPILE_DEFINITIONS
  "HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SSE4|HWY_AVX3_DL)")
