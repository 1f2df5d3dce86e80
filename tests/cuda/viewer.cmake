# The viewer on the same emulation, with OpenGL: Mesa's on a virtual display.
add_library(cosplat_cuda_gl_on_host STATIC
  ${PROJECT_SOURCE_DIR}/splat/cuda/gl_texture.cpp ${PROJECT_SOURCE_DIR}/splat/device_texture.cpp
  ${emulation}/gl_interop.cpp)
target_compile_definitions(cosplat_cuda_gl_on_host PRIVATE COSPLAT_HAS_CUDA=1)
target_link_libraries(cosplat_cuda_gl_on_host
  PUBLIC cosplat_cuda_on_host OpenGL::GL PRIVATE cosplat::options)

add_executable(cosplat_test_viewer_on_host gl_texture_test.cpp)
target_link_libraries(cosplat_test_viewer_on_host PRIVATE
  cosplat::viewer cosplat_cuda_gl_on_host cosplat_avatar_cuda_on_host cosplat::avatar_study
  cosplat::procedural PkgConfig::glfw3 cosplat::options GTest::gtest_main)
add_test(NAME on_host.viewer COMMAND cosplat_test_viewer_on_host)
# As that of tests/viewer.
set_tests_properties(on_host.viewer PROPERTIES
  TIMEOUT 300 SKIP_REGULAR_EXPRESSION "Xvfb is not installed")
