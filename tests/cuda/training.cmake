# Whole trainings on the same emulation, and what only it can show: memory that runs out.
add_executable(cosplat_test_cuda_training_on_host
  device_choice_test.cpp memory_limit_test.cpp no_wait_test.cpp scene_bench_test.cpp
  ${COSPLAT_SCENE_BENCH_SOURCES} ${COSPLAT_TRAINING_PARITY_SOURCES})
target_link_libraries(cosplat_test_cuda_training_on_host PRIVATE
  cosplat_cuda_on_host cosplat::options GTest::gtest_main)
gtest_discover_tests(cosplat_test_cuda_training_on_host TEST_PREFIX on_host. DISCOVERY_TIMEOUT 60)
