cosplat_test(live
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/documented_sender_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/drive_address_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/json_frame_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/json_source_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/newest_packets_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/osc_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/recording_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/sender_clock_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/vmc_source_test.cpp
  LIBRARIES cosplat::live cosplat::player)
cosplat_test(guard
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/guard_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/smoother_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/soft_range_test.cpp
  LIBRARIES cosplat::live)

# `./run test` installs liblo; builds without it leave this out.
pkg_check_modules(liblo QUIET IMPORTED_TARGET liblo)
if(liblo_FOUND)
  cosplat_test(osc_liblo
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/osc_liblo_test.cpp
    LIBRARIES cosplat::live PkgConfig::liblo)
else()
  message(STATUS "liblo was not found: OSC is not tested against it")
endif()
