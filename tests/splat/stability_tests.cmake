cosplat_test(stability
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/stability_test.cpp
  LIBRARIES cosplat::study)
