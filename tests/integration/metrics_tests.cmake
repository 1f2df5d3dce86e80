add_executable(cosplat_test_metrics_command ${CMAKE_CURRENT_LIST_DIR}/metrics_test.cpp)
target_link_libraries(cosplat_test_metrics_command PRIVATE
  cosplat::base cosplat::lpips cosplat::options GTest::gtest_main)
target_compile_definitions(cosplat_test_metrics_command PRIVATE
  COSPLAT_COMMAND="$<TARGET_FILE:cosplat>")
add_dependencies(cosplat_test_metrics_command cosplat)
add_test(NAME metrics COMMAND cosplat_test_metrics_command)
