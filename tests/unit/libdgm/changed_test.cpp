// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/changed_test.cpp
// changed_rows() and read_changed(): a reader that copies only what is reported must hold, to the bit, what the state
// holds, whatever was done to it; and where nothing was done there is nothing to copy.
#include <gtest/gtest.h>

#include <dgm/changed.h>
#include <dgm/collide.h>
#include <dgm/contact.h>
#include <dgm/deform.h>
#include <dgm/dgm.h>
#include <dgm/pick.h>
#include <dgm/snapshot.h>
#include <dgm/tick.h>

#include <atomic>
#include <limits>
#include <optional>
#include <random>
#include <thread>

#include "contact_shapes.h"
#include "opened.h"

namespace dgm::test {
namespace {

constexpr float kAtOnce = std::numeric_limits<float>::infinity();

DeformTable table_of(std::uint32_t reach) {
    KernelOptions kernel;
    kernel.reach = reach;
    kernel.sigma = static_cast<float>(reach);
    return DeformTable::create(kernel).value();
}

/// Positions and normals of all samples, as one list of six planes.
std::vector<float> shape_of(const State& state) {
    std::vector<float> all;
    for (const PointView& v : {state.positions(), state.normals()})
        for (const float* plane : {v.x, v.y, v.z}) all.insert(all.end(), plane, plane + v.count);
    return all;
}
bool same(const std::vector<float>& a, const std::vector<float>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

/// Marks the samples of ranges. @return false if one is out of bounds or a rectangle runs into the next row.
bool cover(const State& state, std::span<const ChangedRange> ranges, std::vector<char>& covered) {
    covered.assign(state.sample_count(), 0);
    const std::size_t grid = std::size_t{state.rows()} * state.cols();
    for (const ChangedRange& r : ranges) {
        if (r.columns == 0 || r.rows == 0) return false;
        if (r.first < grid ? r.first % state.cols() + r.columns > state.cols() : r.rows != 1) return false;
        if (r.first < grid && r.first / state.cols() + r.rows > state.rows()) return false;
        for (std::size_t i = 0; i < r.rows; ++i)
            for (std::size_t c = 0; c < r.columns; ++c) {
                const std::size_t k = r.first + i * state.cols() + c;
                if (k >= covered.size()) return false;
                covered[k] = 1;
            }
    }
    return true;
}

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

struct Life {
    State state;
    const DeformTable table = table_of(6), small = table_of(2);
    std::optional<ContactSolver> solver;
    std::mt19937 random;
    float size = 1;
    Life(const ChartSpec& chart, unsigned seed) : state(make_state(chart)), random(seed) {
        solver.emplace(std::move(ContactSolver::create(state)).value());
        size = state.mean_step();
    }
    std::uint32_t sample() {
        for (;;) {
            const auto k = static_cast<std::uint32_t>(random() % state.sample_count());
            if (state.on_surface(k)) return k;
        }
    }
    Vec3 some(float scale) {
        std::uniform_real_distribution<float> u(-scale, scale);
        const float x = u(random), y = u(random), z = u(random);
        return {x, y, z};
    }
    void touch() {
        Touch t;
        t.sample = sample();
        t.displacement = some(size);
        t.d_max = 2 * size;
        t.mode = random() % 4 == 0 ? DeformMode::Plastic : DeformMode::Elastic;
        t.footprint = random() % 4 == 0 ? Footprint::Geodesic : Footprint::Grid;
        ASSERT_TRUE(deform(state, random() % 2 == 0 ? table : small, t).ok());
    }
    void ticks() {
        TickOptions o;
        o.d_max = 2 * size;
        const float rates[] = {kAtOnce, 20, 0, 3000};
        o.relax_rate = rates[random() % 4];
        o.mode = random() % 5 == 0 ? DeformMode::Plastic : DeformMode::Elastic;
        o.footprint = random() % 4 == 0 ? Footprint::Geodesic : Footprint::Grid;
        o.normals = random() % 4 != 0;
        ToolInput in[2];
        in[1].tool = 1;
        for (ToolInput& t : in) {
            const std::uint32_t k = sample();
            t.position = state.positions()[k] - (size / 2) * state.normal(k);
            t.engaged = random() % 4 != 0;
        }
        const auto turns = random() % 6;
        for (unsigned k = 0; k < turns; ++k) {
            in[0].position = in[0].position + some(size / 4);
            ASSERT_TRUE(tick(state, table, o, {in, 1 + random() % 2}, {}).ok());
        }
    }
    void press() {
        Obstacle obstacle;
        const std::uint32_t k = sample();
        obstacle.kind = random() % 2 == 0 ? ObstacleKind::Plane : ObstacleKind::Sphere;
        const Vec3 n = state.normal(k);
        if (n == Vec3{}) return;
        obstacle.normal = n;
        obstacle.point = state.positions()[k] - (size / 2) * n;
        obstacle.radius = 2 * size;
        if (obstacle.kind == ObstacleKind::Plane) obstacle.normal = Vec3{} - n;
        ContactOptions o;
        o.mode = random() % 4 == 0 ? DeformMode::Plastic : DeformMode::Elastic;
        static_cast<void>(resolve_contact(state, *solver, obstacle, o).ok());
    }
    void step() {
        switch (random() % 12) {
            case 0:
            case 1:
            case 2:
                return touch();
            case 3:
            case 4:
            case 5:
                return ticks();
            case 6:
                return state.release();
            case 7:
                ASSERT_TRUE(state.relax(0.01f, random() % 3 == 0 ? kAtOnce : 10).ok());
                return;
            case 8:
                return press();
            case 9:
                if (random() % 4 == 0) state.reset();
                return;
            default:
                return state.update_normals();
        }
    }
};

ChartSpec sheet_chart(std::uint32_t m, std::uint32_t n) {
    return grid_chart(m, n, test::sheet);
}
/// Opposite border samples of the strip's sides j = 0.5 and j = n - 1.5 are the same place.
ChartSpec free_tube(std::uint32_t m, std::uint32_t n) {
    const auto round = [n](double i, double j) {
        const double a = 2 * 3.14159265358979 * (j - 0.5) / (n - 2);
        return Point{static_cast<float>(5 * std::cos(a)), static_cast<float>(5 * std::sin(a)), static_cast<float>(i)};
    };
    SeamPairs pairs;
    const std::uint32_t first = m * n, down = m - 1, across = n - 2, up = first + down + across + 1;
    for (std::uint32_t k = 0; k <= down; ++k) pairs.push_back({first + k, up + down - k});
    return free_chart(m, n, round, pairs);
}
std::vector<ChartSpec> all_charts() {
    return {sheet_chart(41, 35), grid_chart(33, 41, test::sheet, tube_seams(33, 41)),
            sphere_chart(33),    free_chart(27, 34, test::sheet),
            free_tube(26, 22),   sheet_chart(5, 3)};
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
        ASSERT_EQ(ranges[0].rows, 23u);  // b - 1 = 10 to each side, and one more for the normals
        ASSERT_LE(ranges[0].columns, 32u);
        reader.copy = shape_of(state);
    }
    // 23 columns need 24 or 32; corners of the window have weights too small to move a float.
    EXPECT_LT(worst, 32.0 / 23 * 1.25);
    RecordProperty("worst_ratio_percent", static_cast<int>(100 * worst));
}

TEST(Changed, ManyTicksUnread) {
    // A tool that crosses the sheet slantwise, nobody looking: its path, not the box around it.
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

// --- Snapshots --------------------------------------------------------------------------------------------------

struct SnapshotReader {
    std::vector<float> positions, normals;
    std::uint64_t frame = 0;
    explicit SnapshotReader(const State& s) : positions(3 * s.sample_count(), 7e7f), normals(positions) {}
    std::size_t read(const Snapshots& shots, std::span<ChangedRange> ranges) {
        const auto done = shots.read_changed(positions, normals, frame, ranges);
        EXPECT_TRUE(done.ok());
        if (!done) return 0;
        frame = done.value().info.frame;
        return done.value().ranges;
    }
    void expect_newest(const Snapshots& shots) {
        std::vector<float> p(positions.size()), n(p.size());
        ASSERT_EQ(shots.read(p, n).value().frame, frame);
        ASSERT_TRUE(same(p, positions));
        ASSERT_TRUE(same(n, normals));
    }
};

TEST(Changed, SnapshotReadersHoldTheNewestFrame) {
    unsigned seed = 31;
    for (const ChartSpec& chart : all_charts()) {
        Life life(chart, seed++);
        Snapshots shots = Snapshots::create(life.state).value();
        SnapshotReader often(life.state), seldom(life.state), idle(life.state);
        ChangedRange ranges[300], two[2];
        for (int step = 0; step < 300; ++step) {
            life.step();
            ASSERT_TRUE(shots.publish(life.state).ok());
            const std::vector<float> before = often.positions;
            const std::size_t count = often.read(shots, ranges);
            std::vector<char> in;
            ASSERT_TRUE(cover(life.state, {ranges, count}, in));
            for (std::size_t k = 0; k < before.size(); ++k) {
                ASSERT_TRUE(in[k % life.state.sample_count()] != 0 ||
                            std::memcmp(&before[k], &often.positions[k], 4) == 0);
            }
            often.expect_newest(shots);
            if (life.random() % 9 == 0) {
                seldom.read(shots, two);
                seldom.expect_newest(shots);
            }
            if (::testing::Test::HasFatalFailure()) FAIL() << "step " << step;
        }
        ASSERT_TRUE(shots.publish(life.state).ok());
        idle.read(shots, two);
        idle.expect_newest(shots);
        for (int k = 0; k < 5; ++k) {  // frames in which nothing moved
            ASSERT_TRUE(shots.publish(life.state).ok());
            often.read(shots, ranges);
            EXPECT_EQ(k == 0 ? 0 : idle.read(shots, two), 0u);
        }
        EXPECT_EQ(idle.read(shots, two), 0u);
    }
}

TEST(Changed, SnapshotsOfSeveralStates) {
    const ChartSpec chart = sheet_chart(33, 30);
    Life first(chart, 1), second(chart, 2);
    std::vector<Snapshots> shots;
    for (int k = 0; k < 6; ++k) shots.push_back(Snapshots::create(first.state).value());
    std::vector<SnapshotReader> readers(shots.size(), SnapshotReader(first.state));
    std::mt19937 random(3);
    ChangedRange ranges[32];
    for (int step = 0; step < 400; ++step) {
        Life& life = random() % 3 == 0 ? second : first;
        life.step();
        const std::size_t k = random() % shots.size();
        ASSERT_TRUE(shots[k].publish(life.state).ok());
        readers[k].read(shots[k], ranges);
        readers[k].expect_newest(shots[k]);
        // A new state or new snapshots, often in the place that another has just left.
        if (random() % 20 == 0) first.state = make_state(chart);
        if (random() % 20 == 0) {
            shots[k] = Snapshots::create(first.state).value();
            readers[k] = SnapshotReader(first.state);
        }
        if (::testing::Test::HasFatalFailure()) FAIL() << "step " << step;
    }
}

TEST(Changed, OvertakenReadersStillHoldWholeFrames) {
    // Frame f moved the sheet to height f, but only every third frame moves all of it: the others its middle.
    State state = make_state(grid_chart(65, 67, [](double i, double j) { return Point{float(i), float(j), 0}; }));
    Snapshots shots = Snapshots::create(state, {.slots = 2}).value();
    KernelOptions kernel;
    kernel.shape = KernelShape::User;
    const float ones[] = {1, 1};
    kernel.values = ones;
    kernel.reach = 3;
    const DeformTable table = DeformTable::create(kernel).value();
    std::atomic<bool> done{false};
    std::atomic<long> reads{0}, wrong{0};
    const auto reader = [&] {
        SnapshotReader mine(state);
        ChangedRange ranges[8];
        while (!done.load()) {
            const auto r = shots.read_changed(mine.positions, mine.normals, mine.frame, ranges);
            if (!r.ok()) {
                mine.frame = 0;
                continue;
            }
            mine.frame = r.value().info.frame;
            // Touch t of the frame moved 5 x 5 samples around place t % 97 by 1, and every frame has one touch more.
            double sum = 0;
            const float* z = mine.positions.data() + std::size_t{2} * 65 * 67;
            for (std::size_t k = 0; k < 65 * 67; ++k) sum += double{z[k]};
            wrong += sum == 25.0 * static_cast<double>(mine.frame) ? 0 : 1;
            ++reads;
        }
    };
    std::vector<std::thread> readers;
    for (int k = 0; k < 2; ++k) readers.emplace_back(reader);
    bool sound = true;
    for (std::uint32_t t = 1; t <= 4000 || reads < 100; ++t) {
        Touch touch;
        touch.sample = (5 + t % 50) * 67 + 5 + t * 7 % 50;
        touch.displacement = {0, 0, 1};
        touch.d_max = 1;
        touch.mode = DeformMode::Plastic;
        sound = sound && deform(state, table, touch).ok();
        state.update_normals();
        sound = sound && shots.publish(state).ok();
        if (t % 4 == 0) std::this_thread::yield();
    }
    done = true;
    for (std::thread& t : readers) t.join();
    EXPECT_TRUE(sound);
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(reads, 0);
}

TEST(Changed, SnapshotRefusals) {
    State state = make_state(free_chart(27, 34, test::sheet));
    Snapshots shots = Snapshots::create(state, {.normals = false}).value();
    SnapshotReader reader(state);
    ChangedRange two[2];
    const auto code = [&](std::span<float> p, std::span<float> n, std::span<ChangedRange> r) {
        return shots.read_changed(p, n, 0, r).error().code;
    };
    EXPECT_EQ(code(reader.positions, {}, two), ErrorCode::NotFound);
    ASSERT_TRUE(shots.publish(state).ok());
    EXPECT_EQ(code(reader.positions, reader.normals, two), ErrorCode::BadArgument);
    EXPECT_EQ(code({reader.positions.data(), 5}, {}, two), ErrorCode::BufferTooSmall);
    EXPECT_EQ(code(reader.positions, {}, {two, 1}), ErrorCode::BufferTooSmall);
    EXPECT_EQ(shots.read_changed(reader.positions, {}, 99, two).value().ranges, 2u);  // no such frame yet: all
    EXPECT_EQ(shots.read_changed({}, {}, 1, two).value().ranges, 0u);
    // As many samples, another grid.
    EXPECT_EQ(shots.publish(make_state(sheet_chart(2, state.sample_count() / 2))).error().code, ErrorCode::BadArgument);
}

TEST(Changed, CInterface) {
    const ChartSpec chart = free_chart(27, 34, test::sheet);
    const Bytes bytes = build({chart}).bytes;
    dgm_asset* asset = nullptr;
    dgm_state* state = nullptr;
    dgm_table* table = nullptr;
    dgm_snapshots* shots = nullptr;
    ASSERT_EQ(dgm_asset_open_memory(bytes.data(), bytes.size(), nullptr, nullptr, &asset, nullptr), DGM_OK);
    ASSERT_EQ(dgm_state_create(asset, 0, nullptr, nullptr, &state, nullptr), DGM_OK);
    ASSERT_EQ(dgm_snapshots_create(state, nullptr, nullptr, &shots, nullptr), DGM_OK);
    dgm_kernel_options kernel{};
    kernel.struct_size = sizeof kernel;
    kernel.reach = 3;
    kernel.sigma = 4;
    ASSERT_EQ(dgm_table_create(&kernel, nullptr, &table, nullptr), DGM_OK);
    dgm_changed_range ranges[4] = {};
    ranges[0].struct_size = sizeof ranges[0];
    std::uint64_t cursor = 0;
    std::size_t count = 9;
    ASSERT_EQ(dgm_state_changed_rows(state, &cursor, ranges, 4, &count, nullptr), DGM_OK);
    ASSERT_EQ(count, 2u);
    EXPECT_EQ(ranges[0].rows, 27u);
    EXPECT_EQ(ranges[0].columns, 34u);
    EXPECT_EQ(ranges[1].first, 27u * 34);
    EXPECT_EQ(ranges[1].columns, chart.border_samples);
    EXPECT_EQ(ranges[1].struct_size, sizeof ranges[0]);
    std::vector<float> p(3 * dgm_state_sample_count(state)), n(p.size());
    dgm_snapshot_info info{};
    info.struct_size = sizeof info;
    ASSERT_EQ(dgm_snapshots_publish(shots, state, 5, nullptr, nullptr), DGM_OK);
    ASSERT_EQ(dgm_snapshots_read_changed(shots, p.data(), n.data(), p.size(), 0, ranges, 4, &count, &info, nullptr),
              DGM_OK);
    EXPECT_EQ(count, 2u);
    EXPECT_EQ(info.frame, 1u);
    EXPECT_EQ(info.tag, 5u);

    ASSERT_EQ(dgm_state_changed_rows(state, &cursor, ranges, 4, &count, nullptr), DGM_OK);
    EXPECT_EQ(count, 0u);
    dgm_touch touch{};
    touch.struct_size = sizeof touch;
    touch.sample = 13 * 34 + 17;
    touch.displacement[2] = 0.5f;
    touch.d_max = 1;
    ASSERT_EQ(dgm_deform(state, table, &touch, nullptr, nullptr), DGM_OK);
    dgm_state_update_normals(state);
    ASSERT_EQ(dgm_state_changed_rows(state, &cursor, ranges, 4, &count, nullptr), DGM_OK);
    ASSERT_EQ(count, 1u);
    EXPECT_LE(ranges[0].first, 10u * 34 + 14);  // window of 2 to each side and the normals' ring
    EXPECT_LE(ranges[0].rows, 8u + 8);
    ASSERT_EQ(dgm_snapshots_publish(shots, state, 6, nullptr, nullptr), DGM_OK);
    ASSERT_EQ(dgm_snapshots_read_changed(shots, p.data(), n.data(), p.size(), 1, ranges, 4, &count, &info, nullptr),
              DGM_OK);
    EXPECT_EQ(count, 1u);
    const float* planes[3];
    const std::size_t total = dgm_state_positions(state, planes);
    for (std::size_t k = 0; k < total; ++k) ASSERT_EQ(p[2 * total + k], planes[2][k]);

    const auto changed = [&](const dgm_state* s, std::uint64_t* c, dgm_changed_range* r, std::size_t room,
                             std::size_t* to) { return dgm_state_changed_rows(s, c, r, room, to, nullptr); };
    EXPECT_EQ(changed(nullptr, &cursor, ranges, 4, &count), DGM_BAD_ARGUMENT);
    EXPECT_EQ(changed(state, nullptr, ranges, 4, &count), DGM_BAD_ARGUMENT);
    EXPECT_EQ(changed(state, &cursor, nullptr, 4, &count), DGM_BAD_ARGUMENT);
    EXPECT_EQ(changed(state, &cursor, ranges, 4, nullptr), DGM_BAD_ARGUMENT);
    EXPECT_EQ(changed(state, &cursor, ranges, 0, &count), DGM_BUFFER_TOO_SMALL);
    EXPECT_EQ(changed(state, &cursor, ranges, 1, &count), DGM_BUFFER_TOO_SMALL);
    ranges[0].struct_size = 0;
    EXPECT_EQ(changed(state, &cursor, ranges, 4, &count), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_snapshots_read_changed(nullptr, p.data(), n.data(), p.size(), 0, ranges, 4, &count, &info, nullptr),
              DGM_BAD_ARGUMENT);
    dgm_snapshots_destroy(shots);
    dgm_table_destroy(table);
    dgm_state_destroy(state);
    dgm_asset_close(asset);
}

}  // namespace
}  // namespace dgm::test
