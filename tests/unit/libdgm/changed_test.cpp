// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/changed_test.cpp
// changed_rows(): a reader that copies only the reported samples must have, to the bit, the shape of the state,
// whatever was done to it; and where nothing was done there is nothing to copy.
#include <gtest/gtest.h>

#include <dgm/collide.h>
#include <dgm/dgm.h>
#include <dgm/pick.h>
#include <dgm/snapshot.h>

#include <random>

#include "changed_life.h"

namespace dgm::test {
namespace {

struct Reader {
    std::size_t capacity;
    std::uint64_t cursor = 0;
    std::vector<float> copy{};
    double covered = 0, changed = 0;  ///< samples, in all
    explicit Reader(std::size_t c) : capacity(c) {}

    void read(const State& state) {
        std::vector<ChangedRange> ranges(capacity);
        const auto count = changed_rows(state, cursor, ranges);
        ASSERT_TRUE(count.ok());
        ASSERT_LE(count.value(), capacity);
        std::vector<char> in;
        ASSERT_TRUE(cover(state, {ranges.data(), count.value()}, in));
        const std::vector<float> now = shape_of(state);
        const std::size_t total = state.sample_count();
        const bool first = copy.empty();
        copy.resize(now.size(), 7e7f);
        for (std::size_t k = 0; k < total; ++k) {
            bool differs = false;
            for (std::size_t p = 0; p < 6; ++p)
                differs = differs || std::memcmp(&copy[p * total + k], &now[p * total + k], 4) != 0;
            ASSERT_TRUE(!differs || in[k] != 0) << "sample " << k << " changed unseen";
            if (first) continue;
            covered += in[k];
            changed += differs ? 1 : 0;
        }
        copy = now;
        for (std::size_t a = 0; a < count.value() && capacity > 500; ++a)  // nothing was joined: no two meet
            for (std::size_t b = 0; b < a; ++b) {
                std::vector<char> one, other;
                cover(state, {&ranges[a], 1}, one);
                cover(state, {&ranges[b], 1}, other);
                for (std::size_t k = 0; k < total; ++k) ASSERT_FALSE(one[k] != 0 && other[k] != 0);
            }
    }
};

std::size_t count_of(const State& state, std::uint64_t& cursor) {
    std::vector<ChangedRange> ranges(64);
    return changed_rows(state, cursor, ranges).value();
}

TEST(Changed, ReadersNeverMissASample) {
    unsigned seed = 1;
    for (const ChartSpec& chart : all_charts()) {
        SCOPED_TRACE(seed);
        Life life(chart, seed++);
        Reader readers[] = {Reader(1000), Reader(2), Reader(3), Reader(17), Reader(1000)};
        for (int step = 0; step < 700; ++step) {
            life.step();
            if (::testing::Test::HasFatalFailure()) FAIL() << "step " << step;
            for (std::size_t r = 0; r < std::size(readers); ++r)
                if (r == 0 || life.random() % (5 * r) == 0) readers[r].read(life.state);
            if (::testing::Test::HasFatalFailure()) FAIL() << "step " << step;
        }
        EXPECT_GT(readers[0].changed, 0);
        EXPECT_LT(readers[0].covered, 4 * readers[0].changed);  // tiles of what fades, rings of contacts
    }
}

TEST(Changed, FirstReadIsAllAndRestIsNothing) {
    for (const ChartSpec& chart : all_charts()) {
        Life life(chart, 5);
        State& state = life.state;
        std::uint64_t cursor = 0;
        ChangedRange ranges[8];
        ASSERT_EQ(changed_rows(state, cursor, ranges).value(), chart.border_samples != 0 ? 2u : 1u);
        EXPECT_EQ(ranges[0].first, 0u);
        EXPECT_EQ(ranges[0].rows, chart.rows);
        EXPECT_EQ(ranges[0].columns, chart.cols);
        if (chart.border_samples != 0) {
            EXPECT_EQ(ranges[1].first, chart.rows * chart.cols);
            EXPECT_EQ(ranges[1].columns, chart.border_samples);
        }
        const auto expect_rest = [&](const char* after) { EXPECT_EQ(count_of(state, cursor), 0u) << after; };
        const auto disturb_nothing = [&] {
            expect_rest("a read");
            static_cast<void>(state.positions());
            static_cast<void>(state.normals());
            static_cast<void>(nearest_sample(state, {1, 2, 3}).ok());
            static_cast<void>(pick_ray(state, {1, 2, 9}, {0, 0, -1}).ok());
            static_cast<void>(state.usage());
            expect_rest("questions");
            state.update_normals();
            expect_rest("update_normals");
            state.release();
            expect_rest("release");
            EXPECT_TRUE(state.relax(0.01f, 5).ok());
            expect_rest("relax");
            state.reset();
            expect_rest("reset");
            TickOptions o;
            o.d_max = life.size;
            ToolInput in;
            in.tool = 2;  // has never touched anything
            in.position = {0, 0, 1e6f};
            in.engaged = false;
            for (const float rate : {kAtOnce, 20.0f, 0.0f}) {
                o.relax_rate = rate;
                for (int k = 0; k < 3; ++k) {
                    EXPECT_TRUE(tick(state, life.table, o, {&in, 1}, {}).ok());
                    expect_rest("a tick that touches nothing");
                }
            }
            std::uint64_t another = 0;
            EXPECT_GT(count_of(state, another), 0u);  // another reader's first look is no change
            expect_rest("another reader");
            auto shots = Snapshots::create(state);
            EXPECT_TRUE(shots.value().publish(state).ok());
            expect_rest("publish");
        };
        disturb_nothing();
        for (int k = 0; k < 40; ++k) life.step();
        state.reset();
        state.update_normals();
        EXPECT_GT(count_of(state, cursor), 0u);
        disturb_nothing();
        // Refused calls change nothing.
        Touch wrong;
        wrong.sample = state.sample_count();
        wrong.d_max = 1;
        EXPECT_FALSE(deform(state, life.table, wrong).ok());
        expect_rest("a refused touch");
    }
}

TEST(Changed, WhatStaysPressedIsNotReportedAgain) {
    for (const ChartSpec& chart : all_charts()) {
        Life life(chart, 6);
        State& state = life.state;
        TickOptions o;
        o.d_max = life.size;
        o.relax_rate = 0;  // never fades
        ToolInput in;
        const std::uint32_t k = life.sample();
        in.position = state.positions()[k] - (life.size / 2) * state.normal(k);
        Reader reader(1000);
        reader.read(state);
        for (int turn = 0; turn < 20; ++turn) ASSERT_TRUE(tick(state, life.table, o, {&in, 1}, {}).ok());
        reader.read(state);
        EXPECT_GT(reader.changed, 0);
        in.engaged = false;
        for (int turn = 0; turn < 200; ++turn)  // what the contact carries on has settled by then
            ASSERT_TRUE(tick(state, life.table, o, {&in, 1}, {}).ok());
        reader.read(state);
        for (int turn = 0; turn < 5; ++turn) {
            ASSERT_TRUE(tick(state, life.table, o, {&in, 1}, {}).ok());
            EXPECT_EQ(count_of(state, reader.cursor), 0u) << turn;
        }
        // A time that stands still, too, and no time at all.
        o.relax_rate = 20;
        o.dt = 0;
        ASSERT_TRUE(tick(state, life.table, o, {&in, 1}, {}).ok());
        EXPECT_EQ(count_of(state, reader.cursor), 0u);
        EXPECT_TRUE(state.relax(0, 20).ok());
        EXPECT_EQ(count_of(state, reader.cursor), 0u);
        // Until it fades: then it is seen, and ends.
        for (int turn = 0; turn < 40; ++turn) {
            EXPECT_TRUE(state.relax(0.05f, 20).ok());
            reader.read(state);
        }
        EXPECT_TRUE(state.relax(0.05f, 20).ok());
        EXPECT_EQ(count_of(state, reader.cursor), 0u);
        EXPECT_TRUE(same(shape_of(state), reader.copy));
    }
}

TEST(Changed, ASlidingToolIsFollowedWithoutNormals) {
    State state = make_state(sheet_chart(65, 65));
    const DeformTable table = table_of(5);
    TickOptions o;
    o.d_max = 2;
    o.normals = false;
    Reader reader(1000);
    reader.read(state);
    for (int k = 0; k < 300; ++k) {
        const float i = 12 + static_cast<float>(k % 40), j = 12 + static_cast<float>(k * 7 % 40);
        ToolInput in;
        in.position = {i, j, static_cast<float>(0.3 * std::sin(0.37 * i) * std::cos(0.23 * j)) - 0.5f};
        ASSERT_TRUE(tick(state, table, o, {&in, 1}, {}).ok());
        reader.read(state);
        if (HasFatalFailure()) FAIL() << "tick " << k;
    }
    EXPECT_GT(reader.changed, 10000);
}

TEST(Changed, BorderNormalsFollowATickWhoseTimeStands) {
    // A border sample pressed in a tick that fades nothing: its normal is brought up to date like any other.
    State state = make_state(free_chart(27, 34, test::sheet));
    const DeformTable table = table_of(1);
    TickOptions o;
    o.d_max = 1;
    o.relax_rate = 0;
    for (std::uint32_t k = 27 * 34; k < state.sample_count(); ++k) {
        ToolInput in;
        in.kind = ToolKind::Grasp;
        in.position = state.positions()[k];
        ASSERT_TRUE(tick(state, table, o, {&in, 1}, {}).ok());
        in.position = in.position + Vec3{0.25f, 0.125f, 0.5f};
        ASSERT_TRUE(tick(state, table, o, {&in, 1}, {}).ok());
        const PointView n = state.normals();
        for (std::uint32_t s = 0; s < state.sample_count(); ++s) ASSERT_TRUE(same_bits(n[s], state.normal(s))) << s;
        in.engaged = false;
        ASSERT_TRUE(tick(state, table, o, {&in, 1}, {}).ok());
    }
}

TEST(Changed, RangesAreTightAroundATouch) {
    State state = make_state(sheet_chart(129, 129));
    const DeformTable table = table_of(11);
    Reader reader(1000);
    reader.read(state);
    std::mt19937 random(4);
    double worst = 0;
    for (int k = 0; k < 300; ++k) {
        Touch t;
        t.sample =
            (20 + static_cast<std::uint32_t>(random() % 89)) * 129 + 20 + static_cast<std::uint32_t>(random() % 89);
        t.displacement = {0, 0, 0.5f};
        t.d_max = 1;
        ASSERT_TRUE(deform(state, table, t).ok());
        state.update_normals();
        reader.covered = reader.changed = 0;
        reader.read(state);
        worst = std::max(worst, reader.covered / reader.changed);
        ChangedRange ranges[4];
        state.release();
        state.update_normals();
        const auto count = changed_rows(state, reader.cursor, ranges).value();
        ASSERT_EQ(count, 1u);
        // Less than b = 11 mean steps to each side, of which a row has at least 0.9; and one more for the normals.
        ASSERT_LE(ranges[0].rows, 27u);
        ASSERT_LE(ranges[0].columns, 32u);
        reader.copy = shape_of(state);
    }
    // A box around a disk, whose columns come by eight.
    EXPECT_LT(worst, 32.0 / 23 * 4 / 3.1416);
    RecordProperty("worst_ratio_percent", static_cast<int>(100 * worst));
}

TEST(Changed, ManyTicksUnread) {
    // A tool that crosses the sheet slantwise, without a reader: its path, not the box around it.
    State state = make_state(sheet_chart(201, 201));
    const DeformTable table = table_of(4);
    Reader reader(1000);
    reader.read(state);
    TickOptions o;
    o.d_max = 2;
    for (int k = 0; k < 1800; ++k) {
        const float at = 10 + static_cast<float>(k) / 10;
        ToolInput in;
        in.position = {at, at, static_cast<float>(0.3 * std::sin(0.37 * at) * std::cos(0.23 * at)) - 0.5f};
        o.mode = DeformMode::Plastic;
        ASSERT_TRUE(tick(state, table, o, {&in, 1}, {}).ok());
    }
    reader.read(state);
    EXPECT_LT(reader.covered, 3 * reader.changed);
    EXPECT_LT(reader.covered, 201 * 201 / 4);
}

TEST(Changed, CursorsAndRoom) {
    State state = make_state(free_chart(27, 34, test::sheet));
    std::uint64_t cursor = 0;
    ChangedRange one[1], two[2];
    EXPECT_EQ(changed_rows(state, cursor, one).error().code, ErrorCode::BufferTooSmall);
    EXPECT_EQ(changed_rows(state, cursor, {}).error().code, ErrorCode::BufferTooSmall);
    EXPECT_EQ(cursor, 0u);
    EXPECT_EQ(changed_rows(state, cursor, two).value(), 2u);
    EXPECT_EQ(changed_rows(state, cursor, two).value(), 0u);
    std::uint64_t ahead = cursor + 1000;  // of some other state
    EXPECT_EQ(changed_rows(state, ahead, two).value(), 2u);
    EXPECT_EQ(ahead, cursor);
    State square = make_state(sheet_chart(9, 9));
    cursor = 0;
    EXPECT_EQ(changed_rows(square, cursor, one).value(), 1u);
}

}  // namespace
}  // namespace dgm::test
