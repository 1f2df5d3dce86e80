cosplat_test(procedural
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/procedural_raster_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/procedural_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/procedural_video_test.cpp
  LIBRARIES cosplat::procedural cosplat::flame_track TBB::tbb)
