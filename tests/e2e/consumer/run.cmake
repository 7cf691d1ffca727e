# SPDX-License-Identifier: GPL-3.0-or-later
# Installs the runtime into an empty prefix, builds the consumers against it three ways, and runs them; then a project in
# C alone, and one line of pkg-config --static.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "exit ${code}: ${ARGN}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
foreach(component runtime development)
  run(${CMAKE_COMMAND} --install ${BUILD} --component ${component} --prefix ${WORK}/prefix)
endforeach()
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
  if(NOT use STREQUAL "pkgconfig")
    run(${WORK}/${use}/cloth ${WORK}/sample.dgm)
  endif()
endforeach()

run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${SOURCE}/c_only -B ${WORK}/c_only -DCMAKE_PREFIX_PATH=${WORK}/prefix
  -DCMAKE_BUILD_TYPE=${CONFIG} -DCMAKE_C_COMPILER=${C})
run(${CMAKE_COMMAND} --build ${WORK}/c_only)
run(${WORK}/c_only/c_only_dgm ${WORK}/sample.dgm)
set(ENV{LD_LIBRARY_PATH})
run(${WORK}/c_only/c_only_dgm_static ${WORK}/sample.dgm)

execute_process(COMMAND pkg-config --static --cflags --libs dgm OUTPUT_VARIABLE flags COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags UNIX_COMMAND ${flags})
run(${C} -std=c99 ${SOURCE}/consumer.c -static -o ${WORK}/static_line ${flags})
run(${WORK}/static_line ${WORK}/sample.dgm)
