// SPDX-License-Identifier: GPL-3.0-or-later
// cli/page/packed_mesh.h
// A mesh to look at, as deflate likes it.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "model/tri_mesh.h"

namespace dgm::page {

/// Positions on a lattice: low + step * code, step the same on all axes, codes 0 .. 65535. web/source.js turns it back.
struct PackedMesh {
    model::Vec3d low;
    double step = 1;
    /// Low bytes of 3 numbers a vertex, then their high bytes: the code less that of the vertex before, modulo 2^16.
    /// Then the bytes of 3 numbers a face, lowest bytes first: the index less the one before, modulo 2^32. Both
    /// by sign_last().
    std::vector<std::byte> bytes;
};

/// Positions that are not finite become `low`. Faces name positions that are there.
[[nodiscard]] PackedMesh packed_mesh(std::span<const model::Vec3d> positions, std::span<const model::Face> faces);

}  // namespace dgm::page
