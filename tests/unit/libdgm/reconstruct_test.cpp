// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/reconstruct_test.cpp
#include <gtest/gtest.h>

#include <dgm/deform.h>
#include <dgm/octahedral.h>
#include <dgm/reconstruct.h>

#include <cmath>
#include <map>

#include "opened.h"

namespace dgm::test {
namespace {

template <class Surface>
std::vector<std::uint32_t> indices_of(const Surface& surface) {
    std::vector<std::uint32_t> indices(mesh_counts(surface).value().indices);
    EXPECT_EQ(reconstruct(surface, VertexTarget{}, indices).value().indices, indices.size());
    return indices;
}

TEST(Reconstruct, TrianglesOfASmallGridByHand) {
    ChartSpec c = grid_chart(2, 3, sheet);
    c.add("diagonals", ElementType::kU8, {1, 2}, std::vector<std::uint8_t>{0, 1});
    const Opened opened(build({c}));
    EXPECT_EQ(mesh_counts(opened.chart()).value().vertices, 6u);
    //  0 1 2
    //  3 4 5   quad 0 split 0-4, quad 1 split 4-2
    const std::vector<std::uint32_t> want{0, 3, 4, 0, 4, 1, 1, 4, 2, 4, 5, 2};
    EXPECT_EQ(indices_of(opened.chart()), want);
    EXPECT_EQ(indices_of(make_state(c)), want);
}

TEST(Reconstruct, IntoAnyLayout) {
    ChartSpec c = grid_chart(4, 5, sheet);
    std::vector<std::int16_t> normals;
    for (int k = 0; k < 40; ++k) normals.push_back(static_cast<std::int16_t>(700 * k - 14000));
    c.add("normal", ElementType::kI16, {4, 5, 2}, normals);
    const Opened opened(build({c}));
    Bytes memory(20 * 37 + 3, std::byte{0xEE});
    VertexTarget target{std::span(memory).subspan(3), 37, 1, 13, 26};  // packed and unaligned, 3 bytes spare at the end
    std::vector<std::uint32_t> none;
    ASSERT_TRUE(reconstruct(opened.chart(), target, none).ok());
    for (std::uint32_t k = 0; k < 20; ++k) {
        float v[8];
        std::memcpy(v, memory.data() + 3 + 37 * k + 1, 12);
        std::memcpy(v + 3, memory.data() + 3 + 37 * k + 13, 12);
        std::memcpy(v + 6, memory.data() + 3 + 37 * k + 26, 8);
        const Point p = sheet(k / 5, k % 5);
        EXPECT_EQ((Point{v[0], v[1], v[2]}), p);
        const auto n = decode_octahedral(normals[2 * k], normals[2 * k + 1]);
        EXPECT_EQ((Point{v[3], v[4], v[5]}), (Point{n[0], n[1], n[2]}));
        EXPECT_EQ(v[6], float(k % 5) / 4);
        EXPECT_EQ(v[7], float(double(k / 5) / 3));
        for (const std::size_t gap : {0, 25, 34, 35, 36}) EXPECT_EQ(memory[3 + 37 * k + gap], std::byte{0xEE});
    }
}

TEST(Reconstruct, QuantisedGeometryIsLocal) {
    ChartSpec c = grid_chart(2, 2, sheet);
    c.layers.clear();
    c.offset = {1e6, 0, 0};
    c.scale = {0.5, 0.25, 1e-3};
    const std::vector<std::uint16_t> stored{0, 0, 0, 2, 4, 1000, 65535, 1, 2, 7, 8, 9};
    c.add("geometry", ElementType::kU16, {2, 2, 3}, stored);
    const Opened opened(build({c}));
    std::vector<float> p(12);
    VertexTarget target;
    target.memory = std::as_writable_bytes(std::span(p));
    ASSERT_TRUE(reconstruct(opened.chart(), target, {}).ok());
    EXPECT_EQ(p, (std::vector<float>{0, 0, 0, 1, 1, 1, 32767.5f, 0.25f, 0.002f, 3.5f, 2, 0.009f}));
    const State state = State::create(opened.chart()).value();
    EXPECT_EQ(state.positions()[2].x, 32767.5f);
}

TEST(Reconstruct, FreeDomainIsAClosedFan) {
    const std::uint32_t m = 8, n = 9;
    ChartSpec c = free_chart(m, n, sheet);
    const Opened opened(build({c}));
    const auto indices = indices_of(opened.chart());
    EXPECT_EQ(indices.size(), (5 * 6 * 2) * 3 + c.layer("border_faces").bytes.size() / 4);
    // Watertight: every directed edge once, its reverse present except along the 26 border edges.
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (std::size_t k = 0; k < indices.size(); k += 3)
        for (std::size_t e = 0; e < 3; ++e) ++edges[{indices[k + e], indices[k + (e + 1) % 3]}];
    int open = 0;
    for (const auto& [edge, times] : edges) {
        EXPECT_EQ(times, 1);
        open += edges.count({edge.second, edge.first}) == 0;
    }
    EXPECT_EQ(open, static_cast<int>(c.border_samples));
    EXPECT_EQ(indices_of(make_state(c)), indices);
}

TEST(Reconstruct, StateShowsTheDeformedShapeWithItsNormals) {
    State state = make_state(grid_chart(20, 20, sheet, tube_seams(20, 20)));
    KernelOptions kernel;
    kernel.reach = 6;
    Touch touch;
    touch.sample = 10 * 20 + 1;
    touch.displacement = {0, 0, 3};
    touch.d_max = 5;
    ASSERT_TRUE(deform(state, DeformTable::create(kernel).value(), touch).ok());
    std::vector<float> v(400 * 8);
    VertexTarget target{std::as_writable_bytes(std::span(v)), 32, 0, 12, 24};
    ASSERT_TRUE(reconstruct(state, target, {}).ok());
    for (std::uint32_t k = 0; k < 400; ++k) {
        EXPECT_EQ((Vec3{v[8 * k], v[8 * k + 1], v[8 * k + 2]}), state.positions()[k]);
        EXPECT_EQ((Vec3{v[8 * k + 3], v[8 * k + 4], v[8 * k + 5]}), state.normal(k));
        EXPECT_NEAR(std::hypot(v[8 * k + 3], v[8 * k + 4], v[8 * k + 5]), 1, 1e-6);
    }
}

TEST(Reconstruct, Refusals) {
    const ChartSpec c = free_chart(8, 9, sheet);
    const Opened opened(build({c}));
    const MeshCounts counts = mesh_counts(opened.chart()).value();
    std::vector<std::uint32_t> few(counts.indices - 1);
    EXPECT_EQ(reconstruct(opened.chart(), {}, few).error().code, ErrorCode::BufferTooSmall);
    std::vector<float> v(3 * counts.vertices);
    VertexTarget target;
    target.memory = std::as_writable_bytes(std::span(v)).subspan(1);
    EXPECT_EQ(reconstruct(opened.chart(), target, {}).error().code, ErrorCode::BufferTooSmall);
    target.memory = std::as_writable_bytes(std::span(v));
    EXPECT_TRUE(reconstruct(opened.chart(), target, {}).ok());
    target.position_offset = 1;
    EXPECT_EQ(reconstruct(opened.chart(), target, {}).error().code, ErrorCode::BadArgument);
    target.position_offset = 0;
    target.stride = ~std::size_t{0} / 2;
    EXPECT_EQ(reconstruct(opened.chart(), target, {}).error().code, ErrorCode::BufferTooSmall);
    target.stride = 12;
    target.position_offset = kNoAttribute;
    target.normal_offset = 0;
    EXPECT_EQ(reconstruct(opened.chart(), target, {}).error().code, ErrorCode::MissingLayer);
    EXPECT_EQ(reconstruct(opened.chart(), {}, {}, {1, static_cast<IndexTopology>(2)}).error().code,
              ErrorCode::Unsupported);
    EXPECT_EQ(mesh_counts(opened.chart(), {0}).error().code, ErrorCode::BadArgument);
    // Values that were not validated are still no way out of the buffers.
    ChartSpec bad = c;
    const std::uint32_t far = 1u << 30;
    std::memcpy(bad.layer("border_faces").bytes.data(), &far, 4);
    const Opened spoiled(build({bad}));
    std::vector<std::uint32_t> enough(counts.indices);
    EXPECT_EQ(reconstruct(spoiled.chart(), {}, enough).error().code, ErrorCode::BadValue);
}

}  // namespace
}  // namespace dgm::test
