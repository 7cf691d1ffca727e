// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/cgal/cgal_parameterizers_test.cpp
#include "geometry/cgal/cgal_parameterizers.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <string>

#include "geometry/cgal/border_simple.h"
#include "geometry/metrics/map_metrics.h"
#include "geometry/parameterize/slim.h"
#include "unit/geometry/parameterize/disks.h"

namespace dgm::bake {
namespace {
using testing::Disk;
const model::Progress kSilent;

std::vector<Vec2d> solve(std::string_view method, const Disk& d, SolveStatistics* statistics = nullptr) {
    return make_cgal_parameterizer(method, statistics)->solve(d.view(), kSilent);
}

/// A planar patch with uneven faces: (s, t) bent a little, in the plane z = 0, convex border.
Disk flat_patch(std::uint32_t n) {
    return testing::grid(n, n, [](double s, double t) {
        const double b = s * (1 - s) * t * (1 - t);
        return Vec3d{0.7 * s + 0.8 * b * t, 0.5 * t - 0.6 * b * s, 0};
    });
}

class FixedMethods : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, FixedMethods, ::testing::Values("tutte", "mvc", "authalic", "conformal"));

TEST_P(FixedMethods, KeepTheBorderToTheBitAndFlipNothing) {
    Disk d = testing::grid(12, 9, [](double s, double t) {
        return Vec3d{s, t, 0.4 * std::sin(3 * s) * std::cos(2 * t)};
    });
    testing::put_grid_border_on_square(d, 12, 9);
    // Uneven along the sides, so that no method could have placed them itself.
    for (Vec2d& p : d.border_uv) p = {p.x * p.x * (3 - 2 * p.x), p.y * (0.5 + 0.5 * p.y)};
    SolveStatistics statistics;
    const std::vector<Vec2d> uv = solve(GetParam(), d, &statistics);
    for (std::size_t k = 0; k < d.border.size(); ++k)
        EXPECT_EQ(std::memcmp(&uv[d.border[k]], &d.border_uv[k], sizeof(Vec2d)), 0) << k;
    EXPECT_EQ(count_not_positive(d.faces, uv), 0U);
    EXPECT_EQ(statistics.factorizations, 1U);
    EXPECT_EQ(statistics.solves, 2U);
}

TEST(CgalParameterizers, TutteVerticesAreMeansOfTheirNeighbours) {
    Disk d = testing::grid(8, 8, [](double s, double t) { return Vec3d{s, t, s * t}; });
    testing::put_grid_border_on_square(d, 8, 8);
    const std::vector<Vec2d> uv = solve("tutte", d);
    std::vector<Vec2d> sum(uv.size());
    std::vector<double> count(uv.size(), 0);
    for (const Face& f : d.faces)  // every neighbour of an interior vertex is counted by two faces
        for (std::size_t k = 0; k < 3; ++k) {
            sum[f[k]] = sum[f[k]] + uv[f[(k + 1) % 3]] + uv[f[(k + 2) % 3]];
            count[f[k]] += 2;
        }
    for (std::uint32_t v = 0; v < uv.size(); ++v) {
        if (std::find(d.border.begin(), d.border.end(), v) != d.border.end()) continue;
        EXPECT_NEAR(uv[v].x, sum[v].x / count[v], 1e-14);
        EXPECT_NEAR(uv[v].y, sum[v].y / count[v], 1e-14);
    }
}

TEST(CgalParameterizers, PlanarMeshesAreReproduced) {
    // Mean value and cotangent weights have linear precision: a planar patch whose border is mapped affinely is mapped
    // affinely. Authalic ones share it.
    Disk d = flat_patch(8);
    testing::put_grid_border_on_square(d, 8, 8);
    for (const char* method : {"mvc", "conformal", "authalic"}) {
        const std::vector<Vec2d> uv = solve(method, d);
        for (std::size_t v = 0; v < uv.size(); ++v) {
            EXPECT_NEAR(uv[v].x, d.positions[v].x / 0.7, 1e-12) << method;
            EXPECT_NEAR(uv[v].y, d.positions[v].y / 0.5, 1e-12) << method;
        }
    }
}

TEST(CgalParameterizers, ObtuseFacesFallBackToPositiveWeights) {
    // A ridge so steep and skewed that cotangent weights go negative; Tutte's theorem needs positive ones.
    Disk d = testing::grid(6, 6, [](double s, double t) {
        return Vec3d{s + 4 * t, 0.05 * t, 0.9 * std::abs(std::sin(9 * s)) * t * (1 - t)};
    });
    testing::put_grid_border_on_square(d, 6, 6);
    for (const char* method : {"conformal", "authalic"}) {
        SolveStatistics statistics;
        EXPECT_EQ(count_not_positive(d.faces, solve(method, d, &statistics)), 0U) << method;
    }
}

TEST(CgalParameterizers, NamesAndBorders) {
    for (const char* name : {"tutte", "mvc", "authalic", "conformal"}) {
        const auto p = make_cgal_parameterizer(name);
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(p->name(), name);
        EXPECT_TRUE(p->fixed_border());
    }
    EXPECT_EQ(make_cgal_parameterizer("stretch"), nullptr);
    EXPECT_EQ(make_cgal_parameterizer("arap"), nullptr);
    EXPECT_EQ(make_cgal_parameterizer(""), nullptr);
}

TEST(CgalParameterizers, SmallestDisks) {
    Disk d{{{0, 0, 0}, {0.8, 0, 0}, {0, 0.6, 0}}, {{0, 1, 2}}, {0, 1, 2}, {{0, 0}, {1, 0}, {0, 1}}};
    EXPECT_EQ(solve("tutte", d), d.border_uv);
}

TEST(CgalParameterizers, RefuseWhatIsNoDisk) {
    Disk good = testing::grid(3, 3, [](double s, double t) { return Vec3d{s, t, 0}; });
    testing::put_grid_border_on_square(good, 3, 3);
    for (const auto& [what, disk] : testing::no_disks(good))
        for (const char* method : {"tutte", "mvc"}) testing::expect_no_map(what, [&] { return solve(method, disk); });
}

TEST(CgalParameterizers, FixedBorderNeedsPointsOnTheSquare) {
    Disk d = testing::grid(3, 3, [](double s, double t) { return Vec3d{s, t, 0}; });
    EXPECT_THROW(static_cast<void>(solve("mvc", d)), model::Error);
    testing::put_grid_border_on_square(d, 3, 3);
    d.border_uv[2].x = 1.5;
    EXPECT_THROW(static_cast<void>(solve("mvc", d)), model::Error);
}

}  // namespace
}  // namespace dgm::bake
