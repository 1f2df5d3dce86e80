# The libraries of the lean build (cmake/CosplatLean.cmake) under their usual names, without what
# needs OpenCV, nlohmann_json, libzip or tinygltf.
cosplat_library(base base/image_bytes.cpp base/skipped.cpp)
cosplat_library(render ${COSPLAT_RENDER_SOURCES})
target_link_libraries(cosplat_render PUBLIC cosplat::base PRIVATE hwy::hwy TBB::tbb)
cosplat_library(splat
  bands.cpp density.cpp host_step_engine.cpp importance.cpp initialize.cpp loss.cpp metrics.cpp
  morton.cpp optimizer.cpp reduced_frames.cpp sweep.cpp trainer.cpp bench/synthetic_view.cpp cpu/adam_runs.cpp cpu/ssim_band.cpp
  ${COSPLAT_PRUNE_SOURCES})
target_link_libraries(cosplat_splat PUBLIC cosplat::render PRIVATE hwy::hwy TBB::tbb nanoflann::nanoflann)
include(${CMAKE_CURRENT_SOURCE_DIR}/cuda/sources.cmake)
