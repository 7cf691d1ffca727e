// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/grid_cells.h
// The quads of a welded grid as cells around its classes, whichever way each is split.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/chart/sampled_chart.h"
#include "geometry/fit/welded_grid.h"

namespace dgm::bake {

/// The triangles of a cell.
struct CellFaces {
    std::array<Face, 2> faces;  ///< corners are classes
    int count = 0;
};

/// A cell is a quad, or a face of the grid that belongs to none. Unlike faces, cells and what they surround stay the
/// same when diagonals change. Thread-safe.
class GridCells {
 public:
    /// @param chart, grid  must outlive the object; the grid is linked as the chart is split
    GridCells(const SampledChart& chart, const WeldedGrid& grid);

    [[nodiscard]] std::size_t size() const { return first_face_.size(); }
    [[nodiscard]] std::span<const std::uint32_t> around(std::uint32_t c) const {
        return std::span(cells_).subspan(first_[c], first_[c + 1] - first_[c]);
    }
    [[nodiscard]] std::uint32_t cell_of(std::uint32_t face) const { return cell_of_face_[face]; }
    [[nodiscard]] std::uint32_t first_face(std::uint32_t cell) const { return first_face_[cell]; }
    [[nodiscard]] bool is_quad(std::uint32_t cell) const { return cell < quads_.size(); }
    /// Of chart.diagonals. The cell is a quad.
    [[nodiscard]] std::uint32_t quad(std::uint32_t cell) const { return quads_[cell]; }
    /// How the chart splits it now; 0 if it is no quad.
    [[nodiscard]] unsigned diagonal(std::uint32_t cell) const {
        return is_quad(cell) ? chart_.diagonals[quads_[cell]] : 0;
    }
    /// Empty if the cell is no quad and `diagonal` is not 0.
    [[nodiscard]] CellFaces faces(std::uint32_t cell, unsigned diagonal) const;
    /// The classes that a diagonal of a quad joins, lower first.
    [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> ends(std::uint32_t cell, unsigned diagonal) const;

 private:
    const SampledChart& chart_;
    const WeldedGrid& grid_;
    std::vector<std::uint32_t> quads_, first_face_;  // per cell; quads come first
    std::vector<std::uint32_t> cell_of_face_;
    std::vector<std::uint32_t> first_, cells_;  // around each class: cells_[first_[c]] .. cells_[first_[c + 1] - 1]
};

}  // namespace dgm::bake
