// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/simplify/quadric.h
// Sum of weighted squared distances to planes [Garland, Heckbert 1997].
#pragma once
#include "model/vec.h"

namespace dgm::bake {

/// Q(x) = x^T A x + 2 b.x + c with A symmetric. The weights' sum is the trace of A.
struct Quadric {
    double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
    model::Vec3d b;
    double c = 0;

    /// Adds the plane through `p` with unit normal `n`.
    void add_plane(const model::Vec3d& n, const model::Vec3d& p, double weight) {
        const double d = -dot(n, p);
        xx += weight * n.x * n.x;
        xy += weight * n.x * n.y;
        xz += weight * n.x * n.z;
        yy += weight * n.y * n.y;
        yz += weight * n.y * n.z;
        zz += weight * n.z * n.z;
        b += n * (weight * d);
        c += weight * d * d;
    }
    Quadric& operator+=(const Quadric& q) {
        xx += q.xx;
        xy += q.xy;
        xz += q.xz;
        yy += q.yy;
        yz += q.yz;
        zz += q.zz;
        b += q.b;
        c += q.c;
        return *this;
    }
    [[nodiscard]] double operator()(const model::Vec3d& p) const {
        return p.x * (xx * p.x + 2 * (xy * p.y + xz * p.z + b.x)) + p.y * (yy * p.y + 2 * (yz * p.z + b.y)) +
               p.z * (zz * p.z + 2 * b.z) + c;
    }
    [[nodiscard]] double weight() const { return xx + yy + zz; }
};

}  // namespace dgm::bake
