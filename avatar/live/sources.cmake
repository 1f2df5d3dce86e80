# cosplat::live: where a live face comes from, as parameters at a time, and the rule for bad frames.
cosplat_library(live
  ${CMAKE_CURRENT_LIST_DIR}/guard.cpp
  ${CMAKE_CURRENT_LIST_DIR}/recording.cpp
  ${CMAKE_CURRENT_LIST_DIR}/smoother.cpp
  ${CMAKE_CURRENT_LIST_DIR}/soft_range.cpp
  ${CMAKE_CURRENT_LIST_DIR}/source.cpp)
target_link_libraries(cosplat_live PUBLIC cosplat::binding cosplat::flame PRIVATE cosplat::player cosplat::flame_track)
