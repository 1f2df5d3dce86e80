cosplat_test(data
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/basis_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/io_cameras_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/io_colmap_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/io_ply_compressed_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/io_ply_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/io_real_data_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/io_transforms_test.cpp
  LIBRARIES cosplat::data cosplat::render)
