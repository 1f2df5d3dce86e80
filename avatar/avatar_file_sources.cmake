# cosplat::avatar_file: avatars as .glb files.
cosplat_library(avatar_file
  ${CMAKE_CURRENT_LIST_DIR}/avatar_file.cpp
  ${CMAKE_CURRENT_LIST_DIR}/io/binding_reader.cpp
  ${CMAKE_CURRENT_LIST_DIR}/io/binding_writer.cpp
  ${CMAKE_CURRENT_LIST_DIR}/quantised_avatar.cpp)
target_link_libraries(cosplat_avatar_file
  PUBLIC cosplat::binding cosplat::data cosplat::flame PRIVATE cosplat::player)
