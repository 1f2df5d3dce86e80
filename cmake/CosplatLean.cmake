# The lean build (COSPLAT_LEAN, preset `gpu-tests`): the renderer and avatars' player on the CPU and on
# CUDA, losses, Adam, their parity tests and benchmark, from nvcc, CMake, a C++ compiler and what
# COSPLAT_CARRIED holds: headers of Highway (include/hwy), nanoflann (include/nanoflann.hpp) and Eigen
# (include/eigen3/Eigen/Core) and GoogleTest's sources (googletest/src and googletest/include). For a machine with a GPU and nothing else; tests/gpu/run.sh drives it.
set(COSPLAT_CARRIED "/usr" CACHE PATH "Folder with include/hwy, include/eigen3 and googletest")
find_path(COSPLAT_HIGHWAY hwy/highway.h PATHS ${COSPLAT_CARRIED}/include NO_DEFAULT_PATH REQUIRED)
find_path(COSPLAT_NANOFLANN nanoflann.hpp PATHS ${COSPLAT_CARRIED}/include NO_DEFAULT_PATH REQUIRED)
find_path(COSPLAT_EIGEN Eigen/Core PATHS ${COSPLAT_CARRIED}/include/eigen3 NO_DEFAULT_PATH REQUIRED)
find_path(COSPLAT_GOOGLETEST src/gtest-all.cc NO_DEFAULT_PATH REQUIRED
  PATHS ${COSPLAT_CARRIED}/googletest ${COSPLAT_CARRIED}/src/googletest/googletest)
find_package(Threads REQUIRED)

# One instruction set, this machine's: the library that chooses when a program starts is not needed.
add_library(hwy::hwy INTERFACE IMPORTED)
target_include_directories(hwy::hwy SYSTEM INTERFACE ${COSPLAT_HIGHWAY})
target_compile_definitions(hwy::hwy INTERFACE HWY_COMPILE_ONLY_STATIC)
add_library(nanoflann::nanoflann INTERFACE IMPORTED)
target_include_directories(nanoflann::nanoflann SYSTEM INTERFACE ${COSPLAT_NANOFLANN})
add_library(Eigen3::Eigen INTERFACE IMPORTED)
target_include_directories(Eigen3::Eigen SYSTEM INTERFACE ${COSPLAT_EIGEN})
add_library(TBB::tbb INTERFACE IMPORTED)
target_include_directories(TBB::tbb INTERFACE ${PROJECT_SOURCE_DIR}/cmake/lean)
target_link_libraries(TBB::tbb INTERFACE Threads::Threads)
add_library(cosplat_gtest STATIC
  ${COSPLAT_GOOGLETEST}/src/gtest-all.cc ${COSPLAT_GOOGLETEST}/src/gtest_main.cc)
target_include_directories(cosplat_gtest SYSTEM PUBLIC ${COSPLAT_GOOGLETEST}/include
  PRIVATE ${COSPLAT_GOOGLETEST})
target_link_libraries(cosplat_gtest PUBLIC Threads::Threads)
add_library(GTest::gtest_main ALIAS cosplat_gtest)

add_compile_options($<$<COMPILE_LANGUAGE:CXX>:-march=native>)

# The libraries under their usual names, without what needs OpenCV, nlohmann_json, libzip or tinygltf.
cosplat_library(base splat/media/image_bytes.cpp splat/media/signed_distance.cpp splat/base/skipped.cpp splat/base/text.cpp splat/base/world_frame.cpp)
add_library(cosplat::media ALIAS cosplat_base)
add_library(cosplat::io INTERFACE IMPORTED)
add_subdirectory(splat/device)
add_subdirectory(splat/render)
add_subdirectory(splat/train)
cosplat_library(eval splat/eval/metrics.cpp)
target_link_libraries(cosplat_eval PUBLIC cosplat::train)
cosplat_library(flame flame/added_mesh.cpp flame/blendshape_names.cpp flame/eyelids.cpp flame/halfedges_plain.cpp flame/model.cpp flame/mouth.cpp
  flame/pose.cpp flame/posing.cpp flame/topology.cpp flame/vhap_teeth.cpp tests/gpu/lean_track.cpp)
target_link_libraries(cosplat_flame PUBLIC cosplat::base PRIVATE Eigen3::Eigen TBB::tbb)
add_library(cosplat::flame_track ALIAS cosplat_flame)
add_subdirectory(avatar/model)
add_subdirectory(avatar/surface)
add_subdirectory(avatar/play)
add_subdirectory(avatar/train)
add_subdirectory(assets)
cosplat_static_library(avatar_stability apps/study/avatar_stability/painted_avatar.cpp)
target_link_libraries(cosplat_avatar_stability PUBLIC cosplat::player cosplat::made_head)
cosplat_static_library(bench apps/study/bench/synthetic_view.cpp)
target_link_libraries(cosplat_bench PUBLIC cosplat::train)
add_subdirectory(apps/study/rules)
add_subdirectory(tests/gpu)
