# cosplat::avatar_cuda: avatars on the device. Tests compile the same files for the host (tests/cuda).
set(COSPLAT_AVATAR_CUDA_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/device_binding.cu
  ${CMAKE_CURRENT_LIST_DIR}/device_drawer.cpp
  ${CMAKE_CURRENT_LIST_DIR}/device_mesh.cpp
  ${CMAKE_CURRENT_LIST_DIR}/device_placement.cu
  ${CMAKE_CURRENT_LIST_DIR}/device_poser.cu
  ${CMAKE_CURRENT_LIST_DIR}/device_surface.cu
  ${CMAKE_CURRENT_LIST_DIR}/device_walk.cu)
# cosplat::avatar_cuda_train: training them there.
set(COSPLAT_AVATAR_CUDA_TRAIN_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/device_avatar.cpp
  ${CMAKE_CURRENT_LIST_DIR}/hole_guard.cu)
set_property(GLOBAL PROPERTY COSPLAT_AVATAR_CUDA_SOURCES
  ${COSPLAT_AVATAR_CUDA_SOURCES} ${COSPLAT_AVATAR_CUDA_TRAIN_SOURCES})
if(COSPLAT_HAS_CUDA)
  cosplat_library(avatar_cuda ${COSPLAT_AVATAR_CUDA_SOURCES})
  target_link_libraries(cosplat_avatar_cuda PUBLIC cosplat::binding cosplat::cuda)
  target_compile_options(cosplat_avatar_cuda PRIVATE $<$<COMPILE_LANGUAGE:CUDA>:-lineinfo>)
  cosplat_library(avatar_cuda_train ${COSPLAT_AVATAR_CUDA_TRAIN_SOURCES})
  target_link_libraries(cosplat_avatar_cuda_train
    PUBLIC cosplat::avatar cosplat::avatar_cuda cosplat::cuda_train)
  target_compile_options(cosplat_avatar_cuda_train
    PRIVATE $<$<COMPILE_LANGUAGE:CUDA>:-lineinfo>)
endif()
if(COSPLAT_LEAN)
  return()
endif()

# cosplat::player_device: who draws on a device for a player.
cosplat_library(player_device ${CMAKE_CURRENT_SOURCE_DIR}/player_device.cpp)
target_link_libraries(cosplat_player_device PUBLIC cosplat::binding cosplat::device)
if(COSPLAT_HAS_CUDA)
  target_link_libraries(cosplat_player_device PRIVATE cosplat::avatar_cuda)
  target_compile_definitions(cosplat_player_device PRIVATE COSPLAT_HAS_CUDA)
endif()

# cosplat::avatar_train_device: where avatars are trained.
cosplat_library(avatar_train_device ${CMAKE_CURRENT_SOURCE_DIR}/train_device.cpp)
target_link_libraries(cosplat_avatar_train_device PUBLIC cosplat::avatar cosplat::device)
if(COSPLAT_HAS_CUDA)
  target_link_libraries(cosplat_avatar_train_device PRIVATE cosplat::avatar_cuda_train)
  target_compile_definitions(cosplat_avatar_train_device PRIVATE COSPLAT_HAS_CUDA)
endif()
