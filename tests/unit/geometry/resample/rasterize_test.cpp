// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/resample/rasterize_test.cpp
// Which triangle a sample gets, against integer arithmetic; where barycentrics put it.
#include "geometry/resample/rasterize.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <tuple>

#include "support/meshes.h"

namespace dgm::bake {
namespace {

using Whole = std::array<std::int64_t, 2>;

std::int64_t twice_area(const Whole& a, const Whole& b, const Whole& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// A lattice of cells x cells on [0, 2^12]^2, inner vertices moved; some stay where samples are.
struct Jittered {
    std::vector<Whole> whole;
    std::vector<Vec2d> uv;
    std::vector<Face> faces;
};
constexpr std::int64_t kSide = 4096;
Jittered jittered(std::uint32_t cells, unsigned seed) {
    std::mt19937 random(seed);
    Jittered out;
    const std::int64_t step = kSide / cells;
    for (std::uint32_t i = 0; i <= cells; ++i)
        for (std::uint32_t j = 0; j <= cells; ++j) {
            Whole p{i * step, j * step};
            const bool inner = i > 0 && j > 0 && i < cells && j < cells;
            // Less than a quarter of a cell in each direction keeps every face's winding.
            if (inner && random() % 3 != 0)
                for (auto& x : p) x += static_cast<std::int64_t>(random() % (step / 2 - 1)) - (step / 4 - 1);
            out.whole.push_back(p);
            out.uv.push_back({static_cast<double>(p[0]) / kSide, static_cast<double>(p[1]) / kSide});
        }
    out.faces = test::lattice_faces(cells + 1, cells + 1);
    std::shuffle(out.faces.begin(), out.faces.end(), random);
    for (Face& f : out.faces) std::rotate(f.begin(), f.begin() + random() % 3, f.end());
    return out;
}

TEST(Rasterize, EverySampleGetsTheLowestFaceThatHoldsIt) {
    for (const auto& [cells, m, n] :
         {std::tuple{8u, 33u, 33u}, {16u, 17u, 65u}, {4u, 129u, 9u}, {32u, 33u, 33u}, {2u, 3u, 3u}}) {
        const Jittered mesh = jittered(cells, cells + m);
        const SampleGrid grid = rasterize(mesh.faces, mesh.uv, m, n);
        ASSERT_EQ(grid.samples.size(), std::size_t{m} * n);
        EXPECT_EQ(grid.missing, 0u);
        std::size_t shared = 0;
        for (std::uint32_t i = 0; i < m; ++i)
            for (std::uint32_t j = 0; j < n; ++j) {
                const Whole c{i * kSide / (m - 1), j * kSide / (n - 1)};
                std::uint32_t want = kNone, holders = 0;
                for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
                    const Whole &p = mesh.whole[mesh.faces[f][0]], &q = mesh.whole[mesh.faces[f][1]],
                                &r = mesh.whole[mesh.faces[f][2]];
                    ASSERT_GT(twice_area(p, q, r), 0);
                    if (twice_area(p, q, c) < 0 || twice_area(q, r, c) < 0 || twice_area(r, p, c) < 0) continue;
                    ++holders;
                    if (want == kNone) want = f;
                }
                shared += holders > 1;
                const SurfaceSample& s = grid.samples[std::size_t{i} * n + j];
                ASSERT_EQ(s.face, want) << i << ", " << j;
                // Barycentrics: a partition of one that gives the sample's own place back.
                Vec2d at;
                double sum = 0;
                for (int k = 0; k < 3; ++k) {
                    ASSERT_GE(s.b[k], 0);
                    sum += s.b[k];
                    at = at + mesh.uv[mesh.faces[s.face][k]] * s.b[k];
                }
                ASSERT_NEAR(sum, 1, 1e-14);
                ASSERT_LT(length(at - Vec2d{i / (m - 1.0), j / (n - 1.0)}), 1e-14);
            }
        EXPECT_GT(shared, 4u) << "the test must meet samples on edges and vertices";
    }
}

/// Coordinates that no double holds: still no hole along any edge.
TEST(Rasterize, NoHolesWhenCoordinatesAreRounded) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> u(-0.24, 0.24);
    for (std::uint32_t cells : {3u, 7u, 11u, 30u})
        for (std::uint32_t m : {4u, 12u, 31u, 62u}) {
            std::vector<Vec2d> uv;
            for (std::uint32_t i = 0; i <= cells; ++i)
                for (std::uint32_t j = 0; j <= cells; ++j) {
                    const bool inner = i > 0 && j > 0 && i < cells && j < cells;
                    const double x = inner && random() % 2 ? u(random) : 0, y = inner && random() % 2 ? u(random) : 0;
                    uv.push_back({(i + x) / cells, (j + y) / cells});
                }
            EXPECT_EQ(rasterize(test::lattice_faces(cells + 1, cells + 1), uv, m, m + 3).missing, 0u)
                << cells << " " << m;
        }
}

TEST(Rasterize, SamplesBesideTheMapAreMissing) {
    const std::vector<Vec2d> uv{{0, 0}, {1, 0}, {0, 1}};
    const SampleGrid grid = rasterize(std::vector<Face>{{0, 1, 2}}, uv, 5, 5);
    EXPECT_EQ(grid.missing, 10u);  // 25 less the closed half
    for (std::uint32_t i = 0; i < 5; ++i)
        for (std::uint32_t j = 0; j < 5; ++j) EXPECT_EQ(grid.samples[i * 5 + j].face, i + j <= 4 ? 0u : kNone);
}

TEST(Rasterize, TurnedAndOutlyingFacesCoverNothing) {
    const std::vector<Vec2d> uv{{0, 0}, {1, 0}, {0, 1}, {5, 5}, {9, 5}, {5, 9}};
    EXPECT_EQ(rasterize(std::vector<Face>{{0, 2, 1}, {3, 4, 5}, {0, 0, 1}}, uv, 4, 4).missing, 16u);
}

TEST(Rasterize, PositionsFollowTheSurface) {
    TriMesh mesh = test::grid_sheet(5, 3);
    std::vector<Vec2d> uv;
    for (Vec3d& p : mesh.positions) {
        uv.push_back({p.x, p.y});
        p = {1 + 2 * p.x - p.y, 3 * p.y, p.x + p.y};
    }
    const SampleGrid grid = rasterize(mesh.faces, uv, 8, 11);
    for (std::uint32_t i = 0; i < 8; ++i)
        for (std::uint32_t j = 0; j < 11; ++j) {
            const double x = i / 7.0, y = j / 10.0;
            EXPECT_LT(length(position_at(mesh, grid.samples[i * 11 + j]) - Vec3d{1 + 2 * x - y, 3 * y, x + y}), 1e-13);
        }
}

}  // namespace
}  // namespace dgm::bake
