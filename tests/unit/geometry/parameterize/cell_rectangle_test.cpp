// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/parameterize/cell_rectangle_test.cpp
#include "geometry/parameterize/cell_rectangle.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/chart/square_chart.h"
#include "geometry/cut/cut_graph.h"
#include "geometry/metrics/map_metrics.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

/// Two faces of the unit square and a point inside.
struct Square {
    std::vector<Vec3d> positions{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.3, 0.4, 0}};
    std::vector<Face> faces{{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
    std::vector<std::uint32_t> border{0, 1, 2, 3};
    std::vector<Vec2d> border_uv{{0, 0}, {1, 0}, {1, 1}, {0, 1}};

    [[nodiscard]] DiskView view(double aspect) const { return {positions, faces, border, border_uv, aspect}; }
};

TEST(CellRectangle, HasAreaOneAndSidesAsTheGrid) {
    const Square square;
    const DiskView disk = square.view(4);
    const CellRectangle cells(disk);
    ASSERT_EQ(cells.view().border_uv.size(), 4u);
    EXPECT_EQ(cells.view().border_uv[2], (Vec2d{2, 0.5}));
    EXPECT_EQ(cells.view().aspect, 1) << "nothing is left to be done";
    EXPECT_EQ(cells.from_square({{0.5, 0.5}})[0], (Vec2d{1, 0.25}));
}

TEST(CellRectangle, TheWayBackKeepsTheBorderToTheBit) {
    const Square square;
    for (const double aspect : {1.0, 3.0, 1 / 7.0, 15.3}) {
        const DiskView disk = square.view(aspect);
        const CellRectangle cells(disk);
        std::vector<Vec2d> uv(square.border_uv);
        uv.push_back({0.3, 0.7});
        const std::vector<Vec2d> back = cells.to_square(cells.from_square(uv));
        for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(back[k], square.border_uv[k]);
        EXPECT_NEAR(back[4].x, 0.3, 1e-15);
        EXPECT_NEAR(back[4].y, 0.7, 1e-15);
    }
}

TEST(CellRectangle, ASquareGridIsLeftAsItIs) {
    const Square square;
    const DiskView disk = square.view(1);
    const CellRectangle cells(disk);
    EXPECT_EQ(cells.view().border_uv.data(), disk.border_uv.data());
}

/// A wave along x: a grid with four times as many samples along it as across has less error if the map knows that.
TEST(CellRectangle, StretchCountsInCells) {
    TriMesh mesh = test::grid_sheet(60, 60);
    for (Vec3d& p : mesh.positions) p.z = 0.1 * std::sin(12 * p.x * (1 + p.y)) + 0.05 * std::sin(9 * p.y);
    const Disk disk = CutGraph(mesh).open();
    const auto method = make_stretch_parameterizer(8, Levelling::kDirections);
    // The same chart, but by a method that takes every cell for a square.
    struct Blind final : Parameterizer {
        explicit Blind(const Parameterizer& of) : of_(of) {}
        [[nodiscard]] std::string_view name() const override { return "blind"; }
        [[nodiscard]] bool fixed_border() const override { return true; }
        [[nodiscard]] std::vector<Vec2d> solve(const DiskView& view, const model::Progress& p) const override {
            DiskView square = view;
            square.aspect = 1;
            return of_.solve(square, p);
        }
        const Parameterizer& of_;
    };
    const double seeing = quick_error(mesh, make_square_chart(disk, 65, 17, 0, *method, {}), 20'000).rms;
    const auto other = make_stretch_parameterizer(8, Levelling::kDirections);
    const double blind = quick_error(mesh, make_square_chart(disk, 65, 17, 0, Blind(*other), {}), 20'000).rms;
    EXPECT_LT(seeing, blind);
}

}  // namespace
}  // namespace dgm::bake
