cosplat_test(player
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/playback_test.cpp ${CMAKE_CURRENT_LIST_DIR}/preview_test.cpp
  LIBRARIES cosplat::avatar_study cosplat::player cosplat::procedural cosplat::splat TBB::tbb)
