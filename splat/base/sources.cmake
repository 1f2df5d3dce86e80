# cosplat::base: errors, images, cameras, files. Knows neither Gaussians nor meshes.
cosplat_library(base
  ${CMAKE_CURRENT_LIST_DIR}/camera_pose.cpp
  ${CMAKE_CURRENT_LIST_DIR}/files.cpp
  ${CMAKE_CURRENT_LIST_DIR}/image_bytes.cpp
  ${CMAKE_CURRENT_LIST_DIR}/image_header.cpp
  ${CMAKE_CURRENT_LIST_DIR}/image_io.cpp
  ${CMAKE_CURRENT_LIST_DIR}/json.cpp
  ${CMAKE_CURRENT_LIST_DIR}/npy.cpp
  ${CMAKE_CURRENT_LIST_DIR}/npz.cpp
  ${CMAKE_CURRENT_LIST_DIR}/sha256.cpp
  ${CMAKE_CURRENT_LIST_DIR}/skipped.cpp
  ${CMAKE_CURRENT_LIST_DIR}/video_io.cpp)
target_link_libraries(cosplat_base
  PUBLIC nlohmann_json::nlohmann_json
  PRIVATE opencv_core opencv_imgproc opencv_imgcodecs opencv_videoio opencv_calib3d
          PkgConfig::libzip)
