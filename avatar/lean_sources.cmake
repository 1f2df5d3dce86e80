# Of avatars the lean build (cmake/CosplatLean.cmake) has the surface and the binding, and both on the
# device.
set(avatar ${CMAKE_CURRENT_LIST_DIR})
cosplat_library(binding
  ${avatar}/binding.cpp ${avatar}/embed_packs.cpp ${avatar}/released_binding.cpp
  ${avatar}/surface.cpp ${avatar}/surface_packs.cpp ${PROJECT_SOURCE_DIR}/tests/gpu/lean_topology.cpp)
target_link_libraries(cosplat_binding PUBLIC cosplat::base PRIVATE hwy::hwy TBB::tbb)
set_source_files_properties(${avatar}/embed_packs.cpp ${avatar}/surface_packs.cpp
  PROPERTIES COMPILE_OPTIONS "-O3;-fno-trapping-math;-fno-math-errno")
include(${avatar}/cuda/sources.cmake)
