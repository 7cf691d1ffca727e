// SPDX-License-Identifier: MIT
// libdgm/src/rows/vectors.h
// Vectors of one number of lanes. Included inside a namespace, after Floats and kLanes, where a Field of three rows is
// known.

static DGM_INLINE Floats load(const float* from) {
    Floats v;
    __builtin_memcpy(&v, from, sizeof v);
    return v;
}
static DGM_INLINE void store(float* to, const Floats& v) {
    __builtin_memcpy(to, &v, sizeof v);
}
static DGM_INLINE Floats all(float v) {
    return Floats{} + v;
}
static DGM_INLINE Floats larger(const Floats& a, const Floats& b) {
    return a > b ? a : b;
}

struct V3 {
    Floats x, y, z;
};
static DGM_INLINE V3 operator+(const V3& a, const V3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
static DGM_INLINE V3 operator-(const V3& a, const V3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
static DGM_INLINE V3 operator*(const Floats& s, const V3& a) {
    return {s * a.x, s * a.y, s * a.z};
}
static DGM_INLINE V3 operator*(float s, const V3& a) {
    return {s * a.x, s * a.y, s * a.z};
}
static DGM_INLINE Floats dot(const V3& a, const V3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static DGM_INLINE V3 cross(const V3& a, const V3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static DGM_INLINE V3 load(const Field& f, std::ptrdiff_t s) {
    return {load(f.p[0] + s), load(f.p[1] + s), load(f.p[2] + s)};
}
static DGM_INLINE void store(const Field& f, std::ptrdiff_t s, const V3& v) {
    store(f.p[0] + s, v.x);
    store(f.p[1] + s, v.y);
    store(f.p[2] + s, v.z);
}
