cosplat_test(live
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/documented_sender_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/drive_address_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/json_frame_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/json_source_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/recording_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/sender_clock_test.cpp
  LIBRARIES cosplat::live cosplat::player)
cosplat_test(guard
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/guard_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/smoother_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/soft_range_test.cpp
  LIBRARIES cosplat::live)
