# SPDX-License-Identifier: GPL-3.0-or-later
# Precompiled headers, one for the tools' libraries and one for the tests: most of a source's time is the standard
# library's. Every source includes what it uses all the same. Builds with ccache, which keeps whole objects instead, do
# without them, and so notice a source that does not.
# Also the default of unity.cmake.
if(DGM_CCACHE OR NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(dgm_whole_builds OFF)
else()
  set(dgm_whole_builds ON)
endif()
option(DGM_PRECOMPILE "Precompiled headers (off by default with ccache and with other compilers than GCC)" ${dgm_whole_builds})

set(DGM_STANDARD_HEADERS <algorithm> <array> <atomic> <bit> <chrono> <cmath> <cstdint> <cstring> <filesystem> <fstream>
  <functional> <limits> <map> <memory> <numeric> <optional> <random> <set> <span> <sstream> <string> <string_view>
  <thread> <unordered_map> <utility> <variant> <vector>)

# Every library or program of the folder and of those below.
function(dgm_targets_below folder out)
  get_directory_property(targets DIRECTORY ${folder} BUILDSYSTEM_TARGETS)
  get_directory_property(folders DIRECTORY ${folder} SUBDIRECTORIES)
  foreach(below ${folders})
    dgm_targets_below(${below} more)
    list(APPEND targets ${more})
  endforeach()
  set(${out} ${targets} PARENT_SCOPE)
endfunction()

# Targets of one kind share one header: GCC takes it only where it was made with the same options.
# Tests share one that has GoogleTest in it, which its library's definitions change, too.
function(dgm_precompile_below folder kind options headers)
  string(TOLOWER dgm_precompiled_for_${kind} shared)
  dgm_targets_below(${CMAKE_CURRENT_SOURCE_DIR}/${folder} targets)
  foreach(target ${targets})
    get_target_property(type ${target} TYPE)
    get_target_property(sources ${target} SOURCES)
    get_target_property(libraries ${target} LINK_LIBRARIES)
    list(FILTER sources INCLUDE REGEX "\\.cpp$")
    if(NOT type STREQUAL kind OR NOT sources OR (kind STREQUAL EXECUTABLE AND NOT libraries MATCHES "GTest::"))
      continue()
    endif()
    target_compile_options(${target} PRIVATE ${options})
    if(NOT DGM_PRECOMPILE)
      continue()
    endif()
    if(NOT TARGET ${shared})
      set(source ${CMAKE_CURRENT_BINARY_DIR}/${shared}.cpp)
      if(kind STREQUAL EXECUTABLE)
        file(WRITE ${source} "\n")
        add_executable(${shared} ${source})
        target_link_libraries(${shared} PRIVATE GTest::gtest_main)
      else()
        file(WRITE ${source} "\n")
        add_library(${shared} STATIC ${source})
      endif()
      target_link_libraries(${shared} PRIVATE dgm_options)
      target_compile_features(${shared} PRIVATE cxx_std_20)
      target_compile_options(${shared} PRIVATE ${options})
      target_precompile_headers(${shared} PRIVATE ${headers})
    endif()
    target_precompile_headers(${target} REUSE_FROM ${shared})
    # GCC 12 forgets that a precompiled header is the system's, and finds fault with std::string in it.
    target_compile_options(${target} PRIVATE -Wno-stringop-overflow -Wno-stringop-overread -Wno-array-bounds)
  endforeach()
endfunction()
