# cosplat::plugin: libcosplat.so, whose C interface is avatar/plugin/cosplat.h. It has the player
# inside and shows nothing else.
add_library(cosplat_plugin SHARED
  ${CMAKE_CURRENT_LIST_DIR}/api_avatar.cpp
  ${CMAKE_CURRENT_LIST_DIR}/api_frame.cpp
  ${CMAKE_CURRENT_LIST_DIR}/api_live.cpp
  ${CMAKE_CURRENT_LIST_DIR}/boundary.cpp
  ${CMAKE_CURRENT_LIST_DIR}/depth_pass.cpp
  ${CMAKE_CURRENT_LIST_DIR}/handle_table.cpp
  ${CMAKE_CURRENT_LIST_DIR}/host_camera.cpp
  ${CMAKE_CURRENT_LIST_DIR}/instance.cpp
  ${CMAKE_CURRENT_LIST_DIR}/live_face.cpp
  ${CMAKE_CURRENT_LIST_DIR}/live_parameters.cpp)
add_library(cosplat::plugin ALIAS cosplat_plugin)
# While the major version is 0, a minor one may change the interface.
set_target_properties(cosplat_plugin PROPERTIES
  OUTPUT_NAME cosplat
  EXPORT_NAME plugin
  VERSION ${PROJECT_VERSION}
  SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
  CXX_VISIBILITY_PRESET hidden
  VISIBILITY_INLINES_HIDDEN ON
  LINK_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/exports.map)
target_include_directories(cosplat_plugin INTERFACE
  $<BUILD_INTERFACE:${CMAKE_CURRENT_LIST_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_link_libraries(cosplat_plugin
  PRIVATE cosplat::avatar_file cosplat::live cosplat::player cosplat::player_device $<BUILD_INTERFACE:cosplat::options>)
# The version script hides what the static libraries define; of the libraries that they link, only
# those that something here calls are loaded.
target_link_options(cosplat_plugin PRIVATE
  LINKER:--version-script=${CMAKE_CURRENT_LIST_DIR}/exports.map LINKER:--exclude-libs,ALL
  LINKER:--as-needed)
