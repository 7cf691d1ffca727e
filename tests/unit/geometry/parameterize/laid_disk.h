// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/parameterize/laid_disk.h
// A mesh cut open, its border on the square: where a square map begins.
#pragma once
#include <cstdint>

#include "geometry/cut/cut_graph.h"
#include "geometry/parameterize/square_border.h"

namespace dgm::test {

struct LaidDisk {
    bake::Disk disk;
    bake::SquareBorder border;
    [[nodiscard]] bake::DiskView view() const {
        return {disk.mesh.positions, disk.mesh.faces, border.vertices, border.uv};
    }
};

/// `side` x `side` samples; the border starts at `rotation`.
inline LaidDisk lay(const bake::TriMesh& mesh, std::uint32_t side, std::uint32_t rotation) {
    bake::CutGraph cut(mesh);
    cut.cut_to_disk();
    LaidDisk out{cut.open(), {}};
    out.border = bake::lay_square_border(out.disk, side, side, rotation);
    return out;
}

}  // namespace dgm::test
