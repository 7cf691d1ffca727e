# SPDX-License-Identifier: GPL-3.0-or-later
# As toolchain_arm64.cmake, with the tools' libraries from DGM_ARM64_ROOT, a folder of unpacked packages
# (scripts/platforms arm64-bake makes it).
if(DEFINED ENV{DGM_ARM64_ROOT})
  set(DGM_ARM64_ROOT $ENV{DGM_ARM64_ROOT} CACHE PATH "Unpacked Debian packages for ARM64")
endif()
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES DGM_ARM64_ROOT)
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_SYSROOT ${DGM_ARM64_ROOT})
set(CMAKE_FIND_ROOT_PATH ${DGM_ARM64_ROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L ${DGM_ARM64_ROOT})
# Debian keeps the serial HDF5 in a folder of its own, where h5cc, which cannot run here, would look.
set(CMAKE_LIBRARY_PATH ${DGM_ARM64_ROOT}/usr/lib/aarch64-linux-gnu/hdf5/serial)
set(CMAKE_INCLUDE_PATH ${DGM_ARM64_ROOT}/usr/include/hdf5/serial)
