# Installs BUILD below WORK, then builds and runs the project in CONSUMER against it.
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
