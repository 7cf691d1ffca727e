/* SPDX-License-Identifier: MIT */
/* libdgm/include/dgm/export.h */
/* Marks what the shared library shows; everything else is hidden. Plain C. */
/* On Windows, define DGM_STATIC before including any header of libdgm if you link the static library; CMake's */
/* dgm::dgm_static does so. DGM_BUILD_SHARED is the library's own. */
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
