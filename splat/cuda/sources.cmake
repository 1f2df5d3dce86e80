# cosplat::cuda: the CUDA back end. Tests compile the same files for the host (tests/cuda).
set(COSPLAT_CUDA_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/adam.cu
  ${CMAKE_CURRENT_LIST_DIR}/blend_backward.cu
  ${CMAKE_CURRENT_LIST_DIR}/blend_forward.cu
  ${CMAKE_CURRENT_LIST_DIR}/cuda_rasterizer.cpp
  ${CMAKE_CURRENT_LIST_DIR}/device.cpp
  ${CMAKE_CURRENT_LIST_DIR}/device_gaussians.cpp
  ${CMAKE_CURRENT_LIST_DIR}/device_pixels.cu
  ${CMAKE_CURRENT_LIST_DIR}/device_scene.cpp
  ${CMAKE_CURRENT_LIST_DIR}/loss.cu
  ${CMAKE_CURRENT_LIST_DIR}/memory.cpp
  ${CMAKE_CURRENT_LIST_DIR}/picture_renderer.cpp
  ${CMAKE_CURRENT_LIST_DIR}/renderer.cu
  ${CMAKE_CURRENT_LIST_DIR}/sort.cu
  ${CMAKE_CURRENT_LIST_DIR}/tile_lists.cu
  ${CMAKE_CURRENT_LIST_DIR}/world_arrays.cpp)
# cosplat::cuda_train: training on it.
set(COSPLAT_CUDA_TRAIN_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/density.cu
  ${CMAKE_CURRENT_LIST_DIR}/device_memory.cpp
  ${CMAKE_CURRENT_LIST_DIR}/device_step_engine.cpp
  ${CMAKE_CURRENT_LIST_DIR}/device_steps.cpp
  ${CMAKE_CURRENT_LIST_DIR}/device_subject.cu
  ${CMAKE_CURRENT_LIST_DIR}/gather.cu
  ${CMAKE_CURRENT_LIST_DIR}/mask_learner.cu
  ${CMAKE_CURRENT_LIST_DIR}/morton.cu
  ${CMAKE_CURRENT_LIST_DIR}/photographs.cpp
  ${CMAKE_CURRENT_LIST_DIR}/population.cpp
  ${CMAKE_CURRENT_LIST_DIR}/step_parts.cu)
set_property(GLOBAL PROPERTY COSPLAT_CUDA_SOURCES ${COSPLAT_CUDA_SOURCES})
set_property(GLOBAL PROPERTY COSPLAT_CUDA_TRAIN_SOURCES ${COSPLAT_CUDA_TRAIN_SOURCES})
if(COSPLAT_HAS_CUDA)
  cosplat_library(cuda ${COSPLAT_CUDA_SOURCES})
  target_link_libraries(cosplat_cuda PUBLIC cosplat::render CUDA::cudart_static)
  target_compile_options(cosplat_cuda PRIVATE $<$<COMPILE_LANGUAGE:CUDA>:-lineinfo>)
  cosplat_library(cuda_train ${COSPLAT_CUDA_TRAIN_SOURCES})
  target_link_libraries(cosplat_cuda_train PUBLIC cosplat::splat cosplat::cuda)
  target_compile_options(cosplat_cuda_train PRIVATE $<$<COMPILE_LANGUAGE:CUDA>:-lineinfo>)
endif()

# cosplat::device: chooses between the back ends that there are.
cosplat_library(device ${CMAKE_CURRENT_LIST_DIR}/../device.cpp)
target_link_libraries(cosplat_device PUBLIC cosplat::render)
if(COSPLAT_HAS_CUDA)
  target_link_libraries(cosplat_device PRIVATE cosplat::cuda)
  target_compile_definitions(cosplat_device PRIVATE COSPLAT_HAS_CUDA)
endif()

if(NOT COSPLAT_LEAN)
  include(${CMAKE_CURRENT_LIST_DIR}/gl_sources.cmake)
endif()

# cosplat::train_device: the same for training.
cosplat_library(train_device ${CMAKE_CURRENT_LIST_DIR}/../train_device.cpp)
target_link_libraries(cosplat_train_device PUBLIC cosplat::device cosplat::splat)
if(COSPLAT_HAS_CUDA)
  target_link_libraries(cosplat_train_device PRIVATE cosplat::cuda_train)
  target_compile_definitions(cosplat_train_device PRIVATE COSPLAT_HAS_CUDA)
endif()
