# Training: losses, optimiser, density control, schedules, the loop itself.
cosplat_test(train
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/loss_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/metrics_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/optimizer_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/morton_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/prune_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/pruner_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/budget_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/importance_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/schedule_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/initialize_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/reduced_frames_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/sweep_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/density_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/trainer_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/dcsh_is_sh_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/pack_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/failure_modes_test.cpp
  LIBRARIES cosplat::splat hwy::hwy TBB::tbb)
# Counts every allocation of its process.
cosplat_test(allocation
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/allocation_test.cpp
  LIBRARIES cosplat::splat TBB::tbb)
