cosplat_test(data
  SOURCES
    io_colmap_test.cpp
  LIBRARIES cosplat::data cosplat::render)
