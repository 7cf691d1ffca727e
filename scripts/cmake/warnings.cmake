# SPDX-License-Identifier: GPL-3.0-or-later
# One interface target that every target of ours links: warnings as errors, no contraction (seam twins agree only if
# each is rounded the same way), sanitizers when asked for.
add_library(dgm_options INTERFACE)
target_compile_options(dgm_options INTERFACE
  -Wall -Wextra -Wpedantic -Wnon-virtual-dtor -Werror -ffp-contract=off -fno-fast-math)
# Where sources are compiled as one (unity.cmake), a name may hide one of a neighbour's, and a class of a source may hold
# members of an unnamed namespace.
target_compile_options(dgm_options INTERFACE
  $<IF:$<BOOL:$<TARGET_PROPERTY:UNITY_BUILD>>,-Wno-subobject-linkage,-Wshadow>)
# GCC 12 reports an overlap inside std::string's own operator+ (its bug 105651).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(dgm_options INTERFACE -Wno-restrict)
endif()
if(DGM_SANITIZE)
  target_compile_options(dgm_options INTERFACE -fsanitize=${DGM_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(dgm_options INTERFACE -fsanitize=${DGM_SANITIZE})
endif()
if(DGM_FUZZ)
  # Everything of ours counts its branches, so that the fuzzers see what a mutation reaches.
  target_compile_options(dgm_options INTERFACE -fsanitize=fuzzer-no-link)
endif()
