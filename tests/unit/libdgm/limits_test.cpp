// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/limits_test.cpp
// Numbers at the ends of their ranges (limits.h) and just beyond, and a file that is overwritten while it is read.
#include <gtest/gtest.h>

#include <dgm/collide.h>
#include <dgm/contact.h>
#include <dgm/reconstruct.h>
#include <dgm/tick.h>
#include <dgm/validate.h>

#include <cmath>
#include <limits>

#include "opened.h"
#include "platform.h"
#if DGM_TEST_THREADS
#include <atomic>
#include <thread>
#endif

namespace dgm::test {
namespace {
constexpr float kInfinity = std::numeric_limits<float>::infinity();

float beyond(float v) {
    return std::nextafter(v, v > 0 ? kInfinity : -kInfinity);
}

template <class T>
void set(ChartSpec& c, const char* layer, std::size_t index, T value) {
    std::memcpy(c.layer(layer).bytes.data() + index * sizeof(T), &value, sizeof value);
}

/// Refused by both, at the byte.
void expect_refused(const ChartSpec& chart, ErrorCode code, const char* layer, std::size_t byte) {
    const Opened opened(build({chart}));
    const Error e = validate_chart(opened.chart()).error();
    EXPECT_EQ(e.code, code) << e.message;
    EXPECT_EQ(e.byte_offset, opened.chart().find(layer).value().file_offset + byte) << e.message;
    EXPECT_EQ(State::create(opened.chart()).error().code, code);
}
void expect_taken(const ChartSpec& chart) {
    const Opened opened(build({chart}));
    const Error e = validate_chart(opened.chart()).error();
    EXPECT_EQ(e.code, ErrorCode::Ok) << e.message;
    EXPECT_TRUE(State::create(opened.chart()).ok());
}

TEST(Limits, PositionsOfAMap) {
    ChartSpec c = grid_chart(9, 9, sheet);
    set(c, "geometry", 3 * 40 + 1, -kMaxCoordinate);
    expect_taken(c);
    set(c, "geometry", 3 * 40 + 1, beyond(-kMaxCoordinate));
    expect_refused(c, ErrorCode::BadValue, "geometry", 12 * 40);
    ChartSpec f = free_chart(5, 6, sheet);
    set(f, "border_geometry", 3 * 2 + 2, beyond(kMaxCoordinate));
    expect_refused(f, ErrorCode::BadValue, "border_geometry", 12 * 2);
    // Steps of 2e36 around 3e38: every coordinate is finite, every difference of some of them too, no square is.
    expect_refused(grid_chart(9, 9,
                              [](double i, double j) {
                                  return Point{static_cast<float>(3e38), static_cast<float>(3e38 + 2e36 * j),
                                               static_cast<float>(3e38 - 2e36 * i)};
                              }),
                   ErrorCode::BadValue, "geometry", 0);
}

TEST(Limits, SeamsLieOnTheBorder) {
    const auto spec = [](SeamPairs pairs) { return grid_chart(7, 5, sheet, pairs); };
    expect_taken(spec({{0, 4}, {2, 32}, {10, 14}}));
    expect_refused(spec({{0, 4}, {2, 16}}), ErrorCode::BadSeamTable, "seams", 8);  // a copy inside
    expect_refused(spec({{6, 34}}), ErrorCode::BadSeamTable, "seams", 0);          // a representative inside
    expect_refused(spec({{6, 7}, {0, 4}}), ErrorCode::BadSeamTable, "seams", 0);   // both
    // In a free domain that is among the border samples, from 5 * 6 on; 8 is on the surface, with quads around it.
    expect_taken(free_chart(5, 6, sheet, {{30, 41}, {31, 40}}));
    ChartSpec mixed = free_chart(5, 6, sheet);
    std::memcpy(mixed.layer("border_geometry").bytes.data(), mixed.layer("geometry").bytes.data() + 12 * 8, 12);
    mixed.add("seams", ElementType::kU32, {1, 2}, std::vector<std::uint32_t>{8, 30});
    expect_refused(mixed, ErrorCode::BadSeamTable, "seams", 0);
}

TEST(Limits, WhatTouchesReadOfAMap) {
    const auto chart = [](std::size_t element, float value) {
        ChartSpec c = grid_chart(3, 3, sheet);
        std::vector<float> all;
        for (int k = 0; k < 9; ++k) all.insert(all.end(), {1, 0, 1, 1});
        all[element] = value;
        c.add("deformation", ElementType::kF32, {3, 3, 4}, all);
        return c;
    };
    for (const std::size_t form : {0u, 1u, 2u}) {
        expect_taken(chart(4 * 5 + form, kMaxForm));
        for (const float bad : {beyond(kMaxForm), 3e38f, kInfinity, std::nanf("")})
            expect_refused(chart(4 * 5 + form, bad), ErrorCode::BadValue, "deformation", 4 * (4 * 5 + form));
    }
    expect_taken(chart(4 * 5 + 1, -kMaxForm));
    expect_refused(chart(4 * 5, -1e-3f), ErrorCode::BadValue, "deformation", 4 * 20);
    expect_refused(chart(4 * 5 + 2, -1e-3f), ErrorCode::BadValue, "deformation", 4 * 22);
    expect_taken(chart(4 * 5 + 3, 0));
    for (const float bad : {-1e-3f, beyond(1), std::nanf("")})
        expect_refused(chart(4 * 5 + 3, bad), ErrorCode::BadValue, "deformation", 4 * 23);
    ChartSpec mobile = grid_chart(3, 3, sheet);
    mobile.add("contact", ElementType::kF32, {3, 3, 2}, std::vector<float>(18, 2));  // area 2, mobility 2
    expect_refused(mobile, ErrorCode::BadValue, "contact", 4);
}

TEST(Limits, UnitAndMaterialAreInRange) {
    const auto chart = [](std::vector<float> values) {
        ChartSpec c = grid_chart(3, 3, sheet);
        c.add("material", ElementType::kF32, {values.size()}, values);
        return c;
    };
    const std::vector<float> good{1e-3f, 200, 0.3f, 1e-3f, 2e4f, 5, 0};
    const std::vector<float> low{1e-9f, 1e-6f, 0, 0, 0, 1e-6f, 0}, high{1e9f, 1e12f, 0.49f, 1e12f, 1e12f, 1e12f, 1e6f};
    expect_taken(chart({1}));
    expect_taken(chart(low));
    expect_taken(chart(high));
    for (std::size_t k = 0; k < good.size(); ++k)
        for (const float bad : {std::nextafter(low[k], -1.0f), beyond(high[k]), -kInfinity, std::nanf("")}) {
            std::vector<float> values = good;
            values[k] = bad;
            expect_refused(chart(values), ErrorCode::BadValue, "material", 4 * k);
        }
    std::vector<float> longer = good;
    longer.push_back(std::nanf(""));  // what later versions put there
    expect_taken(chart(longer));
    longer[6] = -1;
    expect_refused(chart(longer), ErrorCode::BadValue, "material", 24);
}

TEST(Limits, Kernels) {
    const auto code = [](KernelShape shape, float sigma, float a, float b) {
        KernelOptions k;
        k.shape = shape;
        k.sigma = sigma;
        k.radius_a = a;
        k.radius_b = b;
        return DeformTable::create(k).error().code;
    };
    const KernelShape round = KernelShape::Circular, oval = KernelShape::Elliptic;
    EXPECT_EQ(code(round, kMinSigma, 0, 0), ErrorCode::Ok) << "radii are not read";
    EXPECT_EQ(code(round, kMaxSigma, 0, 0), ErrorCode::Ok);
    EXPECT_EQ(code(round, std::nextafter(kMinSigma, 0.0f), 4, 4), ErrorCode::BadArgument);
    EXPECT_EQ(code(round, beyond(kMaxSigma), 4, 4), ErrorCode::BadArgument);
    EXPECT_EQ(code(oval, 0, 1, kMaxKernelRatio), ErrorCode::Ok);
    EXPECT_EQ(code(oval, 0, kMaxKernelRatio, 1), ErrorCode::Ok);
    EXPECT_EQ(code(oval, 0, 1, beyond(kMaxKernelRatio)), ErrorCode::BadArgument);
    EXPECT_EQ(code(oval, 0, 1e-6f, 1e15f), ErrorCode::BadArgument);
    EXPECT_EQ(code(oval, 0, kMaxKernelRadius, kMaxKernelRadius), ErrorCode::Ok);
    EXPECT_EQ(code(oval, 0, beyond(kMaxKernelRadius), kMaxKernelRadius), ErrorCode::BadArgument);
    EXPECT_EQ(code(oval, 0, kMinKernelRadius, std::nextafter(kMinKernelRadius, 0.0f)), ErrorCode::BadArgument);
}

TEST(Limits, StepsAndDisplacements) {
    State state = make_state(grid_chart(9, 9, sheet));
    const DeformTable table = DeformTable::create({}).value();
    const auto code = [&](float x, float step) {
        Touch t;
        t.sample = 40;
        t.displacement = {0, x, 0};
        t.d_max = 1;
        t.step = step;
        return deform(state, table, t).error().code;
    };
    for (const float step : {0.0f, kMinStep, kMaxStep}) EXPECT_EQ(code(1, step), ErrorCode::Ok);
    for (const float step : {std::nextafter(kMinStep, 0.0f), beyond(kMaxStep), -1.0f, kInfinity, std::nanf("")})
        EXPECT_EQ(code(1, step), ErrorCode::BadArgument) << step;
    EXPECT_EQ(code(-kMaxCoordinate, 0), ErrorCode::Ok);
    EXPECT_EQ(code(beyond(-kMaxCoordinate), 0), ErrorCode::BadArgument);
}

/// A grasp without a limit takes hold from one end of the space and pulls to the other.
TEST(Limits, FarthestGrasp) {
    State state = make_state(grid_chart(9, 9, sheet));
    KernelOptions kernel;
    kernel.reach = 5;
    const DeformTable table = DeformTable::create(kernel).value();
    TickOptions o;
    o.grasp_distance = kInfinity;
    o.d_max = 2;
    o.f_max = 3;
    o.settle_time = 0;
    ToolInput in;
    in.kind = ToolKind::Grasp;
    ToolOutput out;
    for (const float x : {kMaxCoordinate, -kMaxCoordinate}) {
        in.position = {x, 0, 0};
        ASSERT_TRUE(tick(state, table, o, {&in, 1}, {&out, 1}).ok());
        EXPECT_TRUE(out.holding);
    }
    EXPECT_EQ(out.displacement, (Vec3{-2, 0, 0}));  // 2e18 along -x, shortened to d_max
    EXPECT_EQ(out.force, (Vec3{3, 0, 0}));
    in.position = {beyond(kMaxCoordinate), 0, 0};
    EXPECT_EQ(tick(state, table, o, {&in, 1}, {&out, 1}).error().code, ErrorCode::BadArgument);
}

TEST(Limits, ToolsAndObstacles) {
    State state = make_state(grid_chart(9, 9, sheet));
    const float far = beyond(kMaxCoordinate);
    EXPECT_TRUE(nearest_sample(state, {kMaxCoordinate, 0, 0}).ok());
    EXPECT_EQ(nearest_sample(state, {0, far, 0}).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(track_sample(state, {0, 0, -far}, 40, 3).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(track_nearest(state, {0, 0, -far}, 40, 3).error().code, ErrorCode::BadArgument);
    Obstacle o;
    o.kind = ObstacleKind::Sphere;
    o.radius = kMaxCoordinate;
    EXPECT_NEAR(obstacle_distance(o, {0, 0, 0}).value().distance / kMaxCoordinate, -1, 1e-6);
    EXPECT_EQ(obstacle_distance(o, {far, 0, 0}).error().code, ErrorCode::BadArgument);
    o.radius = far;
    EXPECT_EQ(obstacle_distance(o, {0, 0, 0}).error().code, ErrorCode::BadArgument);
    o.radius = 1;
    o.point.z = far;
    EXPECT_EQ(obstacle_distance(o, {0, 0, 0}).error().code, ErrorCode::BadArgument);
}

/// Both triangles of the quad are the segment from (0, 0, 0) to (2, 0, 0): abc has a = b, acd has c = d.
TEST(Limits, SurfacesWithoutAreaAndWithoutTriangles) {
    State line = make_state(grid_chart(2, 2, [](double, double j) { return Point{static_cast<float>(2 * j), 0, 0}; }));
    Obstacle o;
    o.kind = ObstacleKind::Surface;
    o.surface = &line;
    const auto found = obstacle_distance(o, {0.5f, 3, 4});
    ASSERT_TRUE(found.ok());
    EXPECT_NEAR(found.value().distance, 5, 1e-6);
    EXPECT_NEAR(found.value().nearest.x, 0.5, 1e-6);
    ChartSpec dots = free_chart(4, 4, sheet);
    dots.layer("border_faces").shape[0] = 0;
    dots.layer("border_faces").bytes.clear();
    for (const std::size_t k : {6u, 9u}) set<std::uint8_t>(dots, "mask", k, 0);
    State apart = make_state(dots);
    o.surface = &apart;
    EXPECT_EQ(obstacle_distance(o, {0, 0, 0}).error().code, ErrorCode::NotFound);
}

TEST(Limits, WeakHoldDoesNotThrowTheSurfaceAbout) {
    ChartSpec chart = grid_chart(9, 9, sheet);
    std::vector<float> share;
    for (int k = 0; k < 81; ++k) share.insert(share.end(), {1, k == 40 ? 1e-45f : 1});
    chart.add("contact", ElementType::kF32, {9, 9, 2}, share);
    State state = make_state(chart);
    KernelOptions kernel;
    kernel.reach = 3;
    const DeformTable table = DeformTable::create(kernel).value();
    TickOptions o;
    o.relax_rate = 1;
    o.d_max = 1;
    ToolInput in;
    in.position = {4, 4, -0.5f};  // behind sample 40, which can hardly move
    for (int k = 0; k < 3; ++k) {
        ASSERT_TRUE(tick(state, table, o, {&in, 1}, {}).ok());
        for (std::uint32_t s = 0; s < 81; ++s)
            ASSERT_LE(std::fabs(state.positions()[s].z - state.rest_positions()[s].z), 1.001f) << s;
    }
}

#if DGM_TEST_THREADS
/// Another process writes diagonals of 200 and faces of 2^32 - 1 into the mapped file, again and again.
TEST(Limits, FileOverwrittenWhileItIsRead) {
    constexpr std::uint32_t kSide = 257;  // a call lasts long enough to be overtaken between its check and its end
    ChartSpec chart = free_chart(kSide, kSide, sheet);
    chart.add("diagonals", ElementType::kU8, {kSide - 1, kSide - 1},
              std::vector<std::uint8_t>((kSide - 1) * (kSide - 1), 1));
    Opened opened(build({chart}));
    const Chart c = opened.chart();
    const auto place = [&](const char* name) {
        const LayerView layer = c.find(name).value();
        return std::span<std::byte>(opened.bytes.data() + layer.file_offset, layer.bytes);
    };
    const std::span<std::byte> diagonals = place("diagonals"), faces = place("border_faces");
    const Bytes good(faces.begin(), faces.end());
    std::atomic<bool> stop = false;
    std::thread writer([&] {
        const auto store = [](std::byte& to, std::byte value) {
            std::atomic_ref<std::byte>(to).store(value, std::memory_order_relaxed);
        };
        for (bool bad = true; !stop || !bad; bad = !bad) {
            for (std::byte& d : diagonals.last(300)) store(d, bad ? std::byte{200} : std::byte{1});
            for (std::size_t k = 0; k < faces.size(); ++k) store(faces[k], bad ? std::byte{255} : good[k]);
        }
    });
    std::vector<std::uint32_t> indices;
    std::uint32_t written = 0;
    // On a busy machine the two threads may take turns so that every call meets bad bytes: then some more.
    for (std::uint32_t k = 0; k < 600 || (written == 0 && k < 20'000); ++k) {
        ReconstructOptions options;
        options.lod_stride = 1 + k % 3;
        options.topology = k % 2 == 0 ? IndexTopology::Triangles : IndexTopology::Strips;
        indices.assign(std::size_t{8} * kSide * kSide, 0);
        if (const auto made = reconstruct(c, {}, indices, options)) {
            ++written;
            const bool strips = options.topology == IndexTopology::Strips;
            for (const std::uint32_t v : indices)
                if (v >= c.sample_count() && !(strips && v == kRestart)) ADD_FAILURE() << v;
        }
        if (k % 60 == 0) static_cast<void>(State::create(c).ok());
    }
    stop = true;
    writer.join();
    EXPECT_GT(written, 0u);
}
#endif

}  // namespace
}  // namespace dgm::test
