// SPDX-License-Identifier: MIT
// libdgm/src/rows/pairs.h
// Takes vectors apart and puts them together. Included inside a namespace, after Floats and kLanes.

template <int... k>
struct Places {
    /// Values 0, 2, 4, ... and 1, 3, 5, ... of a row of two vectors.
    static DGM_INLINE Floats evens(const Floats& a, const Floats& b) { return __builtin_shufflevector(a, b, 2 * k...); }
    static DGM_INLINE Floats odds(const Floats& a, const Floats& b) {
        return __builtin_shufflevector(a, b, 2 * k + 1 ...);
    }
    /// The row of two vectors whose even and odd values are given.
    static DGM_INLINE Floats first(const Floats& e, const Floats& o) {
        return __builtin_shufflevector(e, o, (k / 2 + k % 2 * kLanes)...);
    }
    /// Each value's neighbour on the left; `before` is what lies left of the vector.
    static DGM_INLINE Floats left(const Floats& before, const Floats& here) {
        return __builtin_shufflevector(before, here, (kLanes - 1 + k)...);
    }
    static DGM_INLINE Floats second(const Floats& e, const Floats& o) {
        return __builtin_shufflevector(e, o, (kLanes / 2 + k / 2 + k % 2 * kLanes)...);
    }
};
template <int n, int... k>
struct Count : Count<n - 1, n - 1, k...> {};
template <int... k>
struct Count<0, k...> {
    typedef Places<k...> Of;
};
typedef Count<kLanes>::Of Pairs;
