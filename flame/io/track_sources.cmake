# cosplat::flame_track: tracked videos and driving sequences.
cosplat_library(flame_track
  ${CMAKE_CURRENT_LIST_DIR}/driving_npz.cpp
  ${CMAKE_CURRENT_LIST_DIR}/imavatar.cpp
  ${CMAKE_CURRENT_LIST_DIR}/track_pictures.cpp
  ${CMAKE_CURRENT_LIST_DIR}/vhap.cpp
  ${CMAKE_CURRENT_LIST_DIR}/../track.cpp)
target_link_libraries(cosplat_flame_track PUBLIC cosplat::base)
