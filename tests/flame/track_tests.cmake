cosplat_test(track
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/track_real_data_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/track_test.cpp
  LIBRARIES cosplat::flame cosplat::flame_track)
