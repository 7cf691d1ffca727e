// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/cgal/cgal_parameterizers_test.cpp
#include "geometry/cgal/cgal_parameterizers.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <string>

#include "disks.h"
#include "geometry/cgal/border_simple.h"
#include "geometry/metrics/map_metrics.h"
#include "geometry/parameterize/slim.h"

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

/// An oblique half cylinder patch and where its vertices lie when it is unrolled.
Disk cylinder_patch(std::vector<Vec2d>& unrolled) {
    const double chord = 2 * 0.4 * std::sin(2.0 / 24);
    Disk d = testing::grid(7, 12, [](double s, double t) {
        const double angle = 2 * s;
        return Vec3d{0.4 * std::cos(angle), 0.4 * std::sin(angle), 0.35 * t};
    });
    unrolled.clear();
    for (std::uint32_t v = 0; v < d.positions.size(); ++v)
        unrolled.push_back({chord * (v % 13), 0.35 * static_cast<double>(v / 13) / 7});
    return d;
}

/// Largest distance after the best orientation-preserving similarity a -> z a + w (complex least squares).
double distance_up_to_similarity(const std::vector<Vec2d>& a, const std::vector<Vec2d>& b, double* scale = nullptr) {
    Vec2d ca, cb;
    for (std::size_t k = 0; k < a.size(); ++k) {
        ca = ca + a[k] * (1.0 / static_cast<double>(a.size()));
        cb = cb + b[k] * (1.0 / static_cast<double>(a.size()));
    }
    double re = 0, im = 0, norm = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
        const Vec2d p = a[k] - ca, q = b[k] - cb;
        re += dot(p, q);
        im += cross(p, q);
        norm += dot(p, p);
    }
    re /= norm;
    im /= norm;
    if (scale != nullptr) *scale = std::hypot(re, im);
    double worst = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
        const Vec2d p = a[k] - ca, q = b[k] - cb;
        worst = std::max(worst, length(Vec2d{re * p.x - im * p.y, im * p.x + re * p.y} - q));
    }
    return worst;
}

class FreeMethods : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, FreeMethods, ::testing::Values("lscm", "arap"));

TEST_P(FreeMethods, UnrollACylinderPatch) {
    std::vector<Vec2d> unrolled;
    const Disk d = cylinder_patch(unrolled);
    const std::vector<Vec2d> uv = solve(GetParam(), d);
    double scale = 0;
    // ARAP stops when its energy changes by less than a millionth, well before the last bit.
    EXPECT_LT(distance_up_to_similarity(uv, unrolled, &scale), GetParam() == std::string("lscm") ? 1e-10 : 2e-3);
    EXPECT_NEAR(scale, 1, GetParam() == std::string("lscm") ? 1e-10 : 2e-3);
    EXPECT_EQ(count_not_positive(d.faces, uv), 0U);
}

TEST_P(FreeMethods, NastyDisksComeOutFreeOfFlips) {
    const Disk disks[] = {testing::sphere_with_hole(24, 30, 0.02), testing::long_finger(8, 150)};
    for (const Disk& d : disks) {
        const std::vector<Vec2d> uv = solve(GetParam(), d);
        const MapMetrics m = measure_map(d.positions, d.faces, uv);
        EXPECT_EQ(m.flips, 0U);
        EXPECT_EQ(m.degenerate, 0U);
        EXPECT_EQ(m.not_finite, 0U);
    }
}

TEST_P(FreeMethods, AreDeterministic) {
    const Disk d = testing::sphere_with_hole(12, 12, 0.3);
    const auto a = solve(GetParam(), d), b = solve(GetParam(), d);
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec2d)), 0);
}

TEST(CgalParameterizers, LscmReproducesAPlanarPatch) {
    const Disk d = flat_patch(9);
    std::vector<Vec2d> plane;
    for (const Vec3d& p : d.positions) plane.push_back({p.x, p.y});
    double scale = 0;
    EXPECT_LT(distance_up_to_similarity(solve("lscm", d), plane, &scale), 1e-10);
    EXPECT_NEAR(scale, 1, 1e-10);  // the surface's area
}

TEST(CgalParameterizers, ArapFactorizesItsMatrixOnce) {
    SolveStatistics statistics;
    std::vector<Vec2d> unrolled;
    static_cast<void>(solve("arap", cylinder_patch(unrolled), &statistics));
    EXPECT_EQ(statistics.factorizations, 1U);
    EXPECT_GE(statistics.solves, 4U);  // two right-hand sides an iteration
    EXPECT_EQ(statistics.solves % 2, 0U);
    EXPECT_EQ(statistics.unsymmetric, 0U);
}

TEST(CgalParameterizers, ArapLowersTheRigidEnergyBelowLscm) {
    const Disk d = testing::grid(10, 10, [](double s, double t) {
        return Vec3d{s, t, 0.5 * std::exp(-12 * ((s - 0.5) * (s - 0.5) + (t - 0.5) * (t - 0.5)))};
    });
    const SlimOptions rigid{.energy = FlipFreeEnergy::kArap, .barrier = 1e-9};
    const double arap = flip_free_energy(d.view(), solve("arap", d), rigid);
    EXPECT_GT(arap, 0);
    EXPECT_LT(arap, 0.8 * flip_free_energy(d.view(), solve("lscm", d), rigid));
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
    for (const char* name : {"lscm", "arap", "tutte", "mvc", "authalic", "conformal"}) {
        const auto p = make_cgal_parameterizer(name);
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(p->name(), name);
        EXPECT_EQ(p->fixed_border(), name != std::string("lscm") && name != std::string("arap"));
    }
    EXPECT_EQ(make_cgal_parameterizer("stretch"), nullptr);
    EXPECT_EQ(make_cgal_parameterizer(""), nullptr);
}

TEST(CgalParameterizers, SmallestDisks) {
    Disk d{{{0, 0, 0}, {0.8, 0, 0}, {0, 0.6, 0}}, {{0, 1, 2}}, {0, 1, 2}, {{0, 0}, {1, 0}, {0, 1}}};
    EXPECT_EQ(solve("tutte", d), d.border_uv);
    const std::vector<Vec2d> plane{{0, 0}, {0.8, 0}, {0, 0.6}};
    for (const char* method : {"lscm", "arap"}) EXPECT_LT(distance_up_to_similarity(solve(method, d), plane), 1e-6);
}

TEST(CgalParameterizers, RefuseWhatIsNoDisk) {
    Disk good = testing::grid(3, 3, [](double s, double t) { return Vec3d{s, t, 0}; });
    testing::put_grid_border_on_square(good, 3, 3);
    const auto expect_refused = [](const char* what, const Disk& d) {
        for (const char* method : {"lscm", "arap", "tutte", "mvc"}) {
            try {
                static_cast<void>(solve(method, d));
                ADD_FAILURE() << method << " took " << what;
            } catch (const model::Error& e) { EXPECT_EQ(e.code().number, model::codes::kMapInvalid.number) << what; }
        }
    };
    Disk d = good;
    d.faces.clear();
    expect_refused("a mesh without faces", d);
    d = good;
    d.faces[4][1] = 99;
    expect_refused("an index out of range", d);
    d = good;
    d.positions[5].y = std::nan("");
    expect_refused("a NaN", d);
    d = good;
    d.positions.push_back({0, 0, 1});
    expect_refused("an unused vertex", d);
    d = good;
    d.faces.erase(d.faces.begin() + 8);  // the middle: a second border
    expect_refused("a ring", d);
    d = good;
    std::swap(d.faces[3][0], d.faces[3][1]);
    expect_refused("a turned face", d);
    d = good;
    std::reverse(d.border.begin(), d.border.end());
    expect_refused("a border the wrong way round", d);
    d = good;
    d.border.pop_back();
    d.border_uv.pop_back();
    expect_refused("a border with a gap", d);
    const Disk tetrahedron{
        {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, {}, {}};
    expect_refused("a closed surface", tetrahedron);
}

TEST(CgalParameterizers, FixedBorderNeedsPointsOnTheSquare) {
    Disk d = testing::grid(3, 3, [](double s, double t) { return Vec3d{s, t, 0}; });
    EXPECT_THROW(static_cast<void>(solve("mvc", d)), model::Error);
    testing::put_grid_border_on_square(d, 3, 3);
    d.border_uv[2].x = 1.5;
    EXPECT_THROW(static_cast<void>(solve("mvc", d)), model::Error);
}

TEST(CgalParameterizers, ReportProgressAndStopWhenAsked) {
    std::vector<Vec2d> unrolled;
    const Disk d = cylinder_patch(unrolled);
    int updates = 0;
    std::atomic<bool> stop{false};
    const model::Progress progress{.on_update =
                                       [&](std::string_view, double share) {
                                           EXPECT_GE(share, 0);
                                           EXPECT_LE(share, 1);
                                           if (++updates == 6) stop = true;
                                       },
                                   .cancelled = &stop};
    try {
        static_cast<void>(make_cgal_parameterizer("arap")->solve(d.view(), progress));
        FAIL() << "not interrupted";
    } catch (const model::Error& e) { EXPECT_EQ(e.code().number, model::codes::kInterrupted.number); }
    EXPECT_EQ(updates, 6);
}
}  // namespace
}  // namespace dgm::bake
