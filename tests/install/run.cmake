# Installs BUILD below WORK, then builds and runs the project in CONSUMER and the program
# HOST, in C, against it.
set(prefix ${WORK}/prefix)
set(build ${WORK}/build)
file(REMOVE_RECURSE ${prefix} ${build})

function(step name)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${name} failed (${result}):\n${output}")
  endif()
endfunction()

set(flags "")
if(SANITIZE)
  set(flags "-fsanitize=${SANITIZE}")
endif()
step("Installing" ${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
step("Configuring" ${CMAKE_COMMAND} -S ${CONSUMER} -B ${build} -G ${GENERATOR}
  -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_FLAGS=${flags} -DCMAKE_PREFIX_PATH=${prefix})
step("Building" ${CMAKE_COMMAND} --build ${build})
step("Running" ${build}/consumer)

# HOST knows only pkg-config. Without arguments it prints its usage and exits with 2.
file(GLOB_RECURSE pc ${prefix}/cosplat.pc)
get_filename_component(pc_folder "${pc}" DIRECTORY)
set(ENV{PKG_CONFIG_PATH} ${pc_folder})
set(script "cc ${flags} -std=c99 ${HOST} $(pkg-config --cflags --libs cosplat) -o ${build}/host")
step("Building the host" sh -c "${script}")
execute_process(
  COMMAND ${CMAKE_COMMAND} -E env LD_LIBRARY_PATH=${pc_folder}/.. ${build}/host
  RESULT_VARIABLE result ERROR_VARIABLE output)
if(NOT result EQUAL 2 OR NOT output MATCHES "usage:")
  message(FATAL_ERROR "the host did not run (${result}):\n${output}")
endif()
