# libcosplat.so by its C interface; the rest makes the files that it opens.
add_executable(cosplat_bench_plugin ${CMAKE_CURRENT_LIST_DIR}/plugin_bench.cpp)
target_link_libraries(cosplat_bench_plugin PRIVATE
  cosplat::plugin cosplat::avatar_file cosplat::avatar_study cosplat::procedural cosplat::options)
