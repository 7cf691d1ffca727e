// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/grid_cells.cpp
#include "geometry/fit/grid_cells.h"

#include <dgm/grid.h>

#include <algorithm>
#include <utility>

namespace dgm::bake {

GridCells::GridCells(const SampledChart& chart, const WeldedGrid& grid) : chart_(chart), grid_(grid) {
    const std::vector<Face>& faces = grid.surface.faces;
    std::uint32_t strip = 0;
    for (std::uint32_t q = 0; q < grid.face_of_quad.size(); ++q) {
        if (grid.face_of_quad[q] == kNone) continue;
        quads_.push_back(q);
        first_face_.push_back(grid.face_of_quad[q]);
        strip = grid.face_of_quad[q] + 2;
    }
    for (; strip < faces.size(); ++strip) first_face_.push_back(strip);
    cell_of_face_.resize(faces.size());
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;  // class, cell
    for (std::uint32_t cell = 0; cell < size(); ++cell)
        for (unsigned diagonal = 0; diagonal < 2; ++diagonal) {
            const CellFaces of = this->faces(cell, diagonal);
            for (int k = 0; k < of.count; ++k) {
                cell_of_face_[first_face_[cell] + static_cast<std::uint32_t>(k)] = cell;
                for (const std::uint32_t c : of.faces[k]) pairs.emplace_back(c, cell);
            }
        }
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    first_.assign(grid.surface.positions.size() + 1, 0);
    cells_.reserve(pairs.size());
    for (const auto& [c, cell] : pairs) {
        ++first_[c + 1];
        cells_.push_back(cell);
    }
    for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
}

CellFaces GridCells::faces(std::uint32_t cell, unsigned diagonal) const {
    if (!is_quad(cell)) {
        if (diagonal != 0) return {};
        return {{grid_.surface.faces[first_face_[cell]]}, 1};
    }
    CellFaces out;
    const std::uint32_t n = chart_.n, i = quads_[cell] / (n - 1), j = quads_[cell] % (n - 1);
    for (const Face& t : quad_triangles(i, j, n, diagonal))
        out.faces[out.count++] = {grid_.class_of[t[0]], grid_.class_of[t[1]], grid_.class_of[t[2]]};
    return out;
}

std::pair<std::uint32_t, std::uint32_t> GridCells::ends(std::uint32_t cell, unsigned diagonal) const {
    const std::uint32_t n = chart_.n, a = quads_[cell] / (n - 1) * n + quads_[cell] % (n - 1);
    const std::uint32_t from = grid_.class_of[diagonal == 0 ? a : a + n];
    const std::uint32_t to = grid_.class_of[diagonal == 0 ? a + n + 1 : a + 1];
    return std::minmax(from, to);
}

}  // namespace dgm::bake
