# One ctest for all: the cases are measured together, once.
add_executable(cosplat_test_avatar_study
  ${CMAKE_CURRENT_LIST_DIR}/naive_walk_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/released_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/stability_test.cpp)
target_link_libraries(cosplat_test_avatar_study PRIVATE
  cosplat::avatar_study cosplat::options GTest::gtest_main)
add_test(NAME avatar_study COMMAND cosplat_test_avatar_study)
