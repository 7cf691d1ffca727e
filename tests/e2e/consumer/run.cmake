# SPDX-License-Identifier: GPL-3.0-or-later
# Installs the runtime into an empty prefix, builds the consumers against it three ways, and runs them.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "exit ${code}: ${ARGN}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --component runtime --prefix ${WORK}/prefix)
run(${SAMPLE} ${WORK}/sample.dgm)
foreach(use shared static pkgconfig)
  set(ENV{PKG_CONFIG_PATH} ${WORK}/prefix/${LIBDIR}/pkgconfig)
  run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${SOURCE} -B ${WORK}/${use} -DUSE=${use} -DCMAKE_PREFIX_PATH=${WORK}/prefix
    -DCMAKE_BUILD_TYPE=${CONFIG} -DCMAKE_C_COMPILER=${C} -DCMAKE_CXX_COMPILER=${CXX})
  run(${CMAKE_COMMAND} --build ${WORK}/${use})
  set(ENV{LD_LIBRARY_PATH} ${WORK}/prefix/${LIBDIR})
  run(${WORK}/${use}/consumer_c ${WORK}/sample.dgm)
  run(${WORK}/${use}/consumer_cpp ${WORK}/sample.dgm)
  run(${WORK}/${use}/engine ${WORK}/sample.dgm)
endforeach()
