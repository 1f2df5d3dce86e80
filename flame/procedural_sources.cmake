# cosplat::procedural: a head of our own, without any file.
cosplat_library(procedural
  ${CMAKE_CURRENT_LIST_DIR}/procedural/ear_mesh.cpp
  ${CMAKE_CURRENT_LIST_DIR}/procedural/expressions.cpp
  ${CMAKE_CURRENT_LIST_DIR}/procedural/eye_mesh.cpp
  ${CMAKE_CURRENT_LIST_DIR}/procedural/mesh.cpp
  ${CMAKE_CURRENT_LIST_DIR}/procedural/mesh_builder.cpp
  ${CMAKE_CURRENT_LIST_DIR}/procedural/motion.cpp
  ${CMAKE_CURRENT_LIST_DIR}/procedural/mouth_mesh.cpp
  ${CMAKE_CURRENT_LIST_DIR}/procedural/paint_face.cpp
  ${CMAKE_CURRENT_LIST_DIR}/procedural/paint_hair.cpp
  ${CMAKE_CURRENT_LIST_DIR}/procedural/picture.cpp
  ${CMAKE_CURRENT_LIST_DIR}/procedural/raster.cpp
  ${CMAKE_CURRENT_LIST_DIR}/procedural/rig.cpp
  ${CMAKE_CURRENT_LIST_DIR}/procedural/sculpt.cpp
  ${CMAKE_CURRENT_LIST_DIR}/procedural/shading.cpp
  ${CMAKE_CURRENT_LIST_DIR}/procedural/shapes.cpp
  ${CMAKE_CURRENT_LIST_DIR}/procedural_head.cpp)
if(NOT COSPLAT_LEAN)  # it writes files
  target_sources(cosplat_procedural PRIVATE ${CMAKE_CURRENT_LIST_DIR}/procedural/video.cpp)
endif()
target_link_libraries(cosplat_procedural PUBLIC cosplat::flame PRIVATE TBB::tbb)
