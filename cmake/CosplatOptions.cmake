# Warnings, sanitizers and floating-point settings that every target of the project shares.
include(GNUInstallDirs)
option(COSPLAT_WERROR "Treat warnings as errors" OFF)
set(COSPLAT_SANITIZE "" CACHE STRING "Sanitizers to build with, e.g. address,undefined or thread")

add_library(cosplat_options INTERFACE)
add_library(cosplat::options ALIAS cosplat_options)
target_include_directories(cosplat_options INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
target_compile_options(cosplat_options INTERFACE
  $<$<COMPILE_LANGUAGE:CXX>:-Wall;-Wextra;-Wno-unknown-pragmas>
  $<$<AND:$<COMPILE_LANGUAGE:CXX>,$<BOOL:${COSPLAT_WERROR}>>:-Werror>)
if(COSPLAT_SANITIZE)
  target_compile_options(cosplat_options INTERFACE -fsanitize=${COSPLAT_SANITIZE}
                         -fno-omit-frame-pointer)
  target_link_options(cosplat_options INTERFACE -fsanitize=${COSPLAT_SANITIZE})
endif()

# A static library cosplat_NAME with the alias cosplat::NAME.
function(cosplat_static_library name)
  add_library(cosplat_${name} STATIC ${ARGN})
  add_library(cosplat::${name} ALIAS cosplat_${name})
  set_target_properties(cosplat_${name} PROPERTIES EXPORT_NAME ${name})
  if(NOT EMSCRIPTEN)
    set_target_properties(cosplat_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  endif()
  target_include_directories(cosplat_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                             $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/cosplat>)
  target_compile_features(cosplat_${name} PUBLIC cxx_std_20)
  target_link_libraries(cosplat_${name} PRIVATE $<BUILD_INTERFACE:cosplat::options>)
endfunction()

# cosplat_library(NAME SOURCES...): one of the product's, installed and exported by cosplat_install().
function(cosplat_library name)
  cosplat_static_library(${name} ${ARGN})
  set_property(GLOBAL APPEND PROPERTY COSPLAT_LIBRARIES cosplat_${name})
endfunction()

# cosplat_cuda_library(NAME SOURCES...): the CUDA half of a library, cosplat::NAME, built where nvcc is
# found. Its files by their full paths are the global property COSPLAT_SOURCES_NAME, since tests compile
# them for the host as well (tests/cuda).
function(cosplat_cuda_library name)
  list(TRANSFORM ARGN PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ OUTPUT_VARIABLE files)
  set_property(GLOBAL PROPERTY COSPLAT_SOURCES_${name} ${files})
  if(COSPLAT_HAS_CUDA)
    cosplat_library(${name} ${ARGN})
    # No number here matters that is below 1e-38, and each exponential and division by the hardware
    # (splat/render/cuda) would scale its operands for such numbers.
    target_compile_options(cosplat_${name} PRIVATE
      "$<$<COMPILE_LANGUAGE:CUDA>:-lineinfo;-ftz=true>")
  endif()
endfunction()

# cosplat_choose_device(NAME CUDA_LIBRARY): cosplat::NAME opens the CUDA back end where it was built.
function(cosplat_choose_device name cuda_library)
  if(COSPLAT_HAS_CUDA)
    target_link_libraries(cosplat_${name} PRIVATE cosplat::${cuda_library})
    target_compile_definitions(cosplat_${name} PRIVATE COSPLAT_HAS_CUDA)
  endif()
endfunction()

# cosplat_apart(SOURCES...): not merged with others, so that a program that links the static library
# without calling these does not load what they call (OpenCV, libwebp, libzstd): libcosplat.so.
function(cosplat_apart)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# Loops whose instruction sets are built in one binary and chosen when it starts: AVX-512, AVX2 and the
# baseline. The better a target, the lower Highway's number for it: what is above AVX-512's base, which
# every version of Highway has more of, is left out whatever its name.
function(cosplat_simd_sources)
  set_source_files_properties(${ARGN} PROPERTIES
    COMPILE_OPTIONS "-O3;-fno-trapping-math;-fno-math-errno"
    COMPILE_DEFINITIONS "HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SSE4|(HWY_AVX3-1))"
    SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# cosplat_embed(SYMBOL HEADER FILE): puts a source with FILE's bytes as cosplat::SYMBOL, and their count as
# cosplat::SYMBOLSize, both declared in HEADER, into the build folder, and its path into SYMBOL_source.
function(cosplat_embed symbol header file)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${symbol}.cpp)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  file(READ ${file} bytes HEX)
  string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
  string(REGEX REPLACE "((0x..,)(0x..,)(0x..,)(0x..,)(0x..,)(0x..,)(0x..,)(0x..,))" "\\1\n" bytes "${bytes}")
  file(CONFIGURE OUTPUT ${source} CONTENT
"#include \"${header}\"

namespace cosplat {

const unsigned char ${symbol}[] = {
${bytes}};
const size_t ${symbol}Size = sizeof ${symbol};

}
")
  set(${symbol}_source ${source} PARENT_SCOPE)
endfunction()
