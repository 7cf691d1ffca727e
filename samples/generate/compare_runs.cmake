# SPDX-License-Identifier: GPL-3.0-or-later
# cmake -DPROGRAM=... -DWORK=... -P compare_runs.cmake
# Runs dgm-make-samples twice, the second time from another folder and in another locale, and compares every byte.
cmake_minimum_required(VERSION 3.25)
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK}/elsewhere)
execute_process(COMMAND ${PROGRAM} ${WORK}/first OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} -E env LC_ALL=de_DE.UTF-8 TZ=Asia/Tokyo ${PROGRAM} ../second
  WORKING_DIRECTORY ${WORK}/elsewhere OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)

file(GLOB_RECURSE first RELATIVE ${WORK}/first ${WORK}/first/*)
file(GLOB_RECURSE second RELATIVE ${WORK}/second ${WORK}/second/*)
if(NOT first STREQUAL second)
  message(FATAL_ERROR "the runs wrote different files:\n  ${first}\n  ${second}")
endif()
foreach(expected stomach/stomach.obj stomach/stomach.3ds stomach/stomach_denim.obj
    stomach/stomach_satin.obj liver/liver.obj cushion/cushion.obj cushion/cushion.3ds
    cushion/cover.obj sheet/sheet.obj skirt/skirt.obj
    chair/seat.obj chair/back.obj chair/chair.obj fabrics/denim.png fabrics/satin.png)
  if(NOT expected IN_LIST first)
    message(FATAL_ERROR "${expected} was not written")
  endif()
endforeach()
set(total 0)
foreach(name ${first})
  execute_process(COMMAND ${CMAKE_COMMAND} -E compare_files ${WORK}/first/${name} ${WORK}/second/${name}
    RESULT_VARIABLE differs)
  if(differs)
    message(FATAL_ERROR "${name} differs between two runs")
  endif()
  file(SIZE ${WORK}/first/${name} size)
  math(EXPR total "${total} + ${size}")
endforeach()
# 10 MiB, and 6 for the stomach in two cloths.
if(total GREATER 16777216)
  message(FATAL_ERROR "the samples are ${total} bytes; they should stay below 16 MiB")
endif()
file(REMOVE_RECURSE ${WORK})
