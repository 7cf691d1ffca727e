// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/layers/layer_tables_test.cpp
// Seam tables, diagonals, colours, and the set of layers as a whole.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "layer_bench.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

TEST(Tables, SeamPairsNameTheLowestSample) {
    const Bench b = baked(test::torus(3, 1, 30, 16), 17, 13, false);
    const std::vector<model::Layer> tables = make_tables(b.chart);
    ASSERT_EQ(tables.size(), 2u);
    EXPECT_EQ(tables[0].name, "seams");
    EXPECT_TRUE(tables[0].required);
    EXPECT_EQ(tables[1].name, "diagonals");
    const std::vector<std::uint32_t> pairs = read<std::uint32_t>(tables[0]);
    std::vector<std::uint32_t> copy_of(17 * 13, kNone);
    for (std::size_t k = 0; k < pairs.size(); k += 2) {
        EXPECT_LT(pairs[k], pairs[k + 1]);
        EXPECT_EQ(copy_of[pairs[k + 1]], kNone) << "a copy stands once";
        copy_of[pairs[k + 1]] = pairs[k];
        if (k > 0) { EXPECT_LT(std::pair(pairs[k - 2], pairs[k - 1]), std::pair(pairs[k], pairs[k + 1])); }
    }
    for (std::size_t k = 0; k < pairs.size(); k += 2)
        EXPECT_EQ(copy_of[pairs[k]], kNone) << "representatives are no copies";
    // Classes are what coincides: on an opened torus every border sample has a copy, no inner one does.
    for (std::uint32_t s = 0; s < 17 * 13; ++s) {
        bool alone = true;
        std::uint32_t lowest = s;
        for (std::uint32_t t = 0; t < 17 * 13; ++t)
            if (t != s && length(b.chart.positions[s] - b.chart.positions[t]) < 1e-9) {
                alone = false;
                lowest = std::min(lowest, t);
            }
        const std::uint32_t i = s / 13, j = s % 13;
        EXPECT_EQ(alone, i > 0 && j > 0 && i < 16 && j < 12);
        EXPECT_EQ(copy_of[s], lowest == s ? kNone : lowest);
    }
    const std::vector<std::uint8_t> diagonals = read<std::uint8_t>(tables[1]);
    EXPECT_EQ(diagonals.size(), 16u * 12u);
    EXPECT_LE(*std::max_element(diagonals.begin(), diagonals.end()), 1);
}

TEST(Tables, DiagonalsFollowTheSurface) {
    // A saddle of folds: each quad's middle lies on the line x = y or x = -y of its cell; the fold decides.
    for (const bool along : {true, false}) {
        const Bench b = patch(5, 5, [&](double x, double y) {
            const double fx = 4 * x - std::floor(4 * x), fy = 4 * y - std::floor(4 * y);
            return Vec3d{x, y,
                         fx == 0.5 && fy == 0.5                ? (along ? 0.5 : -0.5)
                         : std::lround(4 * x + 4 * y) % 2 == 0 ? 0.5
                                                               : -0.5};
        });
        // Corners alternate between +0.5 (i + j even) and -0.5; the middle is at the height of one kind.
        for (std::uint32_t i = 0; i < 4; ++i)
            for (std::uint32_t j = 0; j < 4; ++j) {
                const bool even = (i + j) % 2 == 0;  // (i, j) and (i+1, j+1) are high
                EXPECT_EQ(b.chart.diagonals[i * 4 + j], even == along ? 0 : 1);
            }
    }
}

TEST(TextureLayer, TwoColouredPicture) {
    const model::Rgba8 red{255, 0, 0, 255}, blue{0, 0, 255, 255}, green{0, 255, 0, 255};
    Bench b = patch(9, 9, [](double x, double y) { return Vec3d{x, y, 0}; });
    auto& mesh = b.chart.disk.own().mesh;
    EXPECT_FALSE(make_texture(b.input())) << "no colours, no layer";
    test::paint_positions(mesh);  // texture coordinates (x, y), v up
    mesh.face_materials.assign(mesh.faces.size(), 0);
    mesh.materials.resize(1);
    b.images.colour.resize(1);
    formats::Image image{64, 64, std::vector<model::Rgba8>(64 * 64, blue)};
    for (std::uint32_t y = 0; y < 64; ++y)
        for (std::uint32_t x = 0; x < 32; ++x) image.pixels[y * 64 + x] = y < 32 ? green : red;  // row 0 is the top
    b.images.colour[0] = image;
    const std::optional<model::Layer> layer = make_texture(b.input());
    ASSERT_TRUE(layer);
    ASSERT_EQ(layer->shape, (std::vector<std::uint64_t>{17, 17, 4}));
    const std::vector<std::uint8_t> rgba = read<std::uint8_t>(*layer);
    for (std::uint32_t i = 1; i < 16; ++i)  // u = x along rows; the outermost texels mix with the repeat
        for (std::uint32_t j = 1; j < 16; ++j) {
            if (i == 8 || (i < 8 && j == 8)) continue;
            const model::Rgba8 want = i > 8 ? blue : j > 8 ? green : red;
            const std::uint8_t* t = &rgba[4 * (i * 17 + j)];
            EXPECT_EQ((model::Rgba8{t[0], t[1], t[2], t[3]}), want) << i << ", " << j;
        }
}

TEST(TextureLayer, VertexColoursAreInterpolatedAndOpaque) {
    Bench b = patch(5, 5, [](double x, double y) { return Vec3d{x, y, 0}; });
    auto& mesh = b.chart.disk.own().mesh;
    for (const Face& f : mesh.faces)
        for (std::uint32_t v : f) {
            const Vec3d p = mesh.positions[v];
            mesh.corner_colours.push_back(
                {static_cast<std::uint8_t>(240 * p.x), static_cast<std::uint8_t>(240 * p.y), 77, 13});
        }
    const std::optional<model::Layer> layer = make_texture(b.input());
    ASSERT_TRUE(layer);
    ASSERT_EQ(layer->shape, (std::vector<std::uint64_t>{5, 5, 4}));
    const std::vector<std::uint8_t> rgba = read<std::uint8_t>(*layer);
    for (std::uint32_t i = 0; i < 5; ++i)
        for (std::uint32_t j = 0; j < 5; ++j) {
            EXPECT_EQ(rgba[4 * (i * 5 + j)], 60 * i);
            EXPECT_EQ(rgba[4 * (i * 5 + j) + 1], 60 * j);
            EXPECT_EQ(rgba[4 * (i * 5 + j) + 2], 77);
            EXPECT_EQ(rgba[4 * (i * 5 + j) + 3], 255);
        }
}

TEST(TextureLayer, MaterialColourAndFabric) {
    Bench b = patch(5, 5, [](double x, double y) { return Vec3d{x, y, 0}; });
    auto& mesh = b.chart.disk.own().mesh;
    mesh.materials.resize(2);
    mesh.materials[1].diffuse = {10, 20, 30, 255};
    b.images.colour.resize(2);
    mesh.face_materials.assign(mesh.faces.size(), 0);
    EXPECT_FALSE(make_texture(b.input())) << "a white material is no colour";
    mesh.face_materials.assign(mesh.faces.size(), 1);
    std::optional<model::Layer> layer = make_texture(b.input());
    ASSERT_TRUE(layer);
    EXPECT_EQ(read<std::uint8_t>(*layer)[0], 10);
    EXPECT_EQ(read<std::uint8_t>(*layer)[4 * 24 + 2], 30);
    b.images.fabric = formats::Image{1, 1, {{9, 8, 7, 6}}};
    LayerInput in = b.input();
    in.texture_size = std::pair(3u, 7u);
    layer = make_texture(in);
    ASSERT_TRUE(layer);
    ASSERT_EQ(layer->shape, (std::vector<std::uint64_t>{3, 7, 4}));
    for (std::size_t t = 0; t < 21; ++t) EXPECT_EQ(read<std::uint8_t>(*layer)[4 * t + 3], 6);
}

TEST(MakeLayers, NamesBoundsAndChoice) {
    const Bench b = baked(test::icosphere(3, 3), 17, 13, false);
    const ChartLayers all = make_layers(b.input(), {});
    std::vector<std::string> names;
    for (const model::Layer& layer : all.chart.layers) names.push_back(layer.name);
    EXPECT_EQ(names, (std::vector<std::string>{"geometry", "normal", "bump", "collision", "cover", "deformation",
                                               "contact", "seams", "diagonals"}));
    EXPECT_EQ(all.chart.rows, 17u);
    EXPECT_EQ(all.chart.cols, 13u);
    EXPECT_EQ(all.chart.method, "stretch");
    const std::vector<float> g = read<float>(*all.chart.find("geometry"));
    for (int k = 0; k < 3; ++k) {
        float lo = 1e9f, hi = -1e9f;
        for (std::size_t s = 0; s < 17 * 13; ++s) {
            lo = std::min(lo, g[3 * s + k]);
            hi = std::max(hi, g[3 * s + k]);
        }
        EXPECT_EQ(all.chart.bbox[k], lo);
        EXPECT_EQ(all.chart.bbox[k + 3], hi);
    }
    const std::vector<std::string> asked{"normal"};
    const ChartLayers some = make_layers(b.input(), asked);
    names.clear();
    for (const model::Layer& layer : some.chart.layers) names.push_back(layer.name);
    EXPECT_EQ(names, (std::vector<std::string>{"geometry", "normal", "seams", "diagonals"}));
    EXPECT_EQ(*some.chart.find("normal"), *all.chart.find("normal"));
}

}  // namespace
}  // namespace dgm::bake
