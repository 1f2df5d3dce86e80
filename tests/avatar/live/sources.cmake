cosplat_test(live
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/recording_test.cpp
  LIBRARIES cosplat::live cosplat::player)
