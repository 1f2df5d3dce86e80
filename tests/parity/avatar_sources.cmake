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
