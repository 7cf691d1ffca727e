// SPDX-License-Identifier: GPL-3.0-or-later
#include "report/viewer_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>

#include "charts.h"
#include "report/draw_mesh.h"

namespace dgm::report {
namespace {
using nlohmann::json;

template <class T>
std::vector<T> decoded(const std::string& text) {
    constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    std::uint32_t bits = 0;
    int count = 0;
    for (const char c : text) {
        if (c == '=') break;
        bits = bits << 6 | static_cast<std::uint32_t>(kDigits.find(c));
        if ((count += 6) >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 255);
    }
    std::vector<T> out(bytes.size() / sizeof(T));
    std::memcpy(out.data(), bytes.data(), out.size() * sizeof(T));
    return out;
}

std::vector<model::Vec3d> points_of(const json& data, const json& mesh) {
    const std::vector<std::uint16_t> stored = decoded<std::uint16_t>(mesh["position"]);
    std::vector<model::Vec3d> out;
    for (std::size_t v = 0; v < stored.size(); v += 3) {
        model::Vec3d p;
        for (int k = 0; k < 3; ++k)
            p[k] = data["low"][static_cast<std::size_t>(k)].get<double>() +
                   data["step"].get<double>() * stored[v + static_cast<std::size_t>(k)];
        out.push_back(p);
    }
    return out;
}

struct Scene {
    model::Chart chart;
    bake::Reconstruction surface;
    SurfaceValues values;
    std::vector<double> source_values;

    explicit Scene(std::uint32_t side) : chart(hill(side, side)), surface(bake::reconstruct(chart)) {
        const bake::ClosestPointIndex index(surface.mesh.positions, surface.mesh.faces);
        values = surface_values(chart, surface, index);
        source_values.assign(surface.mesh.positions.size(), 0);
    }
    [[nodiscard]] json data(std::size_t most) const {
        return viewer_data({surface.mesh, source_values}, {{&chart, 1}, {&surface, 1}, {&values, 1}},
                           scales_of({&values, 1}, source_values), 1.5, {30, 20}, most);
    }
};

TEST(ViewerData, PointsAreTheChartsWithinHalfAStep) {
    const Scene scene(33);
    const json data = scene.data(5000);
    EXPECT_EQ(data["stride"], 1);
    const std::vector<model::Vec3d> points = points_of(data, data["map"]);
    ASSERT_EQ(points.size(), 33U * 33);
    const double step = data["step"];
    EXPECT_LT(step, 1.0 / 65000);
    const std::vector<std::uint16_t> index = decoded<std::uint16_t>(data["map"]["index"]);
    ASSERT_EQ(index.size(), 3 * scene.surface.mesh.faces.size());
    for (std::size_t c = 0; c < index.size(); ++c) {
        const model::Vec3d& want = scene.surface.mesh.positions[scene.surface.mesh.faces[c / 3][c % 3]];
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(points[index[c]][k], want[k], 0.501 * step);
    }
}

TEST(ViewerData, ThinnedPointsAreTheChartsToo) {
    const Scene scene(129);
    const json data = scene.data(3000);
    EXPECT_EQ(data["stride"], 4);  // stride 2 has more than 64 * 64 = 4096
    const std::vector<model::Vec3d> points = points_of(data, data["map"]);
    EXPECT_LE(points.size(), 3000U);
    const double step = data["step"];
    for (const model::Vec3d& p : points) {
        const auto i = std::lround(p.x * 128), j = std::lround(p.y * 128);
        const model::Vec3d& want = scene.surface.mesh.positions[static_cast<std::size_t>(i * 129 + j)];
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(p[k], want[k], 0.501 * step);
    }
    EXPECT_LE(points_of(data, data["source"]).size(), 3000U);
    EXPECT_TRUE(data["source"]["simplified"].get<bool>());
    // A plain sheet: four borders, no seam.
    EXPECT_EQ(decoded<std::uint16_t>(data["map"]["borders"]).size(), 2U * 4 * 128);
    EXPECT_TRUE(decoded<std::uint16_t>(data["map"]["seams"]).empty());
}

TEST(ViewerData, NoBadSpotIsThinnedAway) {
    Scene scene(129);
    scene.values.distance.assign(129 * 129, 0.0);
    scene.values.distance[50 * 129 + 51] = -7;  // on no row and no column that is kept
    Scales scales;
    scales.distance = scales.worst = 7;
    const json data = viewer_data({scene.surface.mesh, scene.source_values},
                                  {{&scene.chart, 1}, {&scene.surface, 1}, {&scene.values, 1}}, scales, 1.5, {}, 3000);
    const std::vector<std::uint8_t> places = decoded<std::uint8_t>(data["map"]["distance"]);
    EXPECT_EQ(*std::min_element(places.begin(), places.end()), 0);
}

TEST(ViewerData, ChartsThatDoNotFitAreCounted) {
    const Scene scene(33);
    EXPECT_EQ(scene.data(20)["charts"], 0);
    EXPECT_FALSE(scene.data(20).contains("map"));
    EXPECT_EQ(scene.data(5000)["charts"], 1);
}

TEST(DrawMesh, ThinSheetsKeepBothSides) {
    // Two sheets closer than any lattice cell, one up, one down.
    const bake::Reconstruction sheet = bake::reconstruct(hill(65, 65));
    model::TriMesh mesh = sheet.mesh;
    mesh.corner_uvs.clear();
    for (const model::Vec3d& p : sheet.mesh.positions) mesh.positions.push_back(p - model::Vec3d{0, 0, 1e-6});
    for (const model::Face& f : sheet.mesh.faces) mesh.faces.push_back({f[0] + 4225, f[2] + 4225, f[1] + 4225});
    const DrawMesh drawn = draw_mesh(mesh, 1500);
    EXPECT_TRUE(drawn.simplified);
    EXPECT_LE(drawn.positions.size(), 1500U);
    EXPECT_GT(drawn.positions.size(), 400U);
    const auto up = std::count_if(drawn.normals.begin(), drawn.normals.end(), [](const auto& n) { return n.z > 0.3; });
    const auto down =
        std::count_if(drawn.normals.begin(), drawn.normals.end(), [](const auto& n) { return n.z < -0.3; });
    EXPECT_EQ(static_cast<std::size_t>(up + down), drawn.normals.size());
    EXPECT_GT(down, 200);
}

TEST(DrawMesh, BrokenFacesAreLeftOut) {
    model::TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, NAN, 0}};
    mesh.faces = {{0, 1, 2}, {0, 1, 3}};
    EXPECT_EQ(draw_mesh(mesh, 100).faces.size(), 1U);
}

}  // namespace
}  // namespace dgm::report
