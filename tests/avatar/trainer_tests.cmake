# One ctest for all: they share a video and an avatar that take longer to make than most of them to
# run.
add_executable(cosplat_test_avatar
  ${CMAKE_CURRENT_LIST_DIR}/avatar_mesh_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/player_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/silhouette_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/trained_range_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/trainer_density_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/trainer_system_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/trainer_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/trainer_track_test.cpp)
target_link_libraries(cosplat_test_avatar PRIVATE
  cosplat::avatar cosplat::procedural cosplat::options GTest::gtest_main TBB::tbb)
target_compile_definitions(cosplat_test_avatar PRIVATE
  COSPLAT_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
add_test(NAME avatar COMMAND cosplat_test_avatar)
