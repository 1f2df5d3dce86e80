# Avatars on the same emulation.
get_property(avatar_cuda_sources GLOBAL PROPERTY COSPLAT_AVATAR_CUDA_SOURCES)
set(avatar_cuda_files ${avatar_cuda_sources})
list(FILTER avatar_cuda_files INCLUDE REGEX "\\.cu$")
set_source_files_properties(${avatar_cuda_files} PROPERTIES LANGUAGE CXX)
add_library(cosplat_avatar_cuda_on_host STATIC ${avatar_cuda_sources})
target_link_libraries(cosplat_avatar_cuda_on_host
  PUBLIC cosplat_cuda_on_host cosplat::avatar PRIVATE cosplat::options)

include(${PROJECT_SOURCE_DIR}/tests/parity/avatar_sources.cmake)
add_executable(cosplat_test_avatar_cuda_on_host
  avatar_memory_limit_test.cpp ${COSPLAT_PLAYER_PARITY_SOURCES}
  ${COSPLAT_AVATAR_TRAINING_PARITY_SOURCES})
target_compile_definitions(cosplat_test_avatar_cuda_on_host PRIVATE
  COSPLAT_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
target_link_libraries(cosplat_test_avatar_cuda_on_host PRIVATE
  cosplat_avatar_cuda_on_host cosplat::avatar_study cosplat::player cosplat::procedural
  cosplat::options GTest::gtest_main)
gtest_discover_tests(cosplat_test_avatar_cuda_on_host TEST_PREFIX on_host. DISCOVERY_TIMEOUT 60)

# What the benchmark has of them.
target_sources(cosplat_bench_cuda_on_host PRIVATE ${gpu}/avatar_times.cpp)
target_compile_definitions(cosplat_bench_cuda_on_host PRIVATE
  COSPLAT_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
target_link_libraries(cosplat_bench_cuda_on_host PRIVATE cosplat_avatar_cuda_on_host)
