# A scene for machines that can decode no pictures: written here, read there (packed_scene.h).
set(COSPLAT_PACKED_SCENE_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/packed_scene.cpp ${PROJECT_SOURCE_DIR}/apps/cosplat/run/scene_start.cpp
  ${PROJECT_SOURCE_DIR}/apps/cosplat/options/presets.cpp
  ${PROJECT_SOURCE_DIR}/apps/cosplat/options/train_options.cpp)
set(COSPLAT_SCENE_BENCH_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/scene_times.cpp ${COSPLAT_PACKED_SCENE_SOURCES})
if(COSPLAT_LEAN)
  return()
endif()
add_executable(cosplat_pack_scene
  ${CMAKE_CURRENT_LIST_DIR}/pack_scene.cpp ${CMAKE_CURRENT_LIST_DIR}/packed_scene.cpp)
target_link_libraries(cosplat_pack_scene PRIVATE cosplat::train cosplat::options)
cosplat_test(packed_scene
  SOURCES ${PROJECT_SOURCE_DIR}/tests/splat/packed_scene_test.cpp ${COSPLAT_PACKED_SCENE_SOURCES}
  LIBRARIES cosplat::eval cosplat::train cosplat::device)
