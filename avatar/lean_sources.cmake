# Of heads and avatars the lean build (cmake/CosplatLean.cmake) has posing, the made head, the binding,
# walking, the player and training from pictures in memory, and what of them is done on the device.
set(avatar ${CMAKE_CURRENT_LIST_DIR})
set(flame ${PROJECT_SOURCE_DIR}/flame)
cosplat_library(flame ${flame}/model.cpp ${flame}/pose.cpp ${flame}/posing.cpp
  ${PROJECT_SOURCE_DIR}/tests/gpu/lean_topology.cpp)
target_link_libraries(cosplat_flame PUBLIC cosplat::base PRIVATE Eigen3::Eigen TBB::tbb)
include(${flame}/procedural_sources.cmake)
cosplat_library(binding
  ${avatar}/binding.cpp ${avatar}/embed_packs.cpp ${avatar}/released_binding.cpp
  ${avatar}/sample.cpp ${avatar}/surface.cpp ${avatar}/surface_packs.cpp ${avatar}/walk.cpp)
target_link_libraries(cosplat_binding
  PUBLIC cosplat::base cosplat::flame PRIVATE hwy::hwy TBB::tbb)
set_source_files_properties(${avatar}/embed_packs.cpp ${avatar}/surface_packs.cpp
  PROPERTIES COMPILE_OPTIONS "-O3;-fno-trapping-math;-fno-math-errno")
cosplat_library(player
  ${avatar}/avatar_mesh.cpp ${avatar}/picture_bytes.cpp ${avatar}/playback.cpp ${avatar}/player.cpp
  ${avatar}/preview.cpp)
target_link_libraries(cosplat_player
  PUBLIC cosplat::binding cosplat::render cosplat::flame PRIVATE TBB::tbb)
cosplat_library(avatar_study ${avatar}/study/painted_avatar.cpp)
target_link_libraries(cosplat_avatar_study PUBLIC cosplat::player cosplat::procedural)
cosplat_library(avatar
  ${avatar}/silhouette.cpp ${avatar}/trained_range.cpp ${avatar}/trainer.cpp
  ${avatar}/trainer_density.cpp ${avatar}/trainer_start.cpp
  ${PROJECT_SOURCE_DIR}/tests/gpu/lean_track.cpp)
target_link_libraries(cosplat_avatar PUBLIC cosplat::player cosplat::splat PRIVATE TBB::tbb)
include(${avatar}/cuda/sources.cmake)
