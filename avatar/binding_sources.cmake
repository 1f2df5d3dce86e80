# cosplat::binding: Gaussians on triangles. Embedding, its derivative, walking, sampling.
cosplat_library(binding
  ${CMAKE_CURRENT_SOURCE_DIR}/binding.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/embed_packs.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/released_binding.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/sample.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/surface.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/surface_packs.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/walk.cpp)
target_link_libraries(cosplat_binding PUBLIC cosplat::base cosplat::flame PRIVATE hwy::hwy TBB::tbb)

# Instruction sets as in splat/CMakeLists.txt.
set_source_files_properties(
  ${CMAKE_CURRENT_SOURCE_DIR}/embed_packs.cpp ${CMAKE_CURRENT_SOURCE_DIR}/surface_packs.cpp
  PROPERTIES COMPILE_OPTIONS "-O3;-fno-trapping-math;-fno-math-errno" COMPILE_DEFINITIONS
  "HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SSE4|HWY_AVX3_DL)")
