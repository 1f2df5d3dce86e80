# The web build (preset `web`, Emscripten): avatars' player and the splat renderer as WebAssembly
# modules, for the npm package in apps/web. From Debian's emscripten and the headers of Highway,
# nlohmann-json, Eigen, tinygltf and stb; libraries of the machine itself cannot be linked.
#
# One compilation, linked twice: with shared memory and threads for pages that are cross-origin
# isolated, without for all others.
set(COSPLAT_HEADERS ${PROJECT_BINARY_DIR}/headers)  # of these packages, and nothing else of /usr/include
foreach(header hwy nlohmann eigen3/Eigen tiny_gltf.h stb nanoflann.hpp CLI)
  if(NOT EXISTS /usr/include/${header})
    message(FATAL_ERROR "/usr/include/${header} is missing: the web build needs libhwy-dev, libnanoflann-dev, libcli11-dev, "
            "nlohmann-json3-dev, libeigen3-dev, libtinygltf-dev and libstb-dev")
  endif()
  get_filename_component(name ${header} NAME)
  file(MAKE_DIRECTORY ${COSPLAT_HEADERS})
  file(CREATE_LINK /usr/include/${header} ${COSPLAT_HEADERS}/${name} SYMBOLIC)
endforeach()
function(cosplat_header_library name)
  add_library(${name} INTERFACE IMPORTED)
  target_include_directories(${name} SYSTEM INTERFACE ${COSPLAT_HEADERS})
endfunction()
cosplat_header_library(hwy::hwy)
target_compile_definitions(hwy::hwy INTERFACE HWY_COMPILE_ONLY_STATIC)  # one target, WebAssembly's
cosplat_header_library(Eigen3::Eigen)
cosplat_header_library(nlohmann_json::nlohmann_json)
cosplat_header_library(TinyGLTF::TinyGLTF)
target_compile_definitions(TinyGLTF::TinyGLTF INTERFACE
  TINYGLTF_NO_STB_IMAGE TINYGLTF_NO_STB_IMAGE_WRITE TINYGLTF_NO_EXTERNAL_IMAGE)
cosplat_header_library(stb)
add_library(TBB::tbb INTERFACE IMPORTED)
target_include_directories(TBB::tbb INTERFACE ${PROJECT_SOURCE_DIR}/cmake/lean)

# The machine's node does not look where Debian's packages for node are.
set_property(GLOBAL PROPERTY RULE_LAUNCH_LINK
  "${CMAKE_COMMAND} -E env NODE_PATH=/usr/share/nodejs:/usr/lib/nodejs")
add_compile_options(-msimd128 -pthread -fwasm-exceptions)
include_directories(${PROJECT_SOURCE_DIR}/cmake/web)

# The libraries under their usual names, without what reads images and listens to sockets.
cosplat_library(base
  splat/base/camera_pose.cpp
  splat/media/codecs_web.cpp
  splat/base/data_files.cpp
  splat/base/file_kind.cpp
  splat/base/files.cpp
  splat/media/image_bytes.cpp
  splat/base/json.cpp
  splat/base/npy.cpp
  splat/base/npz.cpp
  splat/base/process_web.cpp
  splat/base/sha256.cpp
  splat/base/skipped.cpp
  splat/base/text.cpp
  splat/base/unpacked_file.cpp
  splat/base/world_frame.cpp
  splat/base/zip_reader_stb.cpp)
target_link_libraries(cosplat_base PUBLIC nlohmann_json::nlohmann_json PRIVATE stb)
add_subdirectory(splat/device)
add_subdirectory(splat/render)
cosplat_library(io
  splat/io/axes.cpp
  splat/io/glb.cpp
  splat/io/glb_check.cpp
  splat/io/glb_tinygltf.cpp
  splat/io/packed_values.cpp
  splat/io/ply.cpp
  splat/io/ply_layouts.cpp
  splat/io/ply_reader.cpp
  splat/io/ply_splats.cpp
  splat/io/sog_reader.cpp
  splat/io/splat_file.cpp
  splat/io/splat_primitive.cpp
  splat/io/splat_records.cpp
  splat/io/splat_values.cpp
  splat/io/spz.cpp)
target_link_libraries(cosplat_io PUBLIC cosplat::base cosplat::render
                      PRIVATE TinyGLTF::TinyGLTF hwy::hwy TBB::tbb)
# Its functions are in a library of the machine; here they are compiled from its header.
set_source_files_properties(splat/io/glb_tinygltf.cpp PROPERTIES
  COMPILE_DEFINITIONS TINYGLTF_IMPLEMENTATION)
cosplat_library(flame
  flame/added_mesh.cpp
  flame/blendshape_names.cpp
  flame/eyelids.cpp
  flame/halfedges_plain.cpp
  flame/io/model_file.cpp
  flame/io/pickle.cpp
  flame/io/pickle_arrays.cpp
  flame/io/pickle_input.cpp
  flame/io/pickle_machine.cpp
  flame/model.cpp
  flame/mouth.cpp
  flame/pose.cpp
  flame/posing.cpp
  flame/topology.cpp
  flame/vhap_teeth.cpp)
target_link_libraries(cosplat_flame PUBLIC cosplat::base PRIVATE Eigen3::Eigen TBB::tbb)
cosplat_library(flame_track
  flame/io/driving_npz.cpp
  flame/io/imavatar.cpp
  flame/io/insta.cpp
  flame/io/landmarks.cpp
  flame/io/metrical.cpp
  flame/io/smirk.cpp
  flame/io/torch_file.cpp
  flame/io/track_files.cpp
  flame/io/track_unit.cpp
  flame/io/vhap.cpp
  flame/track.cpp)
target_link_libraries(cosplat_flame_track PUBLIC cosplat::base PRIVATE cosplat::flame)
add_subdirectory(avatar/model)
add_subdirectory(avatar/surface)
cosplat_library(avatar_io avatar/io/avatar_file.cpp avatar/io/binding_reader.cpp
  avatar/io/binding_writer.cpp)
target_link_libraries(cosplat_avatar_io PUBLIC cosplat::surface cosplat::io)
add_subdirectory(avatar/play)
add_subdirectory(avatar/live)
add_subdirectory(avatar/plugin)
add_subdirectory(apps/web)
include(CosplatWebTrainer)
