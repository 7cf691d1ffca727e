# SPDX-License-Identifier: GPL-3.0-or-later
find_package(GTest REQUIRED)
include(GoogleTest)

# dgm_add_tests(NAME SOURCES ... LIBRARIES ... DEFINITIONS ...): a program of unit tests, of which ctest knows each by its
# name. Folders may add sources later with target_sources().
function(dgm_add_tests name)
  cmake_parse_arguments(PARSE_ARGV 1 tests "" "" "SOURCES;LIBRARIES;DEFINITIONS")
  add_executable(${name} ${tests_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_compile_definitions(${name} PRIVATE ${tests_DEFINITIONS})
  target_link_libraries(${name} PRIVATE ${tests_LIBRARIES} GTest::gtest_main)
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60)
endfunction()
