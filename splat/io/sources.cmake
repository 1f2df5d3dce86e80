# cosplat::data: scenes' photographs and cameras, splat files.
cosplat_library(data
  ${CMAKE_CURRENT_LIST_DIR}/cameras_json.cpp
  ${CMAKE_CURRENT_LIST_DIR}/colmap_binary.cpp
  ${CMAKE_CURRENT_LIST_DIR}/colmap_model.cpp
  ${CMAKE_CURRENT_LIST_DIR}/colmap_scene.cpp
  ${CMAKE_CURRENT_LIST_DIR}/colmap_text.cpp
  ${CMAKE_CURRENT_LIST_DIR}/glb.cpp
  ${CMAKE_CURRENT_LIST_DIR}/glb_check.cpp
  ${CMAKE_CURRENT_LIST_DIR}/glb_tinygltf.cpp
  ${CMAKE_CURRENT_LIST_DIR}/ply.cpp
  ${CMAKE_CURRENT_LIST_DIR}/ply_columns.cpp
  ${CMAKE_CURRENT_LIST_DIR}/ply_compressed.cpp
  ${CMAKE_CURRENT_LIST_DIR}/ply_reader.cpp
  ${CMAKE_CURRENT_LIST_DIR}/scene_data.cpp
  ${CMAKE_CURRENT_LIST_DIR}/scene_glb.cpp
  ${CMAKE_CURRENT_LIST_DIR}/splat_file.cpp
  ${CMAKE_CURRENT_LIST_DIR}/splat_primitive.cpp
  ${CMAKE_CURRENT_LIST_DIR}/transforms_scene.cpp
  ${CMAKE_CURRENT_LIST_DIR}/view_files.cpp
  ${CMAKE_CURRENT_LIST_DIR}/view_image.cpp
  ${CMAKE_CURRENT_LIST_DIR}/vq_file.cpp
  ${CMAKE_CURRENT_LIST_DIR}/../axes.cpp)
target_link_libraries(cosplat_data PUBLIC cosplat::base cosplat::render
                      PRIVATE TinyGLTF::TinyGLTF)
