cosplat_test(bench
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/bench_test.cpp
  LIBRARIES cosplat::bench)
