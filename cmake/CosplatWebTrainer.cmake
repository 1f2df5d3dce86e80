# The trainer's half of the web build: `cosplat avatar` as a module. Besides what the player needs: nanoflann's and CLI11's headers, and Ceres, which cmake/web/ceres.sh builds from
# the distribution's source.
set(COSPLAT_CERES ${PROJECT_BINARY_DIR}/ceres)
if(NOT EXISTS ${COSPLAT_CERES}/build/lib/libceres.a)
  message(FATAL_ERROR "${COSPLAT_CERES}/build/lib/libceres.a is missing: cmake/web/ceres.sh "
          "${COSPLAT_CERES} makes it, as ./run web does")
endif()
add_library(Ceres::ceres STATIC IMPORTED)
set_target_properties(Ceres::ceres PROPERTIES IMPORTED_LOCATION ${COSPLAT_CERES}/build/lib/libceres.a)
target_include_directories(Ceres::ceres SYSTEM INTERFACE ${COSPLAT_CERES}/source/include
  ${COSPLAT_CERES}/source/internal/ceres/miniglog ${COSPLAT_CERES}/build/include ${COSPLAT_HEADERS})
target_link_libraries(Ceres::ceres INTERFACE Eigen3::Eigen)
cosplat_header_library(nanoflann::nanoflann)
cosplat_header_library(CLI11::CLI11)

target_sources(cosplat_base PRIVATE
  splat/base/state_file.cpp
  splat/base/zip_writer_stored.cpp
  splat/media/exif.cpp
  splat/media/face_part.cpp
  splat/media/frame_cuts.cpp
  splat/media/image_filters.cpp
  splat/media/image_filters_web.cpp
  splat/media/image_glance.cpp
  splat/media/image_header.cpp
  splat/media/image_io_web.cpp
  splat/media/matte.cpp
  splat/media/refine_mattes.cpp
  splat/media/signed_distance.cpp
  splat/media/still_background.cpp
  splat/media/write_image.cpp)
target_link_libraries(cosplat_base PRIVATE TBB::tbb)
add_library(cosplat::media ALIAS cosplat_base)
target_sources(cosplat_io PRIVATE splat/io/cameras_json.cpp splat/io/color_weights.cpp)
add_subdirectory(splat/train)
cosplat_library(eval splat/eval/metrics.cpp)
target_link_libraries(cosplat_eval PUBLIC cosplat::base PRIVATE cosplat::train)
cosplat_library(lpips splat/eval/lpips.cpp splat/onnx/onnx_net_web.cpp)
target_link_libraries(cosplat_lpips PUBLIC cosplat::base cosplat::train PRIVATE TBB::tbb)
target_sources(cosplat_flame_track PRIVATE
  flame/focal.cpp
  flame/io/imavatar_writer.cpp
  flame/io/track_check.cpp
  flame/io/track_fit.cpp
  flame/io/track_images.cpp
  flame/io/track_masks.cpp)
target_link_libraries(cosplat_flame_track PRIVATE TBB::tbb)
add_subdirectory(flame/fit)
add_subdirectory(avatar/train)
add_subdirectory(assets)
add_subdirectory(apps/charts)
add_subdirectory(apps/web/trainer)
