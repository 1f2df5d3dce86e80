# Device against CPU: one list of cases and tests, compiled for the host's emulation of a device
# (tests/cuda) and, where CUDA is built, for a real one.
set(COSPLAT_PARITY_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/loss_parity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/optimizer_parity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/parity_case.cpp
  ${CMAKE_CURRENT_LIST_DIR}/image_parity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/rasterizer_parity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/capacity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/sort_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/step_parity_test.cpp)
# Of the whole training loop.
set(COSPLAT_TRAINING_PARITY_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/density_parity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/mask_parity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/training_parity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/../support/study_rules.cpp)
# Avatars on a device against the CPU: for the host's emulation of one (tests/cuda) and for a real one
# (tests/gpu).
set(COSPLAT_PLAYER_PARITY_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/binding_parity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/player_parity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/posing_parity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/walk_parity_test.cpp)
set(COSPLAT_AVATAR_TRAINING_PARITY_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/avatar_density_parity_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/avatar_training_parity_test.cpp)
