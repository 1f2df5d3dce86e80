# Every Gaussian at its own degree.
cosplat_test(bands
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/bands_test.cpp ${CMAKE_CURRENT_LIST_DIR}/bands_training_test.cpp
  LIBRARIES cosplat::splat TBB::tbb)
