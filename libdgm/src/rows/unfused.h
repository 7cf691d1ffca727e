// SPDX-License-Identifier: MIT
// libdgm/src/rows/unfused.h
// Multiplies and adds in two steps, for targets without the fused operation of rows_impl.h and contact_rows_impl.h.
// Included inside a namespace.
template <class F>
inline F multiply_add(const F& a, const F& b, const F& c) {
    return a * b + c;
}
template <class F>
inline F multiply_subtract(const F& a, const F& b, const F& c) {
    return a * b - c;
}
template <class F>
inline F subtract_product(const F& c, const F& a, const F& b) {
    return c - a * b;
}
