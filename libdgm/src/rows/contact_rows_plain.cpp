// SPDX-License-Identifier: MIT
// libdgm/src/rows/contact_rows_plain.cpp
// On whatever the target has, and the choice.
#include <cstddef>

#include "rows/contact_rows.h"
#include "rows/four_roots.h"

// Vectors wider than the target's registers stay inside this file: no function passes one across.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace dgm::detail {
namespace {
typedef double Doubles __attribute__((vector_size(32)));
typedef long long Longs __attribute__((vector_size(32)));
typedef float Wide __attribute__((vector_size(16)));
typedef int WideInts __attribute__((vector_size(16)));

// Registers hold two at most: one by one is as quick, and a quarter of the code.
constexpr bool kFourDoubles = false;
inline Doubles load_four(const float* p) {
    return Doubles{p[0], p[1], p[2], p[3]};
}
inline void store_four(float* p, const Doubles& v) {
    for (int k = 0; k < 4; ++k) p[k] = static_cast<float>(v[k]);
}
inline Longs four_bytes(const std::uint8_t* p) {
    return Longs{p[0], p[1], p[2], p[3]};
}
inline WideInts wide_bytes(const std::uint8_t* p) {
    return WideInts{p[0], p[1], p[2], p[3]};
}
inline bool any_lane(const WideInts& v) {
    return (v[0] | v[1] | v[2] | v[3]) != 0;
}
inline void add_to(const Wide& v, Doubles& sums) {
    for (int k = 0; k < 4; ++k) sums[k] += static_cast<double>(v[k]);
}
inline Wide square_root(const Wide& v) {
    Wide roots = v;
    take_roots(roots);
    return roots;
}
inline Doubles square_root(const Doubles& v) {
    return Doubles{__builtin_sqrt(v[0]), __builtin_sqrt(v[1]), __builtin_sqrt(v[2]), __builtin_sqrt(v[3])};
}
inline double square_root(double v) {
    return __builtin_sqrt(v);
}
inline unsigned lane_bits(const Longs& v) {
    return static_cast<unsigned>((v[0] & 1) | (v[1] & 2) | (v[2] & 4) | (v[3] & 8));
}
#include "rows/unfused.h"
// The bodies, which need all of the above.
#include "rows/contact_rows_impl.h"
}  // namespace

const ContactRows kPlainContactRows{volume,   swept,  cubic,   area,   mark,      exchange,
                                    put_back, smooth, weights, spread, held_back, bulge};

#if DGM_HAS_AVX
extern const ContactRows kAvx2ContactRows;
#endif

const ContactRows& choose_contact_rows(const RowKernels* rows) noexcept {
#if DGM_HAS_AVX
    if (rows != &kPlainRows) return kAvx2ContactRows;
#else
    static_cast<void>(rows);
#endif
    return kPlainContactRows;
}

}  // namespace dgm::detail
