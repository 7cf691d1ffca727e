// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/changed_snapshot_test.cpp
// Snapshots::read_changed(): what a reader holds is the newest frame, whichever frame it held before. And the C
// interface of both.
#include <gtest/gtest.h>

#include <dgm/dgm.h>
#include <dgm/snapshot.h>

#include "changed_life.h"
#include "platform.h"
#if DGM_TEST_THREADS
#include <atomic>
#include <thread>
#endif

namespace dgm::test {
namespace {

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

#if DGM_TEST_THREADS
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
#endif

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
