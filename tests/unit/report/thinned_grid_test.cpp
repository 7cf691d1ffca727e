// SPDX-License-Identifier: GPL-3.0-or-later
#include "report/thinned_grid.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <utility>

#include "charts.h"

namespace dgm::report {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// Directed edges without a twin; fails on one that is there twice.
std::set<Edge> border_of(const std::vector<model::Face>& faces) {
    std::set<Edge> edges;
    for (const model::Face& f : faces)
        for (std::size_t k = 0; k < 3; ++k) EXPECT_TRUE(edges.insert({f[k], f[(k + 1) % 3]}).second);
    std::set<Edge> border;
    for (const Edge& e : edges)
        if (!edges.contains({e.second, e.first})) border.insert(e);
    return border;
}

/// Area of the grid that faces cover, in quads; each counts as positive if wound as (u, v).
double map_area(const std::vector<model::Face>& faces, std::uint32_t cols) {
    double area = 0;
    for (const model::Face& f : faces) {
        const auto at = [&](std::uint32_t v) { return model::Vec2d{double(v / cols), double(v % cols)}; };
        const double signed_area = 0.5 * cross(at(f[1]) - at(f[0]), at(f[2]) - at(f[0]));
        EXPECT_GT(signed_area, 0);
        area += signed_area;
    }
    return area;
}

TEST(ThinnedGrid, HasNoCracksAndKeepsItsBorder) {
    for (const auto& [rows, cols] : {std::pair{17U, 17U}, {18U, 23U}, {9U, 40U}, {4U, 4U}, {3U, 3U}}) {
        const model::Chart chart = hill(rows, cols);
        const bake::Reconstruction full = bake::reconstruct(chart);
        const std::set<Edge> border = border_of(full.mesh.faces);
        for (const std::uint32_t stride : {1U, 2U, 4U, 8U, 64U}) {
            const std::vector<model::Face> thin = thinned_faces(chart, full, stride);
            EXPECT_EQ(border_of(thin), border) << rows << "x" << cols << " stride " << stride;
            EXPECT_DOUBLE_EQ(map_area(thin, cols), (rows - 1.0) * (cols - 1.0));
        }
    }
}

TEST(ThinnedGrid, IsThin) {
    const model::Chart chart = hill(129, 129);
    const bake::Reconstruction full = bake::reconstruct(chart);
    // 32 x 32 blocks; those in the middle are two triangles each, the 124 at the border have four or seven more.
    EXPECT_LT(thinned_faces(chart, full, 4).size(), 2U * 32 * 32 + 128 * 8);
}

TEST(ThinnedGrid, HolesStay) {
    model::Chart chart = hill(17, 17);
    model::Layer mask{"mask", model::ElementType::kU8, {17, 17}, std::vector<std::byte>(17 * 17, std::byte{1}), {},
                      true};
    mask.bytes[8 * 17 + 9] = std::byte{0};
    chart.domain = model::Domain::kFree;
    chart.layers.push_back(mask);
    const bake::Reconstruction full = bake::reconstruct(chart);
    for (const std::uint32_t stride : {2U, 4U}) {
        const std::vector<model::Face> thin = thinned_faces(chart, full, stride);
        EXPECT_EQ(border_of(thin), border_of(full.mesh.faces));
        EXPECT_DOUBLE_EQ(map_area(thin, 17), 16 * 16 - 4.0);
    }
}

}  // namespace
}  // namespace dgm::report
