cosplat_test(avatar_file
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/avatar_file_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/quantised_avatar_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/trained_range_file_test.cpp
  LIBRARIES cosplat::avatar_file cosplat::splat)
