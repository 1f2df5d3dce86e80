# Installs the libraries with their headers and an exported config, so that another project can
# find_package(cosplat) and link cosplat::render or what else it needs; and libcosplat.so with
# cosplat.h and a pkg-config file, for hosts in any language. apps/ installs its commands.
include(CMakePackageConfigHelpers)

# Headers that are not for others, by the beginning of their path: they are not installed, and apps/
# may not include them (tests/layering_test.cpp). Only they may include OpenCV, oneTBB or Highway.
set(COSPLAT_PRIVATE_HEADERS
  avatar/io/binding_extension.h
  avatar/live/blendshape_matrix.h
  avatar/live/byte_reader.h
  avatar/live/newest_packets.h
  avatar/live/osc.h
  avatar/live/packet_input.h
  avatar/live/scores_in_use.h
  avatar/live/sender_clock.h
  avatar/live/vrm_expressions.h
  avatar/plugin/boundary.h
  avatar/plugin/coded_error.h
  avatar/plugin/depth_pass.h
  avatar/plugin/handle_table.h
  avatar/plugin/host_camera.h
  avatar/plugin/instance.h
  avatar/plugin/instance_face.h
  avatar/plugin/live_parameters.h
  avatar/plugin/struct_size.h
  avatar/voice/voice_net_bytes.h
  avatar/surface/cuda/
  avatar/surface/gather_rows.h
  flame/added_mesh.h
  flame/check_parameters.h
  flame/directions.h
  flame/fit/face_texture.h
  flame/fit/field_cost.h
  flame/fit/frame_field.h
  flame/fit/frame_priors.h
  flame/fit/landmark_cost.h
  flame/fit/robust.h
  flame/fit/silhouette.h
  flame/halfedges.h
  flame/io/pickle
  flame/io/track_fit.h
  flame/io/track_layouts.h
  flame/kernels/
  splat/base/compression.h
  splat/media/libav.h
  splat/media/opencv_mat.h
  splat/media/sound_track.h
  splat/media/video_stream.h
  splat/onnx/onnx_file.h
  splat/onnx/onnx_p
  splat/media/webp.h
  splat/device/cuda/
  splat/device/for_each.h
  splat/device/gather.h
  splat/device/sum_tree.h
  splat/io/glb
  splat/io/packed_values.h
  splat/io/ply_
  splat/io/scene_fit.h
  splat/io/sog_format.h
  splat/io/splat_primitive.h
  splat/io/splat_values.h
  splat/io/view_files.h
  splat/levels/merge.h
  splat/train/prune/rules.h
  splat/render/cpu/
  splat/render/cuda/
  splat/train/cuda/
  splat/train/loss/cpu/
  splat/train/loss/cuda/
  splat/train/optimize/cpu/
  splat/train/optimize/kernels/adam.h
  splat/train/blocks/kernels/layers.h
  splat/train/ranks/kernels/shards.h)

# Call it when every target exists.
function(cosplat_install)
  get_property(libraries GLOBAL PROPERTY COSPLAT_LIBRARIES)
  install(TARGETS ${libraries} EXPORT cosplatTargets
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
  # By itself, since a host in C has none of the packages that the libraries need.
  install(TARGETS cosplat_plugin EXPORT cosplatPluginTargets
          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(FILES ${PROJECT_SOURCE_DIR}/avatar/plugin/cosplat.h
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  # From the file's own folder, so that an installation may be moved.
  file(RELATIVE_PATH prefix_from_pc
    ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
  configure_file(
    ${PROJECT_SOURCE_DIR}/cmake/cosplat.pc.in ${PROJECT_BINARY_DIR}/cosplat.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/cosplat.pc
          DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
  list(JOIN COSPLAT_PRIVATE_HEADERS "|" private)
  string(REPLACE "." "\\." private "${private}")
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/splat ${PROJECT_SOURCE_DIR}/flame
                    ${PROJECT_SOURCE_DIR}/avatar ${PROJECT_SOURCE_DIR}/assets
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cosplat COMPONENT development
          # splats.h is of the browser's module, whose functions libcosplat.so does not have.
          FILES_MATCHING PATTERN "*.h" REGEX "/(${private}|avatar/plugin/splats\\.h)" EXCLUDE)

  set(config_folder ${CMAKE_INSTALL_LIBDIR}/cmake/cosplat)
  install(EXPORT cosplatTargets NAMESPACE cosplat:: DESTINATION ${config_folder}
          COMPONENT development)
  install(EXPORT cosplatPluginTargets NAMESPACE cosplat:: DESTINATION ${config_folder})
  configure_package_config_file(
    ${PROJECT_SOURCE_DIR}/cmake/cosplatConfig.cmake.in ${PROJECT_BINARY_DIR}/cosplatConfig.cmake
    INSTALL_DESTINATION ${config_folder})
  write_basic_package_version_file(
    ${PROJECT_BINARY_DIR}/cosplatConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(FILES
    ${PROJECT_BINARY_DIR}/cosplatConfig.cmake
    ${PROJECT_BINARY_DIR}/cosplatConfigVersion.cmake
    ${PROJECT_SOURCE_DIR}/cmake/FindNetworks.cmake
    ${PROJECT_SOURCE_DIR}/cmake/FindOpenCV.cmake
    DESTINATION ${config_folder})
endfunction()
