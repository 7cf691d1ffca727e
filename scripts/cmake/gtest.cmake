# SPDX-License-Identifier: GPL-3.0-or-later
# GTest::gtest_main. For other targets than this machine's it is built from the sources that Debian's libgtest-dev brings
# (googletest), since its library is this machine's.
if(NOT CMAKE_CROSSCOMPILING)
  find_package(GTest REQUIRED)
  return()
endif()
find_path(DGM_GTEST_SOURCE src/gtest-all.cc PATHS /usr/src/googletest/googletest NO_DEFAULT_PATH
  NO_CMAKE_FIND_ROOT_PATH REQUIRED)
add_library(dgm_gtest STATIC ${DGM_GTEST_SOURCE}/src/gtest-all.cc ${DGM_GTEST_SOURCE}/src/gtest_main.cc)
target_include_directories(dgm_gtest SYSTEM PUBLIC ${DGM_GTEST_SOURCE}/include PRIVATE ${DGM_GTEST_SOURCE})
target_compile_features(dgm_gtest PUBLIC cxx_std_20)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^wasm")
  # No exceptions, threads, processes, regular expressions of POSIX, and no files to be written.
  target_compile_definitions(dgm_gtest PUBLIC GTEST_HAS_EXCEPTIONS=0 GTEST_HAS_PTHREAD=0 GTEST_HAS_DEATH_TEST=0
    GTEST_HAS_POSIX_RE=0 GTEST_HAS_STREAM_REDIRECTION=0 GTEST_HAS_CLONE=0 _WASI_EMULATED_SIGNAL)
  target_link_libraries(dgm_gtest PUBLIC wasi-emulated-signal)
endif()
add_library(GTest::gtest_main ALIAS dgm_gtest)
