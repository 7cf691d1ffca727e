// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/parameterize/free_methods_test.cpp
// Free-border maps: against plane truth, against CGAL's own, and on disks that flip.
#include "geometry/parameterize/free_methods.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <string>

#include "disks.h"
#include "geometry/metrics/map_metrics.h"
#include "geometry/parameterize/flip_repair.h"
#include "geometry/parameterize/free_maps.h"
#include "geometry/parameterize/slim.h"
#include "reference/cgal_reference.h"

namespace dgm::bake {
namespace {
using testing::Disk;
const model::Progress kSilent;

std::vector<Vec2d> solve(std::string_view method, const Disk& d) {
    return make_free_parameterizer(method)->solve(d.view(), kSilent);
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
INSTANTIATE_TEST_SUITE_P(All, FreeMethods, ::testing::Values("lscm", "arap", "slim"));

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

TEST(FreeParameterizers, LscmReproducesAPlanarPatch) {
    const Disk d = flat_patch(9);
    std::vector<Vec2d> plane;
    for (const Vec3d& p : d.positions) plane.push_back({p.x, p.y});
    double scale = 0;
    EXPECT_LT(distance_up_to_similarity(solve("lscm", d), plane, &scale), 1e-10);
    EXPECT_NEAR(scale, 1, 1e-10);  // the surface's area
}

TEST(FreeParameterizers, ArapLowersTheRigidEnergyBelowLscm) {
    const Disk d = testing::grid(10, 10, [](double s, double t) {
        return Vec3d{s, t, 0.5 * std::exp(-12 * ((s - 0.5) * (s - 0.5) + (t - 0.5) * (t - 0.5)))};
    });
    const SlimOptions rigid{.energy = FlipFreeEnergy::kArap, .barrier = 1e-9};
    const double arap = flip_free_energy(d.view(), solve("arap", d), rigid);
    EXPECT_GT(arap, 0);
    EXPECT_LT(arap, 0.8 * flip_free_energy(d.view(), solve("lscm", d), rigid));
}

/// Bumps of many heights and uneven faces: no symmetry that could hide a wrong weight.
Disk bumpy(std::uint32_t n) {
    return testing::grid(n, n + 5, [](double s, double t) {
        return Vec3d{s + 0.1 * t * t, 0.8 * t - 0.1 * s * t,
                     0.2 * std::sin(7 * s) * std::cos(5 * t) + 0.3 * std::exp(-20 * ((s - 0.6) * (s - 0.6) + t * t))};
    });
}

TEST(FreeMaps, LscmIsCgalsUpToASimilarity) {
    for (const std::uint32_t n : {5U, 24U}) {
        const Disk d = bumpy(n);
        const auto cgal = cgal_default_lscm(d.view());
        ASSERT_TRUE(cgal);
        double scale = 0;
        EXPECT_LT(distance_up_to_similarity(lscm_map(d.view(), LscmWeight::kSquaredArea, kSilent), *cgal, &scale),
                  1e-9);
        EXPECT_NEAR(scale, 1, 1e-9);  // the same vertices pinned at the same places
    }
}

TEST(FreeMaps, LscmCountsFacesByTheirArea) {
    // The gradient of the conformal energy, by differences of the energy itself, is zero but for the two pins.
    const Disk d = bumpy(8);
    std::vector<Vec2d> uv = lscm_map(d.view(), LscmWeight::kArea, kSilent);
    const auto energy = [&] {
        double sum = 0;  // least squares conformal = Dirichlet energy - area of the map
        for (const Face& f : d.faces) {
            sum -= 0.5 * cross(uv[f[1]] - uv[f[0]], uv[f[2]] - uv[f[0]]);
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3d a = d.positions[f[(k + 1) % 3]] - d.positions[f[k]];
                const Vec3d b = d.positions[f[(k + 2) % 3]] - d.positions[f[k]];
                const Vec2d e = uv[f[(k + 2) % 3]] - uv[f[(k + 1) % 3]];
                sum += 0.25 * dot(a, b) / length(cross(a, b)) * dot(e, e);
            }
        }
        return sum;
    };
    int moved = 0;
    for (Vec2d& p : uv)
        for (double Vec2d::*c : {&Vec2d::x, &Vec2d::y}) {
            constexpr double kStep = 1e-4;
            const double at = p.*c;
            p.*c = at + kStep;
            const double above = energy();
            p.*c = at - kStep;
            const double below = energy();
            p.*c = at;
            if (std::abs(above - below) / (2 * kStep) > 1e-8) ++moved;
        }
    EXPECT_LE(moved, 4);
}

TEST(FreeMaps, ArapIsNotAboveCgals) {
    const Disk disks[] = {bumpy(20), testing::sphere_with_hole(24, 16, 0.6)};
    for (const Disk& d : disks) {
        const auto cgal = cgal_default_arap(d.view());
        ASSERT_TRUE(cgal);
        ArapReport report;
        const auto ours = arap_map(d.view(), harmonic_disk_map(d.view(), kSilent), {}, kSilent, &report);
        const double energy = arap_energy(d.view(), ours);
        EXPECT_NEAR(energy, report.energy, 1e-12);
        EXPECT_LE(energy, arap_energy(d.view(), *cgal) * (1 + 1e-6));
    }
}

TEST(FreeMaps, ArapEnergyIsThatOfItsSingularValues) {
    // One face stretched by 3 and 0.5, then turned over.
    const Disk d{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, {0, 1, 2}, {}};
    const double c = std::cos(0.7), s = std::sin(0.7);
    const auto map = [&](double a, double b) { return std::vector<Vec2d>{{0, 0}, {a * c, a * s}, {-b * s, b * c}}; };
    EXPECT_NEAR(arap_energy(d.view(), map(3, 0.5)), 4 + 0.25, 1e-12);
    EXPECT_NEAR(arap_energy(d.view(), map(3, -0.5)), 4 + 2.25, 1e-12);
}

TEST(FlipRepair, TurnsBackWhatWasPushedOver) {
    Disk d = testing::grid(30, 30, [](double s, double t) { return Vec3d{s, t, 0}; });
    std::vector<Vec2d> uv;
    for (const Vec3d& p : d.positions) uv.push_back({p.x, p.y});
    const std::vector<Vec2d> flat = uv;
    const auto at = [](std::uint32_t i, std::uint32_t j) { return i * 31 + j; };
    uv[at(9, 9)] = uv[at(9, 11)] + Vec2d{0.02, 0.013};    // inside
    uv[at(20, 20)] = uv[at(21, 21)] + Vec2d{0.01, 0.01};  // another group
    uv[at(0, 15)] = uv[at(0, 15)] + Vec2d{0, 0.07};       // on the border, pushed in
    ASSERT_GE(count_not_positive(d.faces, uv), 5U);
    for (const RepairShape shape : {RepairShape::kIsometric, RepairShape::kConformal}) {
        const auto repaired = repair_flips(d.view(), uv, shape, kSilent);
        ASSERT_TRUE(repaired);
        EXPECT_EQ(count_not_positive(d.faces, *repaired), 0U);
        std::size_t moved = 0;
        for (std::size_t v = 0; v < uv.size(); ++v) moved += (*repaired)[v] == uv[v] ? 0 : 1;
        EXPECT_LT(moved, uv.size() / 10);
        // The flat patch is the least of both energies.
        for (std::size_t v = 0; v < uv.size(); ++v) EXPECT_LT(length((*repaired)[v] - flat[v]), 0.02) << v;
    }
}

TEST(FlipRepair, GivesACollapsedMapRoomToSpread) {
    // Nearly closed: ARAP folds what lies far from the hole, and a few rings about the folds cannot hold their area.
    const Disk d = testing::sphere_with_hole(48, 32, 0.2);
    const std::vector<Vec2d> uv = arap_map(d.view(), harmonic_disk_map(d.view(), kSilent), {}, kSilent);
    const std::size_t flips = count_not_positive(d.faces, uv);
    ASSERT_GT(flips, d.faces.size() / 50);
    const auto repaired = repair_flips(d.view(), uv, RepairShape::kIsometric, kSilent);
    ASSERT_TRUE(repaired);
    EXPECT_EQ(count_not_positive(d.faces, *repaired), 0U);
    EXPECT_LT(arap_energy(d.view(), *repaired), 1.5 * arap_energy(d.view(), uv));
    std::size_t held = 0;
    for (std::size_t v = 0; v < uv.size(); ++v) held += (*repaired)[v] == uv[v] ? 1 : 0;
    EXPECT_GT(held, uv.size() / 2);
}

TEST(FlipRepair, GivesUpWhereTooMuchIsFolded) {
    Disk d = testing::grid(10, 10, [](double s, double t) { return Vec3d{s, t, 0}; });
    std::vector<Vec2d> uv;
    for (const Vec3d& p : d.positions) uv.push_back({std::abs(p.x - 0.5), p.y});
    EXPECT_FALSE(repair_flips(d.view(), uv, RepairShape::kIsometric, kSilent));
}

/// Large disks descend on a coarse level: to where Newton steps on all of their faces lead, and so for every method
/// whose direct map has flips there.
TEST(FreeParameterizers, LargeDisksDescendAsFarAsStepByStep) {
    const Disk d = testing::long_finger(24, 150);
    ASSERT_GT(d.faces.size(), 7000U);
    SlimOptions steps;
    steps.iterations = 100;
    const auto start = flip_free_start(d.view(), kSilent);
    ASSERT_TRUE(start);
    SlimReport whole;
    (void)descend_flip_free(d.view(), *start, steps, kSilent, &whole);
    for (const char* method : {"slim", "lscm", "arap"}) {
        const std::vector<Vec2d> uv = solve(method, d);
        EXPECT_EQ(count_not_positive(d.faces, uv), 0U) << method;
        if (method == std::string_view("slim")) {
            EXPECT_LT(flip_free_energy(d.view(), uv, steps), 1.01 * whole.energy);
        }
    }
}

TEST(FreeParameterizers, NamesAndBorders) {
    for (const char* name : {"lscm", "arap", "slim"}) {
        const auto p = make_free_parameterizer(name);
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(p->name(), name);
        EXPECT_FALSE(p->fixed_border());
    }
    EXPECT_EQ(make_free_parameterizer("mvc"), nullptr);
}

TEST(FreeParameterizers, SmallestDisk) {
    const Disk d{{{0, 0, 0}, {0.8, 0, 0}, {0, 0.6, 0}}, {{0, 1, 2}}, {0, 1, 2}, {}};
    const std::vector<Vec2d> plane{{0, 0}, {0.8, 0}, {0, 0.6}};
    for (const char* method : {"lscm", "arap", "slim"})
        EXPECT_LT(distance_up_to_similarity(solve(method, d), plane), 1e-6) << method;
}

TEST(FreeParameterizers, RefuseWhatIsNoDisk) {
    const Disk good = testing::grid(3, 3, [](double s, double t) { return Vec3d{s, t, 0}; });
    for (const auto& [what, disk] : testing::no_disks(good))
        for (const char* method : {"lscm", "arap", "slim"})
            testing::expect_no_map(what, [&] { return solve(method, disk); });
}

TEST(FreeParameterizers, ReportProgressAndStopWhenAsked) {
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
        static_cast<void>(make_free_parameterizer("arap")->solve(d.view(), progress));
        FAIL() << "not interrupted";
    } catch (const model::Error& e) { EXPECT_EQ(e.code().number, model::codes::kInterrupted.number); }
    EXPECT_EQ(updates, 6);
}
}  // namespace
}  // namespace dgm::bake
