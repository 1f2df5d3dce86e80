cosplat_test(binding
  SOURCES
    ${CMAKE_CURRENT_SOURCE_DIR}/binding_test.cpp
    ${CMAKE_CURRENT_SOURCE_DIR}/embed_packs_test.cpp
    ${CMAKE_CURRENT_SOURCE_DIR}/embed_test.cpp
    ${CMAKE_CURRENT_SOURCE_DIR}/face_search_test.cpp
    ${CMAKE_CURRENT_SOURCE_DIR}/released_binding_test.cpp
    ${CMAKE_CURRENT_SOURCE_DIR}/sample_test.cpp
    ${CMAKE_CURRENT_SOURCE_DIR}/surface_test.cpp
    ${CMAKE_CURRENT_SOURCE_DIR}/walk_test.cpp
  LIBRARIES cosplat::binding hwy::hwy TBB::tbb)
# The instruction sets that the packs are built for (avatar/binding_sources.cmake).
target_compile_definitions(cosplat_test_binding PRIVATE
  "HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SSE4|HWY_AVX3_DL)")
