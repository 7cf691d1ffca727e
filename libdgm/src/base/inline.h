// SPDX-License-Identifier: MIT
// libdgm/src/base/inline.h
#pragma once

/// Inlined whatever the file is built for: small functions of inner loops.
#define DGM_INLINE inline __attribute__((always_inline))
/// The same behind a lambda's parameters.
#define DGM_INLINED __attribute__((always_inline))
