# cosplat::avatar_study: where avatars fail, the naive form beside ours (docs/stability.md).
cosplat_library(avatar_study
  ${CMAKE_CURRENT_LIST_DIR}/boundary_case.cpp
  ${CMAKE_CURRENT_LIST_DIR}/component_cases.cpp
  ${CMAKE_CURRENT_LIST_DIR}/expression_cases.cpp
  ${CMAKE_CURRENT_LIST_DIR}/fold_case.cpp
  ${CMAKE_CURRENT_LIST_DIR}/naive_walk.cpp
  ${CMAKE_CURRENT_LIST_DIR}/painted_avatar.cpp
  ${CMAKE_CURRENT_LIST_DIR}/scale_cases.cpp
  ${CMAKE_CURRENT_LIST_DIR}/sketch.cpp
  ${CMAKE_CURRENT_LIST_DIR}/stability.cpp
  ${CMAKE_CURRENT_LIST_DIR}/study_head.cpp
  ${CMAKE_CURRENT_LIST_DIR}/surface_cases.cpp
  ${CMAKE_CURRENT_LIST_DIR}/track_cases.cpp
  ${CMAKE_CURRENT_LIST_DIR}/walk_cases.cpp)
target_link_libraries(cosplat_avatar_study PUBLIC cosplat::avatar cosplat::procedural)
