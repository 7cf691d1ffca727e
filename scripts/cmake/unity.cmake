# SPDX-License-Identifier: GPL-3.0-or-later
# Several sources compiled as one: most of a source's time goes into headers and templates that its neighbours need too.
# Builds with ccache compile each source by itself, and so notice one that lacks an include.
option(DGM_UNITY "Compile several sources as one (off by default with ccache and with other compilers than GCC)" ${dgm_whole_builds})

# Sources whose names in unnamed namespaces others of their library have too, or whose headers claim common names.
set(DGM_APART
  cli/baking/component/cut_memory.cpp
  cli/baking/search/size_search.cpp
  cli/bench/json.cpp
  cli/bench/run_ticks.cpp
  cli/bench/run_tracking.cpp
  cli/export/level_of_detail.cpp
  cli/geometry/chart/lattice_strip.cpp
  cli/geometry/chart/square_chart.cpp
  cli/geometry/cut_search/component_search.cpp
  cli/geometry/cut_search/cut_trial.cpp
  cli/geometry/fit/edge_snap.cpp
  cli/geometry/fit/linked_surface.cpp
  cli/geometry/fit/search_repair.cpp
  cli/geometry/fit/sliding.cpp
  cli/geometry/fit/vertex_repair.cpp
  cli/geometry/parameterize/flip_free_start.cpp
  cli/geometry/parameterize/free_maps.cpp
  cli/geometry/parameterize/free_methods.cpp
  cli/geometry/parameterize/slim.cpp
  cli/geometry/parameterize/spherical_map.cpp
  cli/geometry/spatial/exposure.cpp
  cli/page/page_map.cpp
  cli/tool/man_page.cpp
  tests/unit/edit/painted_map_test.cpp
  tests/unit/process/mesh_import_test.cpp
  tests/unit/scene/scene_file_test.cpp
)

# The targets of the folder and of those below, but for those named after it.
function(dgm_unite_below folder)
  dgm_targets_below(${CMAKE_CURRENT_SOURCE_DIR}/${folder} targets)
  list(REMOVE_ITEM targets ${ARGN})
  foreach(target ${targets})
    get_target_property(type ${target} TYPE)
    if(NOT type MATCHES "^(STATIC_LIBRARY|EXECUTABLE)$")
      continue()
    endif()
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
    get_target_property(sources ${target} SOURCES)
    get_target_property(directory ${target} SOURCE_DIR)
    foreach(source ${sources})
      cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${directory} NORMALIZE OUTPUT_VARIABLE absolute)
      cmake_path(RELATIVE_PATH absolute BASE_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE path)
      if(path IN_LIST DGM_APART)
        set_source_files_properties(${absolute} TARGET_DIRECTORY ${target} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
      endif()
    endforeach()
  endforeach()
endfunction()
