// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/parameterize/limb_growth_test.cpp
// A needle that a convex map shrinks to a point gets the room that its plate has.
#include "geometry/parameterize/limb_growth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "disks.h"
#include "geometry/chart/square_chart.h"
#include "geometry/parameterize/convex_map.h"
#include "geometry/parameterize/slim.h"
#include "geometry/parameterize/stretch_map.h"
#include "laid_disk.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

constexpr std::uint32_t kCells = 5, kRings = 14;
constexpr double kHeight = 3;

/// A unit plate of 5 x 5 cells. In place of the middle one stands a pyramid of so many rings of four vertices.
testing::Disk plate_with_needle() {
    testing::Disk out;
    const auto at = [](std::uint32_t i, std::uint32_t j) { return i * (kCells + 1) + j; };
    for (std::uint32_t i = 0; i <= kCells; ++i)
        for (std::uint32_t j = 0; j <= kCells; ++j) {
            out.positions.push_back({double(j) / kCells, double(i) / kCells, 0});
        }
    for (std::uint32_t i = 0; i < kCells; ++i)
        for (std::uint32_t j = 0; j < kCells; ++j) {
            if (i == 2 && j == 2) continue;
            const std::uint32_t a = at(i, j), b = at(i, j + 1), c = at(i + 1, j + 1), d = at(i + 1, j);
            const bool rising = (i < 3) == (j < 3);  // no corner of the plate is cut off
            if (rising) out.faces.insert(out.faces.end(), {{a, b, c}, {a, c, d}});
            if (!rising) out.faces.insert(out.faces.end(), {{a, b, d}, {b, c, d}});
        }
    std::vector<std::uint32_t> below{at(2, 2), at(2, 3), at(3, 3), at(3, 2)};
    for (std::uint32_t r = 1; r < kRings; ++r) {
        std::vector<std::uint32_t> ring;
        for (const std::uint32_t corner : {at(2, 2), at(2, 3), at(3, 3), at(3, 2)}) {
            const Vec3d q = out.positions[corner];
            const double left = 1 - double(r) / kRings;
            ring.push_back(static_cast<std::uint32_t>(out.positions.size()));
            out.positions.push_back({0.5 + left * (q.x - 0.5), 0.5 + left * (q.y - 0.5), kHeight * (1 - left)});
        }
        for (std::size_t k = 0; k < 4; ++k) {
            const std::size_t n = (k + 1) % 4;
            out.faces.insert(out.faces.end(), {{below[k], below[n], ring[n]}, {below[k], ring[n], ring[k]}});
        }
        below = ring;
    }
    const auto tip = static_cast<std::uint32_t>(out.positions.size());
    out.positions.push_back({0.5, 0.5, kHeight});
    for (std::size_t k = 0; k < 4; ++k) out.faces.push_back({below[k], below[(k + 1) % 4], tip});
    testing::find_border(out);
    for (const std::uint32_t v : out.border) out.border_uv.push_back({out.positions[v].x, out.positions[v].y});
    return out;
}

/// The map by equal weights, which shrinks each ring to a fifth of the one about it.
std::vector<Vec2d> convex_map(const testing::Disk& disk) {
    ConvexMapSolver solver(disk.positions.size(), disk.faces, disk.border);
    return solver.solve(std::vector<double>(solver.edges().size(), 1.0), disk.border_uv);
}

double ring_radius(const std::vector<Vec2d>& uv, std::uint32_t ring) {
    const std::size_t first = (kCells + 1) * (kCells + 1) + 4 * std::size_t{ring - 1};
    Vec2d mean;
    for (std::size_t k = 0; k < 4; ++k) mean = mean + uv[first + k] * 0.25;
    double out = 0;
    for (std::size_t k = 0; k < 4; ++k) out += 0.25 * length(uv[first + k] - mean);
    return out;
}

TEST(LimbGrowth, ANeedleGetsRoom) {
    const testing::Disk disk = plate_with_needle();
    const DiskView view = disk.view();
    const std::vector<Vec2d> start = convex_map(disk);
    ASSERT_EQ(count_not_positive(view.faces, start), 0u);
    ASSERT_LT(ring_radius(start, kRings - 1), 1e-7) << "as crowded as the test means it";
    const std::vector<Vec2d> grown = grow_limbs(view, start, 20, {});
    EXPECT_EQ(count_not_positive(view.faces, grown), 0u);
    for (std::size_t k = 0; k < disk.border.size(); ++k) EXPECT_EQ(grown[disk.border[k]], disk.border_uv[k]);
    EXPECT_LT(l2_stretch(view.positions, view.faces, grown), 1e-5 * l2_stretch(view.positions, view.faces, start));
    // Straight down the pyramid the rings would shrink evenly, by 1/14 of the first.
    for (std::uint32_t r = 2; r < kRings; ++r)
        EXPECT_GT(ring_radius(grown, r), 0.3 * (1 - double(r) / kRings) * ring_radius(grown, 1)) << "ring " << r;
    EXPECT_EQ(grow_limbs(view, start, 20, {}), grown) << "the same bits again";
}

TEST(LimbGrowth, NothingIsGainedOnAPlate) {
    const testing::Disk plate = testing::grid(6, 6, [](double s, double t) { return Vec3d{s, t, 0}; });
    std::vector<Vec2d> uv;
    for (const Vec3d& p : plate.positions) uv.push_back({p.x, p.y});
    testing::Disk disk = plate;
    testing::find_border(disk);
    disk.border_uv.clear();
    for (const std::uint32_t v : disk.border) disk.border_uv.push_back(uv[v]);
    EXPECT_EQ(grow_limbs(disk.view(), uv, 5, {}), uv) << "the identity has the least stretch of all";
}

TEST(LimbGrowth, UncrowdingEndsNearTheLeastStretch) {
    const testing::Disk disk = plate_with_needle();
    const DiskView view = disk.view();
    const std::vector<Vec2d> uv = uncrowd(view, convex_map(disk), 1, {});
    EXPECT_EQ(count_not_positive(view.faces, uv), 0u);
    // A descent of two thousand steps from a map that is not crowded: the needle squashed onto the middle of its plate.
    std::vector<Vec2d> flat;
    for (const Vec3d& p : disk.positions) flat.push_back({p.x, p.y});
    SlimOptions options;
    options.energy = FlipFreeEnergy::kStretch;
    options.border_fixed = true;
    options.iterations = 2000;
    options.tolerance = 1e-9;
    options.patience = 5;
    flat = descend_flip_free(view, std::move(flat), options, {});
    EXPECT_LT(l2_stretch(view.positions, view.faces, uv), 1.02 * l2_stretch(view.positions, view.faces, flat));
}

// A finger 75 times as long as wide. Maps that were refined from a coarse one have a stretch of 12,000 and 44,000.
TEST(LimbGrowth, FingersOfFewAndManyFacesGetRoom) {
    for (const std::uint32_t along : {100u, 400u}) {
        const TriMesh mesh = test::finger(0.02, 3, 40, along, 10);
        EXPECT_EQ(mesh.faces.size() > 25'000, along == 400) << "many are mended on a coarser level";
        const test::LaidDisk laid = test::lay(mesh, 129, 0);
        const std::vector<Vec2d> uv = make_stretch_parameterizer(8)->solve(laid.view(), {});
        EXPECT_EQ(count_not_positive(laid.view().faces, uv), 0u);
        EXPECT_LT(l2_stretch(laid.view().positions, laid.view().faces, uv), 12);
    }
}

}  // namespace
}  // namespace dgm::bake
