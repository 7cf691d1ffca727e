// SPDX-License-Identifier: MIT
// libdgm/src/contact_rows_plain.cpp
// On whatever the target has, and the choice.
#include <cstddef>

#include "contact_rows.h"

// Vectors wider than the target's registers stay inside this file: no function passes one across.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace dgm::detail {
namespace {
#include "contact_rows_impl.h"
}  // namespace

const ContactRows kPlainContactRows{volume, cubic, area, mark, project, weights, bulge};

#if defined(__x86_64__) || defined(__i386__)
extern const ContactRows kAvx2ContactRows;
#endif

const ContactRows& choose_contact_rows(const RowKernels* rows) noexcept {
#if defined(__x86_64__) || defined(__i386__)
    if (rows != &kPlainRows) return kAvx2ContactRows;
#else
    static_cast<void>(rows);
#endif
    return kPlainContactRows;
}

}  // namespace dgm::detail
