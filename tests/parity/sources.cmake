# Device against CPU: one list of cases and tests, compiled for the host's emulation of a device
# (tests/cuda) and, where CUDA is built, for a real one.
set(COSPLAT_PARITY_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/loss_parity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/optimizer_parity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/parity_case.cpp
  ${CMAKE_CURRENT_LIST_DIR}/picture_parity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/rasterizer_parity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/room_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/sort_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/step_parity_test.cpp)
# Of the whole training loop.
set(COSPLAT_TRAINING_PARITY_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/density_parity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/mask_parity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/training_parity_test.cpp)
