// SPDX-License-Identifier: MIT
// libdgm/src/rows/rows_avx512.cpp
// Normals of grids whose diagonals are all 0, which are most of a tick, with sixteen lanes.
//
// The eight-lane loop is bound by its loads: six of the ring's samples for each normal. This loop goes down a strip of
// columns row by row and keeps two of the three rows in registers: 32 registers are enough for that, 16 are not. kRows
// rows at a time stay in the first cache.
#include <cstddef>

#include "rows/rows.h"

#if DGM_HAS_AVX
#include <immintrin.h>

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx512f,avx512vl,avx2,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx512f,avx512vl,avx2,fma")
#endif

namespace dgm::detail {
namespace {

constexpr std::uint32_t kRows = 8;

typedef float Sixteen __attribute__((vector_size(64)));
typedef float Eight __attribute__((vector_size(32)));

template <class F>
DGM_INLINE F load(const float* p, unsigned lanes);
template <>
DGM_INLINE Sixteen load<Sixteen>(const float* p, unsigned lanes) {
    return static_cast<Sixteen>(_mm512_maskz_loadu_ps(static_cast<__mmask16>(lanes), p));
}
template <>
DGM_INLINE Eight load<Eight>(const float* p, unsigned lanes) {
    return static_cast<Eight>(_mm256_maskz_loadu_ps(static_cast<__mmask8>(lanes), p));
}
DGM_INLINE void store(float* p, unsigned lanes, const Sixteen& v) {
    _mm512_mask_storeu_ps(p, static_cast<__mmask16>(lanes), static_cast<__m512>(v));
}
DGM_INLINE void store(float* p, unsigned lanes, const Eight& v) {
    _mm256_mask_storeu_ps(p, static_cast<__mmask8>(lanes), static_cast<__m256>(v));
}
DGM_INLINE Sixteen multiply_add(const Sixteen& a, const Sixteen& b, const Sixteen& c) {
    return static_cast<Sixteen>(_mm512_fmadd_ps(a, b, c));
}
DGM_INLINE Eight multiply_add(const Eight& a, const Eight& b, const Eight& c) {
    return static_cast<Eight>(_mm256_fmadd_ps(a, b, c));
}
/// Lanes whose square is in the range of float arithmetic; false for NaN.
DGM_INLINE unsigned within(const Sixteen& v, unsigned lanes) {
    const __mmask16 above = _mm512_mask_cmp_ps_mask(static_cast<__mmask16>(lanes), v, Sixteen{} + 1e-24f, _CMP_GT_OQ);
    return _mm512_mask_cmp_ps_mask(above, v, Sixteen{} + 1e24f, _CMP_LT_OQ);
}
DGM_INLINE unsigned within(const Eight& v, unsigned lanes) {
    const __mmask8 above = _mm256_mask_cmp_ps_mask(static_cast<__mmask8>(lanes), v, Eight{} + 1e-24f, _CMP_GT_OQ);
    return _mm256_mask_cmp_ps_mask(above, v, Eight{} + 1e24f, _CMP_LT_OQ);
}
/// a * b; 0 in other lanes, whatever a and b are there.
DGM_INLINE Sixteen product(const Sixteen& a, const Sixteen& b, unsigned lanes) {
    return static_cast<Sixteen>(_mm512_maskz_mul_ps(static_cast<__mmask16>(lanes), a, b));
}
DGM_INLINE Eight product(const Eight& a, const Eight& b, unsigned lanes) {
    return static_cast<Eight>(_mm256_maskz_mul_ps(static_cast<__mmask8>(lanes), a, b));
}
/// To 14 bits, the same in both widths; 0 in other lanes.
DGM_INLINE Sixteen estimate(const Sixteen& v, unsigned lanes) {
    return static_cast<Sixteen>(_mm512_maskz_rsqrt14_ps(static_cast<__mmask16>(lanes), v));
}
DGM_INLINE Eight estimate(const Eight& v, unsigned lanes) {
    return static_cast<Eight>(_mm256_maskz_rsqrt14_ps(static_cast<__mmask8>(lanes), v));
}

template <class F>
struct Vector {
    F x, y, z;
};
template <class F>
DGM_INLINE Vector<F> point(const NormalJob& j, std::ptrdiff_t k, unsigned lanes) {
    return {load<F>(j.at.x + k, lanes), load<F>(j.at.y + k, lanes), load<F>(j.at.z + k, lanes)};
}
template <class F>
DGM_INLINE Vector<F> operator-(const Vector<F>& a, const Vector<F>& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
/// sum + a x b.
template <class F>
DGM_INLINE Vector<F> add_cross(const Vector<F>& sum, const Vector<F>& a, const Vector<F>& b) {
    return {multiply_add(-a.z, b.y, multiply_add(a.y, b.z, sum.x)),
            multiply_add(-a.x, b.z, multiply_add(a.z, b.x, sum.y)),
            multiply_add(-a.y, b.x, multiply_add(a.x, b.y, sum.z))};
}

/// Rows i0..i1 of the columns from j0 on that `lanes` has. Names of ring samples as in normals of rows_impl.h.
/// @return whether all normals are good.
template <class F>
DGM_INLINE bool strip(const NormalJob& job, std::uint32_t i0, std::uint32_t i1, std::uint32_t j0, unsigned lanes) {
    const std::ptrdiff_t n = job.cols;
    std::ptrdiff_t k = static_cast<std::ptrdiff_t>(i0) * n + j0;
    Vector<F> n2 = point<F>(job, k - n, lanes), c2 = point<F>(job, k - n - 1, lanes);
    Vector<F> here = point<F>(job, k, lanes), n1 = point<F>(job, k + 1, lanes), n3 = point<F>(job, k - 1, lanes);
    unsigned good = lanes;
    for (std::uint32_t i = i0; i <= i1; ++i, k += n) {
        const Vector<F> n0 = point<F>(job, k + n, lanes), c0 = point<F>(job, k + n + 1, lanes);
        const Vector<F> sum = add_cross(add_cross(Vector<F>{}, n1 - n0, n2 - c0), c2 - n0, n3 - n2);
        const F square = multiply_add(sum.z, sum.z, multiply_add(sum.y, sum.y, sum.x * sum.x));
        const unsigned in = within(square, lanes);
        const F y = estimate(square, in);
        const F inverse = 0.5f * y * multiply_add(-(square * y), y, F{} + 3.0f);
        store(job.out.x + k, lanes, product(sum.x, inverse, in));
        store(job.out.y + k, lanes, product(sum.y, inverse, in));
        store(job.out.z + k, lanes, product(sum.z, inverse, in));
        good &= in;
        n2 = here;
        c2 = n3;
        here = n0;
        n1 = c0;
        n3 = point<F>(job, k + n - 1, lanes);
    }
    return good == lanes;
}

bool normals(const NormalJob& asked) noexcept {
    const NormalJob job = asked;
    bool good = true;
    for (std::uint32_t i0 = job.rect.i0; i0 <= job.rect.i1; i0 += kRows) {
        const std::uint32_t i1 = i0 + kRows - 1 < job.rect.i1 ? i0 + kRows - 1 : job.rect.i1;
        std::uint32_t j = job.rect.j0;
        for (; j + 15 <= job.rect.j1; j += 16) good = strip<Sixteen>(job, i0, i1, j, 0xFFFF) && good;
        if (j > job.rect.j1) continue;
        const std::uint32_t left = job.rect.j1 - j + 1;
        const unsigned lanes = (1u << left) - 1;
        good = (left > 8 ? strip<Sixteen>(job, i0, i1, j, lanes) : strip<Eight>(job, i0, i1, j, lanes)) && good;
    }
    return good;
}
}  // namespace

extern const NormalLoops kAvx512Normals;
const NormalLoops kAvx512Normals = normals;

}  // namespace dgm::detail

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
