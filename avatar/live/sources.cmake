# cosplat::live: where a live face comes from, as parameters at a time.
cosplat_library(live
  ${CMAKE_CURRENT_LIST_DIR}/recording.cpp
  ${CMAKE_CURRENT_LIST_DIR}/source.cpp)
target_link_libraries(cosplat_live PUBLIC cosplat::flame PRIVATE cosplat::player cosplat::flame_track)
