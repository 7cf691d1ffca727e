// SPDX-License-Identifier: MIT
// libdgm/src/contact_rows_avx2.cpp
// Built for AVX2 function by function, as rows_avx2.cpp. Nothing is fused: projecting and bulging round alike.
#include <cstddef>

#include "contact_rows.h"

#if defined(__x86_64__) || defined(__i386__)
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif

namespace dgm::detail {
namespace {
#include "contact_rows_impl.h"
}  // namespace

extern const ContactRows kAvx2ContactRows;
const ContactRows kAvx2ContactRows{volume, cubic, area, mark, project, weights, bulge};

}  // namespace dgm::detail

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
