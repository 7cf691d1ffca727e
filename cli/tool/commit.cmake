# SPDX-License-Identifier: GPL-3.0-or-later
# Runs with every build: cmake -DGIT=... -DSOURCE=... -DTEMPLATE=... -DOUT=... -P commit.cmake
# OUT changes only if the commit does, so that nothing is compiled for nothing. Sources without .git (a tarball) and
# sources inside another repository have no commit.
set(commit "")
if(GIT)
  execute_process(COMMAND ${GIT} -C ${SOURCE} rev-parse --show-prefix
    OUTPUT_VARIABLE prefix ERROR_QUIET RESULT_VARIABLE failed OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT failed AND prefix STREQUAL "")
    execute_process(COMMAND ${GIT} -C ${SOURCE} rev-parse --short=10 HEAD
      OUTPUT_VARIABLE commit ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
    execute_process(
      COMMAND ${GIT} -C ${SOURCE} status --porcelain --untracked-files=no -- CMakeLists.txt cli formats libdgm samples
      OUTPUT_VARIABLE changes ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
    if(commit AND changes)
      string(APPEND commit ", modified")
    endif()
  endif()
endif()
configure_file(${TEMPLATE} ${OUT} @ONLY)
