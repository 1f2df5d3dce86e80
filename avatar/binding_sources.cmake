# cosplat::binding: Gaussians on triangles. Embedding, its derivative, walking, sampling.
cosplat_library(binding
  ${CMAKE_CURRENT_SOURCE_DIR}/binding.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/sample.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/surface.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/walk.cpp)
target_link_libraries(cosplat_binding PUBLIC cosplat::base cosplat::flame PRIVATE TBB::tbb)
