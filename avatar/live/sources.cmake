# cosplat::live: where a live face comes from, as parameters at a time, and the rule for bad frames.
cosplat_library(live
  ${CMAKE_CURRENT_LIST_DIR}/arkit.cpp
  ${CMAKE_CURRENT_LIST_DIR}/blendshape_matrix.cpp
  ${CMAKE_CURRENT_LIST_DIR}/drive_address.cpp
  ${CMAKE_CURRENT_LIST_DIR}/guard.cpp
  ${CMAKE_CURRENT_LIST_DIR}/json_frame.cpp
  ${CMAKE_CURRENT_LIST_DIR}/json_source.cpp
  ${CMAKE_CURRENT_LIST_DIR}/line_input.cpp
  ${CMAKE_CURRENT_LIST_DIR}/osc.cpp
  ${CMAKE_CURRENT_LIST_DIR}/packet_input.cpp
  ${CMAKE_CURRENT_LIST_DIR}/recording.cpp
  ${CMAKE_CURRENT_LIST_DIR}/sender_clock.cpp
  ${CMAKE_CURRENT_LIST_DIR}/smoother.cpp
  ${CMAKE_CURRENT_LIST_DIR}/soft_range.cpp
  ${CMAKE_CURRENT_LIST_DIR}/source.cpp
  ${CMAKE_CURRENT_LIST_DIR}/udp_input.cpp
  ${CMAKE_CURRENT_LIST_DIR}/udp_socket.cpp
  ${CMAKE_CURRENT_LIST_DIR}/vmc_source.cpp)
target_link_libraries(cosplat_live PUBLIC cosplat::binding cosplat::flame PRIVATE cosplat::player cosplat::flame_track)
