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

# cosplat_library(NAME SOURCES...): a static library cosplat_NAME with the alias cosplat::NAME,
# installed and exported by cosplat_install().
function(cosplat_library name)
  add_library(cosplat_${name} STATIC ${ARGN})
  add_library(cosplat::${name} ALIAS cosplat_${name})
  set_target_properties(cosplat_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_include_directories(cosplat_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                             $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/cosplat>)
  target_compile_features(cosplat_${name} PUBLIC cxx_std_20)
  target_link_libraries(cosplat_${name} PRIVATE $<BUILD_INTERFACE:cosplat::options>)
  set_property(GLOBAL APPEND PROPERTY COSPLAT_LIBRARIES cosplat_${name})
endfunction()
