// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/ring_error.h
// The squared distances around one sample of a grid, for places that it may go to.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/fit/grid_cells.h"
#include "geometry/fit/matches.h"
#include "geometry/mesh/triangle.h"

namespace dgm::bake {

/// A place of a sample, with the diagonals of the cells around it that go with it best.
struct RingPlace {
    static constexpr std::size_t kMostCells = 12;
    Vec3d position;
    double error = 0;                                  ///< sum of weighed squared distances
    std::array<std::uint8_t, kMostCells> diagonals{};  ///< in the order of GridCells::around()
};

/// How tilted and how thin faces around a sample may become.
struct RingBounds {
    double upright = 1;    ///< cosine to the source below
    double thickness = 1;  ///< twice the area over the longest edge squared
};

/// What the errors of all rings are measured with. Thread-safe while nothing is changed.
struct RingSurroundings {
    const LinkedSurface& source;
    const GridCells& cells;
    const std::vector<Vec3d>& positions;  ///< per class
    const Matches& matches;
    const std::vector<std::vector<std::uint32_t>>& points;  ///< per cell: matches.points over it
    const std::vector<char>& may_flip;                      ///< per cell
    double per_area;                                        ///< weight of the grid's faces, by area
};

/// Measures rings; keeps its memory from one to the next. One object a thread.
class RingError {
 public:
    explicit RingError(const RingSurroundings& around) : around_(around) {}

    /// The ring as it is. Its faces' bounds are those that the faces have, where they are weaker than what is given.
    [[nodiscard]] RingPlace present(std::uint32_t c, RingBounds& bounds);
    /// The ring with the sample at `place.position`; sets the rest of `place`.
    /// @return  false if its error is not below `limit`, or a face would be beyond the bounds
    [[nodiscard]] bool measure(std::uint32_t c, const RingBounds& bounds, double limit, RingPlace& place);
    /// Faces of the source that walks have looked at.
    [[nodiscard]] std::uint64_t looked() const { return looked_; }

 private:
    /// A cell split one way.
    struct Split {
        std::array<std::array<Vec3d, 3>, 2> corners;
        std::array<PreparedTriangle, 2> prepared;
        std::array<Vec3d, 2> normals;       // of length twice the area
        int count = 0;                      // 0: not possible
        double error = -1;                  // of its faces, back to the source; below 0: not looked up yet
        double upright = 1, thickness = 1;  // the least of its faces (RingBounds)
    };
    using Splits = std::array<Split, 2>;

    void set_split(std::uint32_t c, const Vec3d& position, std::size_t k, unsigned diagonal, double thickness);
    bool look_back(std::size_t k, unsigned diagonal, double upright);
    void set_box(std::size_t k);
    [[nodiscard]] double farther_than(std::size_t k, const Vec3d& p) const;
    bool gather(double limit);
    [[nodiscard]] double total(const RingPlace& place) const;
    bool choose(const RingBounds& bounds, double limit, RingPlace& place);

    const RingSurroundings& around_;
    std::span<const std::uint32_t> cells_;
    std::array<Splits, RingPlace::kMostCells> splits_;
    std::array<std::array<Vec3d, 2>, RingPlace::kMostCells> boxes_;  // least and greatest corner of a cell
    std::vector<double> squared_, weights_;                          // per point, cell and way; per point
    std::uint64_t looked_ = 0;
};

}  // namespace dgm::bake
