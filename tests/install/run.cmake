# Installs BUILD below WORK, moves the installation, then builds and runs against it: the project in
# CONSUMER, the one for C in CONSUMER/c with the program HOST, and HOST by pkg-config. Host plug-ins
# that were built find the library beside them.
set(prefix ${WORK}/prefix)
set(build ${WORK}/build)
file(REMOVE_RECURSE ${prefix} ${build} ${WORK}/first)

function(step name)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${name} failed (${result}):\n${output}")
  endif()
endfunction()

# Without arguments a host prints its usage and exits with 2.
function(run_host)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result ERROR_VARIABLE output)
  if(NOT result EQUAL 2 OR NOT output MATCHES "usage:")
    message(FATAL_ERROR "the host did not run (${result}):\n${output}")
  endif()
endfunction()

function(find_installed variable name)
  file(GLOB_RECURSE found ${prefix}/${name})
  set(${variable} ${found} PARENT_SCOPE)
endfunction()

set(flags "")
if(SANITIZE)
  set(flags "-fsanitize=${SANITIZE}")
endif()
step("Installing" ${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/first)
file(RENAME ${WORK}/first ${prefix})
step("Configuring" ${CMAKE_COMMAND} -S ${CONSUMER} -B ${build} -G ${GENERATOR}
  -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_FLAGS=${flags} -DCMAKE_PREFIX_PATH=${prefix}
  -DCOSPLAT_VERSION=${VERSION})
step("Building" ${CMAKE_COMMAND} --build ${build})
step("Running" ${build}/consumer)

step("Configuring in C" ${CMAKE_COMMAND} -S ${CONSUMER}/c -B ${build}/c -G ${GENERATOR}
  -DCMAKE_C_FLAGS=${flags} -DCMAKE_PREFIX_PATH=${prefix} -DHOST=${HOST}
  -DCOSPLAT_VERSION=${VERSION})
step("Building in C" ${CMAKE_COMMAND} --build ${build}/c)
run_host(${build}/c/host)

find_installed(pc cosplat.pc)
get_filename_component(pc_folder "${pc}" DIRECTORY)
get_filename_component(library_folder "${pc_folder}" DIRECTORY)
set(ENV{PKG_CONFIG_PATH} ${pc_folder})
set(script "cc ${flags} -std=c99 ${HOST} $(pkg-config --cflags --libs cosplat) -o ${build}/host")
step("Building the host" sh -c "${script}")
run_host(${CMAKE_COMMAND} -E env LD_LIBRARY_PATH=${library_folder} ${build}/host)

# What follows is loaded by programs that are built without the sanitizers.
if(SANITIZE)
  return()
endif()
foreach(plugin gstreamer-1.0/libgstcosplat.so obs-plugins/cosplat.so)
  if(EXISTS ${library_folder}/${plugin})
    file(GET_RUNTIME_DEPENDENCIES MODULES ${library_folder}/${plugin}
      RESOLVED_DEPENDENCIES_VAR loaded UNRESOLVED_DEPENDENCIES_VAR missing)
    list(FILTER loaded INCLUDE REGEX "^${library_folder}/.*libcosplat\\.so")
    if(NOT loaded OR missing)
      message(FATAL_ERROR "${plugin} does not load the installed library: ${loaded}; ${missing}")
    endif()
  endif()
endforeach()
if(EXISTS ${library_folder}/gstreamer-1.0 AND GST_INSPECT)
  step("Inspecting" ${CMAKE_COMMAND} -E env GST_PLUGIN_PATH=${library_folder}/gstreamer-1.0
    GST_REGISTRY=${build}/registry.bin ${GST_INSPECT} cosplatsrc)
endif()
if(PYTHON)
  step("Running Python" ${CMAKE_COMMAND} -E env --unset=COSPLAT_LIBRARY PYTHONDONTWRITEBYTECODE=1
    ${PYTHON} ${library_folder}/cosplat/python/render_png.py --help)
endif()
