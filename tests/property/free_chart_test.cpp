// SPDX-License-Identifier: GPL-3.0-or-later
// tests/property/free_chart_test.cpp
// Laws of a free chart of any surface: one to one, a watertight strip, and slits that stay slits.
#include "geometry/chart/free_chart.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "geometry/cgal/border_simple.h"
#include "geometry/cgal/constrained_triangulation.h"
#include "geometry/cut/cut_graph.h"
#include "geometry/fit/remap.h"
#include "geometry/layers/layers.h"
#include "geometry/parameterize/free_methods.h"
#include "geometry/repair/repair.h"
#include "model/codes.h"
#include "support/chart_checks.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

const FreeChartTools kTools{border_is_simple, constrained_triangulation};

SampledChart chart_of(const TriMesh& mesh, std::uint32_t m, std::uint32_t n, const char* method) {
    CutGraph cut(mesh);
    cut.cut_to_disk();
    return make_free_chart(cut.open(), m, n, *make_free_parameterizer(method), kTools, {});
}

/// A bowl: the ball's upper part, open at the rim.
TriMesh bowl() {
    TriMesh mesh = test::icosphere(3);
    std::vector<Face> kept;
    for (const Face& f : mesh.faces)
        if (mesh.positions[f[0]].z + mesh.positions[f[1]].z + mesh.positions[f[2]].z > 0.3) kept.push_back(f);
    mesh.faces = kept;
    return mesh;
}

struct Named {
    const char* name;
    TriMesh mesh;
};
void PrintTo(const Named& named, std::ostream* out) {
    *out << named.name;
}

std::vector<Named> surfaces() {
    TriMesh bent = test::grid_sheet(16, 12, 2, 1);
    for (Vec3d& p : bent.positions) p.z = 0.2 * std::sin(3 * p.x) * std::cos(2 * p.y);
    return {{"sheet", test::grid_sheet(8, 6, 2, 1)},
            {"bent_sheet", bent},
            {"bowl", bowl()},
            {"round_disk", test::polygon_disk(30)},
            {"triangle", test::polygon_disk(3)},
            {"finger", test::finger(0.3, 1, 16, 12, 6)},
            {"annulus", test::annulus(1, 2, 40, 8)},
            {"torus", test::torus(1, 0.4, 32, 16)},
            {"ball", test::icosphere(3)},
            {"slit", test::slit_sheet(10, 0.001)}};
}

class FreeChart : public testing::TestWithParam<Named> {};

/// Nearly all error in one half of the map.
ErrorField error_to_one_side(const SampledChart& chart) {
    ErrorField out;
    for (const Face& f : chart.disk->mesh.faces) {
        const Vec2d middle = (chart.uv[f[0]] + chart.uv[f[1]] + chart.uv[f[2]]) * (1.0 / 3);
        out.of_faces.push_back(middle.x < 0.5 ? 1.9 : 0.1);
    }
    return out;
}

TEST_P(FreeChart, IsOneToOneAndWatertight) {
    const TriMesh mesh = repair(GetParam().mesh).components.at(0);
    for (const char* method : {"arap", "lscm"})
        for (const auto& [m, n] : {std::pair{33u, 33u}, {65u, 40u}}) {
            SCOPED_TRACE(std::string(method) + " " + std::to_string(m) + "x" + std::to_string(n));
            const SampledChart chart = chart_of(mesh, m, n, method);
            EXPECT_EQ(chart.domain, layout::Domain::kFree);
            ASSERT_EQ(chart.mask.size(), std::size_t{m} * n);
            ASSERT_EQ(chart.samples.size(), std::size_t{m} * n + chart.border_uv.size());
            EXPECT_FALSE(chart.strip.empty());
            ASSERT_NO_FATAL_FAILURE(test::expect_bijective(chart));
            ASSERT_NO_FATAL_FAILURE(test::expect_classes(chart));
            ASSERT_NO_FATAL_FAILURE(test::expect_topology(chart, mesh));
            // In the plane: quads and strip do not overlap, and fill what the border encloses, in the square.
            std::vector<Vec2d> place;
            for (std::uint32_t s = 0; s < m * n; ++s) place.push_back({s / n / (m - 1.0), s % n / (n - 1.0)});
            place.insert(place.end(), chart.border_uv.begin(), chart.border_uv.end());
            double filled = 0, enclosed = 0;
            for (const Face& f : chart.faces()) {
                const double area = cross(place[f[1]] - place[f[0]], place[f[2]] - place[f[0]]);
                ASSERT_GT(area, 0);
                filled += area;
            }
            const std::size_t count = chart.border_uv.size();
            for (std::size_t b = 0; b < count; ++b) {
                const Vec2d p = chart.border_uv[b], q = chart.border_uv[(b + 1) % count];
                EXPECT_TRUE(p.x >= 0 && p.x <= 1 && p.y >= 0 && p.y <= 1);
                EXPECT_LE(std::hypot((q.x - p.x) * (m - 1), (q.y - p.y) * (n - 1)), 1 + 1e-6) << "one cell at most";
                enclosed += cross(p, q);
            }
            EXPECT_NEAR(filled, enclosed, 1e-9);
            EXPECT_GT(enclosed, 0.5) << "twice the area: a chart in its smallest rectangle fills a fair share";
        }
}

TEST_P(FreeChart, MappedAnewItKeepsItsBorderAndStrip) {
    const TriMesh mesh = repair(GetParam().mesh).components.at(0);
    const SampledChart before = chart_of(mesh, 33, 33, "arap");
    Remap maps(before, std::nullopt);
    const std::optional<SampledChart> after = maps.propose(error_to_one_side(before), RemapShape::kOwn, {});
    ASSERT_TRUE(after);
    ASSERT_NO_FATAL_FAILURE(test::expect_bijective(*after));
    ASSERT_NO_FATAL_FAILURE(test::expect_classes(*after));
    ASSERT_NO_FATAL_FAILURE(test::expect_topology(*after, mesh));
    EXPECT_EQ(after->strip, before.strip);
    EXPECT_EQ(after->mask, before.mask);
    for (std::size_t s = before.grid_count(); s < before.positions.size(); ++s)
        ASSERT_EQ(after->positions[s], before.positions[s]) << s;
}

INSTANTIATE_TEST_SUITE_P(Surfaces, FreeChart, testing::ValuesIn(surfaces()),
                         [](const auto& at) { return at.param.name; });

/// A slit much thinner than a cell: no quad and no strip triangle may bridge it.
TEST(FreeChartSlit, ASlitStaysASlit) {
    const TriMesh source = test::slit_sheet(12, 2e-4);
    const RepairedMesh repaired = repair(source);
    const TriMesh& mesh = repaired.components.at(0);
    const double area = test::surface_area(mesh);
    for (std::uint32_t side : {17u, 24u, 33u, 64u}) {
        SCOPED_TRACE(side);
        const SampledChart chart = chart_of(mesh, side, side, "arap");
        ASSERT_NO_FATAL_FAILURE(test::expect_topology(chart, mesh));
        const std::vector<Face> faces = chart.faces();
        EXPECT_NEAR(test::surface_area(chart.positions, faces), area, 1e-6);
        for (const Face& f :
             faces) {  // back in source coordinates: nothing crosses the slit's axis well left of its tip
            double lo = 9, hi = -9, right = -9;
            for (std::uint32_t s : f) {
                const Vec3d p = repaired.frame.centre + chart.positions[s] * repaired.frame.diagonal;
                lo = std::min(lo, p.y - 0.5);
                hi = std::max(hi, p.y - 0.5);
                right = std::max(right, p.x);
            }
            if (right < 0.45) { EXPECT_FALSE(lo < -1e-9 && hi > 1e-9); }
        }
    }
}

/// A spiral ramp of one turn and a half: unrolled without distortion it lies over itself.
TEST(FreeChart, IsLaidOutBesideItselfWhereItWouldOverlap) {
    TriMesh ramp = test::grid_sheet(90, 10);
    for (Vec3d& p : ramp.positions) {
        const double angle = 3 * M_PI * p.x, radius = 0.4 + 0.6 * p.y;
        p = {radius * std::cos(angle), radius * std::sin(angle), 0.5 * p.x};
    }
    const TriMesh mesh = repair(ramp).components.at(0);
    for (const char* method : {"arap", "slim"}) {
        const SampledChart chart = make_free_chart(mesh, 65, 65, *make_free_parameterizer(method), kTools, {});
        // ARAP's local steps find a way around the overlap here.
        EXPECT_EQ(chart.note.find("without overlap") != std::string::npos, method == std::string("slim")) << chart.note;
        ASSERT_NO_FATAL_FAILURE(test::expect_bijective(chart));
        ASSERT_NO_FATAL_FAILURE(test::expect_topology(chart, mesh));
        // On the circle, where it starts from, the stretch is above 2.
        EXPECT_LT(measure_map(chart.disk->mesh.positions, chart.disk->mesh.faces, chart.uv).stretch_l2, 1.5) << method;
    }
}

TEST(FreeChartError, FallsWhenTheGridIsDoubled) {
    TriMesh bent = test::grid_sheet(96, 96);
    for (Vec3d& p : bent.positions) p.z = 0.2 * std::sin(3 * p.x) * std::cos(2 * p.y);
    const TriMesh mesh = repair(bent).components.at(0);
    double last = 0;
    for (std::uint32_t side : {13u, 25u, 49u}) {
        const double psnr = quick_error(mesh, chart_of(mesh, side, side, "arap"), 20'000).psnr();
        if (last > 0) { EXPECT_GE(psnr, last + 8.5) << side; }
        last = psnr;
    }
}

TEST(UvChart, UsesTheMeshsOwnCoordinatesAndItsSeam) {
    // An unrolled tube whose seam stands in the texture coordinates alone.
    const std::uint32_t around = 24, along = 8;
    TriMesh tube = test::finger(0.3, 1, around, along, 0);
    tube.positions.pop_back();
    tube.faces.resize(tube.faces.size() - around);
    for (const Face& f : tube.faces) {
        double turns[3];
        for (int k = 0; k < 3; ++k) {
            turns[k] = f[k] % around / static_cast<double>(around);
            tube.corner_uvs.push_back({turns[k], static_cast<double>(f[k] / around) / along});
        }
        for (int k = 0; k < 3; ++k)  // faces that close the ring end at 1, not at 0
            if (std::max({turns[0], turns[1], turns[2]}) > 0.9 && turns[k] == 0)
                tube.corner_uvs[tube.corner_uvs.size() - 3 + k].x = 1;
    }
    const RepairedMesh repaired = repair(tube);
    const TriMesh& mesh = repaired.components.at(0);
    const SampledChart chart = make_uv_chart(mesh, 33, 21, kTools, {});
    EXPECT_EQ(chart.method, "uv");
    ASSERT_NO_FATAL_FAILURE(test::expect_bijective(chart));
    ASSERT_NO_FATAL_FAILURE(test::expect_classes(chart));
    ASSERT_NO_FATAL_FAILURE(test::expect_topology(chart, mesh));
    // Without texture coordinates, or with those of two charts, it is refused.
    const auto code = [](const TriMesh& bad) {
        try {
            (void)make_uv_chart(bad, 17, 17, kTools, {});
        } catch (const model::Error& e) { return e.code().number; }
        return 0;
    };
    TriMesh bare = mesh;
    bare.corner_uvs.clear();
    EXPECT_EQ(code(bare), model::codes::kMethodUnsuited.number);
    TriMesh torn = mesh;
    for (std::size_t f = 0; f < torn.faces.size() / 2; ++f)
        for (int k = 0; k < 3; ++k) torn.corner_uvs[3 * f + k].y += 5;
    EXPECT_EQ(code(torn), model::codes::kMethodUnsuited.number);
    TriMesh ring = mesh;  // the ring closed in the plane: two borders
    for (std::size_t f = 0; f < ring.faces.size(); ++f)
        for (int k = 0; k < 3; ++k) {
            const Vec3d p = ring.positions[ring.faces[f][k]];
            ring.corner_uvs[3 * f + k] = Vec2d{p.x, p.y} * (1 + p.z);
        }
    EXPECT_EQ(code(ring), model::codes::kMethodUnsuited.number);
}

/// Layers of a free chart: areas add up, boxes and cover radii know the strip.
TEST(FreeChartLayers, KnowTheStrip) {
    const RepairedMesh repaired = repair(bowl());
    const SampledChart chart = chart_of(repaired.components.at(0), 25, 30, "arap");
    const StoredFrame stored = choose_frame(repaired.frame, chart, false);
    const SampleGrid fine = rasterize(chart.disk->mesh.faces, chart.uv, 49, 59);
    const MaterialImages images;
    ChartLayers out = make_layers({chart, repaired.frame, stored, images, fine, std::nullopt}, {});
    const auto layer = [&](const char* name) -> model::Layer& {
        model::Layer* found = out.chart.find(name);
        if (found == nullptr) throw std::runtime_error(name);
        return *found;
    };
    const std::size_t extra = chart.border_uv.size(), grid = 25 * 30;
    EXPECT_EQ(layer("mask").shape, (std::vector<std::uint64_t>{25, 30}));
    EXPECT_EQ(layer("border_uv").shape, (std::vector<std::uint64_t>{extra, 2}));
    EXPECT_EQ(layer("border_geometry").shape, (std::vector<std::uint64_t>{extra, 3}));
    EXPECT_EQ(layer("border_normal").shape, (std::vector<std::uint64_t>{extra, 2}));
    EXPECT_EQ(layer("border_faces").shape, (std::vector<std::uint64_t>{chart.strip.size(), 3}));
    for (const char* name : {"geometry", "mask", "border_uv", "border_geometry", "border_faces"})
        EXPECT_TRUE(layer(name).required);
    std::vector<Vec3d> local;
    for (const char* name : {"geometry", "border_geometry"}) {
        const auto v = values<float>(layer(name));
        for (std::size_t s = 0; s < v.size(); s += 3) local.push_back({v[s], v[s + 1], v[s + 2]});
    }
    const std::vector<Face> faces = chart.faces();
    double sum = 0;
    for (std::size_t s = 0; s < grid; ++s) {
        const float area = values<float>(layer("contact"))[2 * s];
        EXPECT_TRUE(area == 0 || chart.mask[s]) << "area off the surface";
        sum += area;
    }
    EXPECT_NEAR(sum, test::surface_area(local, faces), 1e-5);
    const auto boxes = values<float>(layer("collision"));
    const auto radius = values<float>(layer("cover"));
    const std::size_t root = boxes.size() - 6;
    for (const Face& f : faces) {
        for (std::uint32_t s : f) {
            for (int k = 0; k < 3; ++k) {
                EXPECT_GE(local[s][k], boxes[root + k]);
                EXPECT_LE(local[s][k], boxes[root + 3 + k]);
            }
            if (s >= grid) continue;
            for (std::uint32_t to : f) EXPECT_LE(length(local[s] - local[to]), radius[s]);
        }
        // Some leaf box holds the whole triangle.
        const auto levels = std::get<std::vector<std::uint32_t>>(layer("collision").attributes.at("levels"));
        bool held = false;
        for (std::size_t box = 0; box < std::size_t{levels[0]} * levels[1] && !held; ++box) {
            held = true;
            for (std::uint32_t s : f)
                for (int k = 0; k < 3; ++k)
                    held &= local[s][k] >= boxes[6 * box + k] && local[s][k] <= boxes[6 * box + 3 + k];
        }
        EXPECT_TRUE(held);
    }
}

}  // namespace
}  // namespace dgm::bake
