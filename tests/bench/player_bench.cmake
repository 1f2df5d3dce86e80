add_executable(cosplat_bench_player ${CMAKE_CURRENT_LIST_DIR}/player_bench.cpp)
target_link_libraries(cosplat_bench_player PRIVATE
  cosplat::avatar_study cosplat::player cosplat::procedural cosplat::splat cosplat::options TBB::tbb)
