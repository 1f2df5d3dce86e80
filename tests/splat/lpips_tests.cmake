cosplat_test(lpips
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/lpips_test.cpp
  LIBRARIES cosplat::lpips opencv_core TBB::tbb)
