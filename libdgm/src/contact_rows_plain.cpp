// SPDX-License-Identifier: MIT
// libdgm/src/contact_rows_plain.cpp
// On whatever the target has, and the choice.
#include <cstddef>

#include "contact_rows.h"

// Vectors wider than the target's registers stay inside this file: no function passes one across.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace dgm::detail {
namespace {
typedef double Doubles __attribute__((vector_size(32)));
typedef long long Longs __attribute__((vector_size(32)));
typedef float Single4 __attribute__((vector_size(16)));
typedef float Wide __attribute__((vector_size(16)));
typedef int Int4 __attribute__((vector_size(16)));

inline Doubles load_four(const float* p) {
    return Doubles{p[0], p[1], p[2], p[3]};
}
inline void store_four(float* p, const Doubles& v) {
    for (int k = 0; k < 4; ++k) p[k] = static_cast<float>(v[k]);
}
inline Longs four_bytes(const std::uint8_t* p) {
    return Longs{p[0], p[1], p[2], p[3]};
}
inline Doubles four_roots(const Doubles& v) {
    return Doubles{__builtin_sqrt(v[0]), __builtin_sqrt(v[1]), __builtin_sqrt(v[2]), __builtin_sqrt(v[3])};
}
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
