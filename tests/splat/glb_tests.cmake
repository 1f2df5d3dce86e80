cosplat_test(glb
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/axes_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/glb_test.cpp
  LIBRARIES cosplat::data)
