/* SPDX-License-Identifier: MIT */
/* libdgm/include/dgm/export.h */
/* Marks the functions that the shared library exports; everything else is hidden. Plain C. */
/* On Windows, define DGM_STATIC before including any header of libdgm if you link the static library; CMake's */
/* dgm::dgm_static does so. Only the library itself defines DGM_BUILD_SHARED. */
#pragma once
#if defined(_WIN32) && defined(DGM_BUILD_SHARED)
#define DGM_API __declspec(dllexport)
#elif defined(_WIN32) && !defined(DGM_STATIC)
#define DGM_API __declspec(dllimport)
#elif !defined(_WIN32) && defined(__GNUC__)
#define DGM_API __attribute__((visibility("default")))
#else
#define DGM_API
#endif
