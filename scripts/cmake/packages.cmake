# SPDX-License-Identifier: GPL-3.0-or-later
# `cpack --config build/release/CPackConfig.cmake` (or `scripts/packages`) makes three Debian packages: libdgm0, the
# shared runtime; libdgm-dev, all that a program needs to be built with it; dgm-tools.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME dgm)
set(CPACK_PACKAGE_VENDOR "DGM")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_INSTALL_DIRECTORY dgm)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL runtime development)
if(DGM_BUILD_TOOLS)
  list(APPEND CPACK_COMPONENTS_ALL tools)
endif()

set(DGM_PACKAGE_MAINTAINER "DGM developers <dgm@localhost>" CACHE STRING "Name and address in packages")
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${DGM_PACKAGE_MAINTAINER}")
set(CPACK_DEBIAN_PACKAGE_HOMEPAGE "${DGM_HOMEPAGE}")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)

set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME libdgm0)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/package/triggers)
file(WRITE ${PROJECT_BINARY_DIR}/package/triggers "activate-noawait ldconfig\n")
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "Runtime of deformable geometry maps
 Maps .dgm files in place, rebuilds the surface, and deforms it, collides with it and
 returns forces at haptic rates. Depends on the C and C++ standard libraries alone.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libdgm-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libdgm0 (= ${PROJECT_VERSION})")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "Runtime of deformable geometry maps, for building programs
 C and C++ headers, static library, files for CMake and pkg-config.")

set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME dgm-tools)
set(CPACK_DEBIAN_TOOLS_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_TOOLS_PACKAGE_SHLIBDEPS ON)
set(CPACK_COMPONENT_TOOLS_DESCRIPTION "Tools that bake, check and export deformable geometry maps
 dgm-bake turns meshes into regular grids of samples; dgm-validate, dgm-info, dgm-export,
 dgm-edit and dgm-bench check, show, export, edit and measure them.")

# Debian asks each package for its licence.
foreach(pair "runtime|libdgm0|MIT" "development|libdgm-dev|MIT" "tools|dgm-tools|GPL-3.0-or-later")
  string(REPLACE "|" ";" pair ${pair})
  list(GET pair 0 component)
  list(GET pair 1 package)
  list(GET pair 2 licence)
  if(component IN_LIST CPACK_COMPONENTS_ALL)
    install(FILES ${PROJECT_SOURCE_DIR}/LICENSES/${licence}.txt RENAME copyright
      DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${component})
  endif()
endforeach()
include(CPack)
