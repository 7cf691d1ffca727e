/* SPDX-License-Identifier: MIT */
/* libdgm/include/dgm/export.h */
/* Marks what libdgm.so shows; everything else is hidden. Plain C. */
#pragma once
#if defined(__GNUC__)
#define DGM_API __attribute__((visibility("default")))
#else
#define DGM_API
#endif
