# What comes from outside, mutated: tests under fixed seeds, and libFuzzer's harnesses.
cosplat_test(live_mutations
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/live_mutation_test.cpp
  LIBRARIES cosplat::live)

# The preset `fuzz` (CONTRIBUTING.md): libFuzzer comes with clang.
if(COSPLAT_SANITIZE MATCHES fuzzer)
  foreach(name json lines vmc)
    add_executable(cosplat_fuzz_${name} ${CMAKE_CURRENT_LIST_DIR}/${name}_fuzzer.cpp)
    target_link_libraries(cosplat_fuzz_${name} PRIVATE cosplat::live cosplat::options)
    target_link_options(cosplat_fuzz_${name} PRIVATE -fsanitize=fuzzer)
  endforeach()
endif()
