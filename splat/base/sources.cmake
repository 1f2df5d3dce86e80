# cosplat::base: errors, images, cameras, files. Knows neither Gaussians nor meshes.
# cosplat_library(base ${CMAKE_CURRENT_SOURCE_DIR}/base/....cpp)
