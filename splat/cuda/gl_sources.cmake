# cosplat::cuda_gl: pictures of the device in OpenGL's textures. cosplat::device_texture: who does that.
cosplat_library(device_texture ${CMAKE_CURRENT_LIST_DIR}/../device_texture.cpp)
target_link_libraries(cosplat_device_texture PUBLIC cosplat::device)
if(COSPLAT_HAS_CUDA)
  cosplat_library(cuda_gl ${CMAKE_CURRENT_LIST_DIR}/gl_texture.cpp)
  target_link_libraries(cosplat_cuda_gl PUBLIC cosplat::cuda)
  target_include_directories(cosplat_cuda_gl PRIVATE ${OPENGL_INCLUDE_DIR})  # nothing of it is linked
  target_link_libraries(cosplat_device_texture PRIVATE cosplat::cuda_gl)
  target_compile_definitions(cosplat_device_texture PRIVATE COSPLAT_HAS_CUDA)
endif()
