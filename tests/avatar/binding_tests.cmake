cosplat_test(binding
  SOURCES
    ${CMAKE_CURRENT_SOURCE_DIR}/binding_test.cpp
    ${CMAKE_CURRENT_SOURCE_DIR}/embed_test.cpp
    ${CMAKE_CURRENT_SOURCE_DIR}/sample_test.cpp
    ${CMAKE_CURRENT_SOURCE_DIR}/surface_test.cpp
    ${CMAKE_CURRENT_SOURCE_DIR}/walk_test.cpp
  LIBRARIES cosplat::binding TBB::tbb)
