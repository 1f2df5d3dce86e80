cosplat_test(avatar_study
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/released_test.cpp)
