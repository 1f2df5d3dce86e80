# One ctest for all: they share a video that takes longer to make than most of them to run.
add_executable(cosplat_test_avatar
  ${CMAKE_CURRENT_LIST_DIR}/trainer_density_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/trainer_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/trainer_track_test.cpp)
target_link_libraries(cosplat_test_avatar PRIVATE
  cosplat::avatar cosplat::procedural cosplat::options GTest::gtest_main TBB::tbb)
add_test(NAME avatar COMMAND cosplat_test_avatar)
