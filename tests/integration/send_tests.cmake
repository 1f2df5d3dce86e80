add_executable(cosplat_test_send_command send_test.cpp)
target_link_libraries(cosplat_test_send_command PRIVATE
  cosplat::live cosplat::options GTest::gtest_main)
target_compile_definitions(cosplat_test_send_command PRIVATE
  COSPLAT_COMMAND="$<TARGET_FILE:cosplat>")
add_dependencies(cosplat_test_send_command cosplat)
add_test(NAME send COMMAND cosplat_test_send_command)
