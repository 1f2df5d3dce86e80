# cosplat::avatar_cuda: avatars on the device. Tests compile the same files for the host (tests/cuda).
set(COSPLAT_AVATAR_CUDA_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/device_binding.cu
  ${CMAKE_CURRENT_LIST_DIR}/device_surface.cu)
set_property(GLOBAL PROPERTY COSPLAT_AVATAR_CUDA_SOURCES ${COSPLAT_AVATAR_CUDA_SOURCES})
if(COSPLAT_HAS_CUDA)
  cosplat_library(avatar_cuda ${COSPLAT_AVATAR_CUDA_SOURCES})
  target_link_libraries(cosplat_avatar_cuda PUBLIC cosplat::binding cosplat::cuda)
  target_compile_options(cosplat_avatar_cuda PRIVATE $<$<COMPILE_LANGUAGE:CUDA>:-lineinfo>)
endif()
