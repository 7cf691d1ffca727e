// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/pick_test.cpp
// Rays against planes and spheres by formula, at edges and corners, and with hard numbers; the C interface.
#include <gtest/gtest.h>

#include <dgm/dgm.h>

#include "pick_rays.h"

namespace dgm::test {
namespace {

// --- Expected values by formula ---------------------------------------------------------------------------------

TEST(Pick, FlatSheetByHand) {
    State state = make_state(grid_chart(20, 30, flat));
    // Quad (3, 7), diagonal 0 from (3, 7) to (4, 8): (3.75, 7.25) lies on the side of (4, 7), triangle 0.
    const auto hit = pick_ray(state, {3.75f, 7.25f, 5}, {0, 0, -0.25f}).value();
    EXPECT_EQ(hit.row, 3u);
    EXPECT_EQ(hit.column, 7u);
    EXPECT_EQ(hit.triangle, 0u);
    EXPECT_EQ(hit.corners[0], 3u * 30 + 7);
    EXPECT_EQ(hit.corners[1], 4u * 30 + 7);
    EXPECT_EQ(hit.corners[2], 4u * 30 + 8);
    EXPECT_FLOAT_EQ(hit.barycentric[0], 0.25f);  // 3.75 = 4 - 0.25, 7.25 = 7 + 0.25
    EXPECT_FLOAT_EQ(hit.barycentric[1], 0.5f);
    EXPECT_FLOAT_EQ(hit.barycentric[2], 0.25f);
    EXPECT_EQ(hit.sample, 4u * 30 + 7);
    EXPECT_EQ(hit.distance, 5);  // not 20 lengths of the direction
    EXPECT_EQ(hit.point, (Vec3{3.75f, 7.25f, 0}));
    EXPECT_EQ(hit.normal, (Vec3{0, 0, 1}));  // u along x, v along y
    EXPECT_TRUE(hit.front);
    // From below it is seen from behind; the other triangle of the quad.
    const auto back = pick_ray(state, {3.25f, 7.5f, -2}, {0, 0, 1e-20f}).value();
    EXPECT_EQ(back.triangle, 1u);
    EXPECT_EQ(back.distance, 2);
    EXPECT_FALSE(back.front);
    EXPECT_EQ(back.normal, (Vec3{0, 0, 1}));
    PickOptions front_only;
    front_only.back_faces = false;
    EXPECT_EQ(pick_ray(state, {3.25f, 7.5f, -2}, {0, 0, 1}, front_only).error().code, ErrorCode::NotFound);
    EXPECT_TRUE(pick_ray(state, {3.25f, 7.5f, 2}, {0, 0, -1}, front_only).ok());
}

TEST(Pick, DistanceAndItsLimit) {
    State state = make_state(grid_chart(20, 30, flat));
    // 3-4-5: 12 along, 9 down is 15.
    PickOptions options;
    options.max_distance = 15;
    EXPECT_EQ(pick_ray(state, {2, 7.5f, 9}, {4, 0, -3}, options).value().distance, 15);
    options.max_distance = std::nextafter(15.0f, 0.0f);
    EXPECT_EQ(pick_ray(state, {2, 7.5f, 9}, {4, 0, -3}, options).error().code, ErrorCode::NotFound);
    // On the surface: distance 0, whichever way.
    options.max_distance = 0;
    for (const Vec3 d : {Vec3{0, 0, 1}, Vec3{0, 0, -1}, Vec3{1, 2, -0.5f}})
        EXPECT_EQ(pick_ray(state, {3.5f, 7.25f, 0}, d, options).value().distance, 0);
    EXPECT_FALSE(pick_ray(state, {3.5f, 7.25f, 1}, {0, 0, 1}).ok());  // behind the origin
    EXPECT_FALSE(pick_ray(state, {3.5f, 30, 1}, {0, 0, -1}).ok());    // beside the sheet
    EXPECT_FALSE(pick_ray(state, {-5, 7.25f, 0}, {1, 0, 0}).ok());    // in its plane
    EXPECT_FALSE(pick_ray(state, {-5, 7.25f, 1e-6f}, {1, 0, 0}).ok());
}

TEST(Pick, SphereByFormula) {
    constexpr std::uint32_t kSide = 65;
    State state = make_state(sphere_chart(kSide));
    // A chord's sagitta: edges here are at most 2.2 * pi / 64 long.
    const double sag = 0.11 * 0.11 / 2;
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    int hits = 0, misses = 0;
    for (int k = 0; k < 5000; ++k) {
        const double o[3] = {2 * normal(random), 2 * normal(random), 2 * normal(random)};
        // Towards the sphere, more or less.
        const double d[3] = {normal(random) - o[0], normal(random) - o[1], normal(random) - o[2]};
        double oo = 0, od = 0, dd = 0;
        for (int a = 0; a < 3; ++a) {
            oo += o[a] * o[a];
            od += o[a] * d[a];
            dd += d[a] * d[a];
        }
        const double root = od * od - dd * (oo - 1), away = oo - od * od / dd;  // squared distance of the line
        if (std::fabs(std::sqrt(oo) - 1) < 2 * sag || std::fabs(std::sqrt(away) - 1) < 0.05) continue;
        const bool inside = oo < 1;
        const auto hit =
            pick_ray(state, {float(o[0]), float(o[1]), float(o[2])}, {float(d[0]), float(d[1]), float(d[2])});
        const bool expected = inside || (away < 1 && od < 0);
        ASSERT_EQ(hit.ok(), expected) << k;
        if (!expected) {
            ++misses;
            continue;
        }
        ++hits;
        const double t = (-od + (inside ? 1 : -1) * std::sqrt(root)) / dd;
        const double cosine = std::sqrt(1 - away);
        ASSERT_NEAR(hit.value().distance, t * std::sqrt(dd), sag / cosine + 1e-5) << k;
        ASSERT_NE(hit.value().front, inside);
        for (int a = 0; a < 3; ++a) {
            const double p = o[a] + t * d[a];
            ASSERT_NEAR((&hit.value().point.x)[a], p, 2 * sag / cosine + 1e-5);
            ASSERT_NEAR((&hit.value().normal.x)[a], p, 0.12);
        }
    }
    EXPECT_GT(hits, 1000);
    EXPECT_GT(misses, 1000);
}

// --- Nothing slips through --------------------------------------------------------------------------------------

/// A ray from inside a closed surface leaves it, wherever it is aimed: at corners, seams, edges, to the bit.
void expect_closed(State& state, Vec3 inside, float shift, bool from_behind = true) {
    const PointView p = state.positions();
    const Triangles mesh(state);
    for (std::size_t k = 0; k < mesh.indices.size(); k += 3)
        for (std::size_t c = 0; c < 3; ++c) {
            const Vec3 a = p[mesh.indices[k + c]], b = p[mesh.indices[k + (c + 1) % 3]];
            for (const float w : {0.0f, 0.5f, 0.25f, shift}) {
                const Vec3 at = w == 0 ? a : (1 - w) * a + w * b;
                const auto hit = pick_ray(state, inside, at - inside);
                ASSERT_TRUE(hit.ok()) << k << " " << c << " " << double{w};
                ASSERT_TRUE(!from_behind || !hit.value().front);
            }
        }
}

TEST(Pick, NoRayLeavesAClosedSurface) {
    for (const std::uint32_t side : {9u, 17u, 33u}) {
        State state = make_state(mixed(sphere_chart(side), side));
        expect_closed(state, {0, 0, 0}, 0.3f);
        expect_closed(state, {0.31f, -0.24f, 0.17f}, 0.7f);
    }
    // Long thin triangles far from the origin, where coordinates have few digits left: rounding folds the surface.
    State far = make_state(closed_chart(17, [](std::array<double, 3> n) {
        return std::array<double, 3>{1e4 + n[0], 3e3 + 1e-3 * n[1], 50 * n[2]};
    }));
    expect_closed(far, {1e4f, 3e3f, 0}, 0.1f, false);
}

TEST(Pick, GrazingRaysAndEdgesAlongTheAxes) {
    // On a flat grid of whole numbers, rays straight down at half steps run through corners, sides and diagonals.
    State state = make_state(mixed(grid_chart(17, 17, flat), 2));
    for (int i = 0; i <= 64; ++i)
        for (int j = 0; j <= 64; ++j) {
            const Vec3 at{static_cast<float>(i) / 4, static_cast<float>(j) / 4, 0};
            for (const Vec3 d : {Vec3{0, 0, -1}, Vec3{1, 2, -4}, Vec3{-3, 1, -1}}) {
                const auto hit = pick_ray(state, at - 2 * d, d);
                ASSERT_TRUE(hit.ok()) << i << " " << j;
                ASSERT_EQ(hit.value().point, at);
                ASSERT_NEAR(hit.value().distance, 2 * length(d), 1e-6);
                ASSERT_TRUE(hit.value().front);
            }
        }
    // Almost in the plane: down by one part in ten million of the way.
    const auto grazing = pick_ray(state, {-100, 8.25f, 1e-5f}, {108.5f, 0, -1e-5f});
    ASSERT_TRUE(grazing.ok());
    EXPECT_NEAR(grazing.value().point.x, 8.5, 1e-4);
    EXPECT_NEAR(grazing.value().distance, 108.5, 1e-4);
}

TEST(Pick, SeamSampleIsTheRepresentative) {
    State state = make_state(grid_chart(43, 41, folds, tube_seams(43, 41)));
    for (std::uint32_t i = 1; i < 42; ++i) {
        const Vec3 p = state.positions()[i * 41 + 40], n = state.normal(i * 41 + 40);
        const auto hit = pick_ray(state, p + 0.05f * n, Vec3{} - n);
        ASSERT_TRUE(hit.ok());
        ASSERT_NEAR(hit.value().distance, 0.05, 1e-5);
        ASSERT_EQ(hit.value().sample, i * 41);
    }
}

TEST(Pick, BorderStrip) {
    State state = make_state(free_chart(12, 9, flat));
    // Between the outermost grid samples (row 1) and the border samples (row 0.5).
    const auto hit = pick_ray(state, {0.6f, 4.3f, 3}, {0, 0, -1}).value();
    EXPECT_EQ(hit.row, kNone);
    EXPECT_EQ(hit.column, kNone);
    EXPECT_NEAR(hit.point.x, 0.6, 1e-6);
    EXPECT_NEAR(hit.point.y, 4.3, 1e-6);
    EXPECT_EQ(hit.distance, 3);
    EXPECT_GE(hit.sample, 12u * 9);  // 0.1 from the border samples' row, 0.4 from the grid's
    std::vector<std::uint32_t> faces = Triangles(state).indices;
    const std::size_t quads = 2 * (11 - 2) * (8 - 2);
    for (int c = 0; c < 3; ++c)
        EXPECT_EQ(hit.corners[c], faces[3 * (quads + hit.triangle) + static_cast<std::size_t>(c)]);
    EXPECT_FALSE(pick_ray(state, {0.4f, 4.3f, 3}, {0, 0, -1}).ok());
    // Every place of strip and grid, to the rim.
    for (float x = 0.5f; x <= 10.5f; x += 0.125f)
        for (float y = 0.5f; y <= 7.5f; y += 0.125f) EXPECT_TRUE(pick_ray(state, {x, y, 3}, {0, 0, -1}).ok()) << x;
}

// --- Hard numbers -----------------------------------------------------------------------------------------------

TEST(Pick, HugeAndTinyCoordinates) {
    for (const double size : {1e-30, 1e-12, 1e12, 6e16}) {  // to kMaxCoordinate
        State state = make_state(grid_chart(17, 17, [&](double i, double j) {
            return Point{static_cast<float>(size * i), static_cast<float>(size * j), 0};
        }));
        const auto f = static_cast<float>(size);
        for (const float d : {1e-38f, 1.0f, 3e38f}) {
            const auto hit = pick_ray(state, {3.5f * f, 4.25f * f, 8 * f}, {0, 0, -d});
            ASSERT_TRUE(hit.ok()) << size;
            EXPECT_NEAR(hit.value().distance / (8 * size), 1, 1e-6);
            EXPECT_EQ(hit.value().row, 3u);
            EXPECT_EQ(hit.value().column, 4u);
            EXPECT_EQ(hit.value().normal, (Vec3{0, 0, 1}));
        }
        compare(state, 500, 3);
    }
    // A ray from outside of where samples may be.
    State state = make_state(grid_chart(3, 3, [](double i, double j) {
        return Point{static_cast<float>(1e18 * (i - 1)), static_cast<float>(1e18 * (j - 1)), 0};
    }));
    EXPECT_FLOAT_EQ(pick_ray(state, {0, 0, 3e38f}, {0, 0, -1}).value().distance, 3e38f);
    EXPECT_NEAR(pick_ray(state, {1e30f, 1e30f, 1e30f}, {-1, -1, -1}).value().distance / 1e30, std::sqrt(3.0), 1e-6);
    // Rounded beside 3e38, all samples lie at one place, which has no area.
    EXPECT_EQ(pick_ray(state, {3e38f, 3e38f, 3e38f}, {-1, -1, -1}).error().code, ErrorCode::NotFound);
}

TEST(Pick, RefusesNonsense) {
    State state = make_state(grid_chart(9, 9, flat));
    const float nan = std::nanf("");
    const auto code = [&](Vec3 o, Vec3 d, float max = 1) {
        PickOptions options;
        options.max_distance = max;
        return pick_ray(state, o, d, options).error().code;
    };
    EXPECT_EQ(code({}, {}), ErrorCode::BadArgument);
    EXPECT_EQ(code({}, {-0.0f, 0, 0}), ErrorCode::BadArgument);
    EXPECT_EQ(code({nan, 0, 0}, {0, 0, 1}), ErrorCode::BadArgument);
    EXPECT_EQ(code({0, kInfinity, 0}, {0, 0, 1}), ErrorCode::BadArgument);
    EXPECT_EQ(code({}, {0, nan, 1}), ErrorCode::BadArgument);
    EXPECT_EQ(code({}, {0, -kInfinity, 1}), ErrorCode::BadArgument);
    EXPECT_EQ(code({}, {0, 0, 1}, -1), ErrorCode::BadArgument);
    EXPECT_EQ(code({}, {0, 0, 1}, nan), ErrorCode::BadArgument);
    EXPECT_EQ(code({20, 20, 0}, {0, 0, 1}), ErrorCode::NotFound);
    // A chart all of whose triangles have no area.
    State point = make_state(grid_chart(9, 9, [](double, double) { return Point{1, 2, 3}; }));
    EXPECT_EQ(pick_ray(point, {}, {1, 2, 3}).error().code, ErrorCode::NotFound);
}

TEST(Pick, CInterface) {
    const Bytes bytes = build({free_chart(12, 9, test::sheet)}).bytes;
    dgm_asset* asset = nullptr;
    dgm_state* state = nullptr;
    ASSERT_EQ(dgm_asset_open_memory(bytes.data(), bytes.size(), nullptr, nullptr, &asset, nullptr), DGM_OK);
    ASSERT_EQ(dgm_state_create(asset, 0, nullptr, nullptr, &state, nullptr), DGM_OK);
    State same = make_state(free_chart(12, 9, test::sheet));
    dgm_error error{};
    error.struct_size = sizeof error;
    dgm_ray_hit hit{};
    hit.struct_size = sizeof hit;
    const float down[3] = {0.1f, 0, -2};
    for (const Vec3 o : {Vec3{3.3f, 4.6f, 5}, Vec3{0.6f, 4.3f, 3}}) {
        const float origin[3] = {o.x, o.y, o.z};
        ASSERT_EQ(dgm_pick_ray(state, origin, down, nullptr, &hit, &error), DGM_OK);
        const RayHit want = pick_ray(same, o, {0.1f, 0, -2}).value();
        EXPECT_EQ(hit.sample, want.sample);
        EXPECT_EQ(hit.row, want.row);
        EXPECT_EQ(hit.column, want.column);
        EXPECT_EQ(hit.triangle, want.triangle);
        EXPECT_EQ(hit.distance, want.distance);
        EXPECT_EQ(hit.front, 1u);
        for (int k = 0; k < 3; ++k) {
            EXPECT_EQ(hit.corners[k], want.corners[k]);
            EXPECT_EQ(hit.barycentric[k], want.barycentric[k]);
            EXPECT_EQ(hit.point[k], (&want.point.x)[k]);
            EXPECT_EQ(hit.normal[k], (&want.normal.x)[k]);
        }
    }
    dgm_pick_options options{};
    options.struct_size = sizeof options;
    options.max_distance = 2;
    const float origin[3] = {3.3f, 4.6f, 5}, below[3] = {3.3f, 4.6f, -5}, up[3] = {0, 0, 1}, zero[3] = {};
    EXPECT_EQ(dgm_pick_ray(state, origin, down, &options, &hit, &error), DGM_NOT_FOUND);
    EXPECT_EQ(error.code, unsigned{DGM_NOT_FOUND});
    options.max_distance = 0;
    EXPECT_EQ(dgm_pick_ray(state, below, up, &options, nullptr, nullptr), DGM_OK);
    options.skip_back_faces = 1;
    EXPECT_EQ(dgm_pick_ray(state, below, up, &options, &hit, &error), DGM_NOT_FOUND);
    EXPECT_EQ(dgm_pick_ray(state, origin, zero, nullptr, &hit, &error), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_pick_ray(nullptr, origin, down, nullptr, &hit, &error), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_pick_ray(state, nullptr, down, nullptr, &hit, &error), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_pick_ray(state, origin, nullptr, nullptr, &hit, &error), DGM_BAD_ARGUMENT);
    options.max_distance = -1;
    EXPECT_EQ(dgm_pick_ray(state, origin, down, &options, &hit, &error), DGM_BAD_ARGUMENT);
    options.struct_size = 0;
    EXPECT_EQ(dgm_pick_ray(state, origin, down, &options, &hit, &error), DGM_BAD_ARGUMENT);
    dgm_state_destroy(state);
    dgm_asset_close(asset);
}

}  // namespace
}  // namespace dgm::test
