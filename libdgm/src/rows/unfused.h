// SPDX-License-Identifier: MIT
// libdgm/src/rows/unfused.h
// What rows_impl.h and contact_rows_impl.h fuse where the processor can, for targets that cannot. Included inside a
// namespace.
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
