cosplat_test(vq
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/vq_file_test.cpp ${CMAKE_CURRENT_LIST_DIR}/vq_test.cpp
  LIBRARIES cosplat::splat TBB::tbb)
