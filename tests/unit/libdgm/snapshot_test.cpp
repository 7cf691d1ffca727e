// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/snapshot_test.cpp
// One writer and several readers. Run under the preset `tsan` this is the proof that they share nothing unguarded; run
// plainly it shows that no reader ever sees parts of two frames.
#include <gtest/gtest.h>

#include <dgm/deform.h>
#include <dgm/snapshot.h>
#include <dgm/tick.h>

#include <atomic>

#include "opened.h"
#include "platform.h"
#if DGM_TEST_THREADS
#include <thread>
#endif

namespace dgm::test {
namespace {

#if DGM_TEST_THREADS
TEST(Snapshots, ReadersSeeWholeFrames) {
    // Frame f is the sheet moved by f along z, all of it: mixed frames would show.
    State state = make_state(grid_chart(33, 35, [](double i, double j) { return Point{float(i), float(j), 0}; }));
    Snapshots shots = Snapshots::create(state, {.slots = 2}).value();
    const std::uint32_t n = state.sample_count();
    constexpr std::uint64_t kFrames = 4000;
    KernelOptions kernel;
    kernel.shape = KernelShape::User;
    const float ones[] = {1, 1};
    kernel.values = ones;
    kernel.reach = 60;
    const DeformTable table = DeformTable::create(kernel).value();
    std::atomic<bool> done{false};
    std::atomic<std::uint64_t> reads{0}, torn{0}, backwards{0}, busy{0};
    const auto reader = [&] {
        std::vector<float> p(3 * n), normals(3 * n);
        std::uint64_t last = 0;
        while (!done.load()) {
            const auto r = shots.read(p, normals);
            if (!r.ok()) {
                if (r.error().code == ErrorCode::Busy)
                    ++busy;
                else if (last != 0 || r.error().code != ErrorCode::NotFound)
                    ++torn;
                continue;
            }
            ++reads;
            const float z = static_cast<float>(r.value().frame);
            for (std::uint32_t k = 0; k < n; ++k)
                if (p[2 * n + k] != z || p[k] != static_cast<float>(k / 35) || normals[2 * n + k] != 1) {
                    ++torn;
                    break;
                }
            if (r.value().frame < last || r.value().tag != 7 * r.value().frame) ++backwards;
            last = r.value().frame;
        }
    };
    std::vector<std::thread> readers;
    for (int k = 0; k < 3; ++k) readers.emplace_back(reader);
    Touch touch;
    touch.sample = 16 * 35 + 17;
    touch.displacement = {0, 0, 1};
    touch.d_max = 1;
    touch.mode = DeformMode::Plastic;
    bool sound = true;
    for (std::uint64_t f = 1; f <= kFrames; ++f) {
        sound = sound && deform(state, table, touch).ok();
        state.update_normals();
        sound = sound && shots.publish(state, 7 * f).value() == f;
        if (f % 16 == 0) std::this_thread::yield();
    }
    while (reads == 0 && busy == 0) std::this_thread::yield();
    done = true;
    for (std::thread& t : readers) t.join();
    EXPECT_TRUE(sound);
    EXPECT_EQ(torn, 0u);
    EXPECT_EQ(backwards, 0u);
    EXPECT_GT(reads, 0u);
    std::vector<float> p(3 * n);
    const auto last = shots.read(p, {});
    ASSERT_TRUE(last.ok());
    EXPECT_EQ(last.value().frame, kFrames);
    EXPECT_EQ(p[2 * n], static_cast<float>(kFrames));
}

TEST(Snapshots, TicksWhileRenderingAndOthersTouchTheSameAsset) {
    const Opened opened(build({grid_chart(65, 65, sheet, octahedral_seams(65))}));
    const DeformTable table = DeformTable::create({}).value();
    std::atomic<bool> sound{true};
    const auto haptic = [&](int seed) {
        State state = State::create(opened.chart()).value();
        Snapshots shots = Snapshots::create(state).value();
        std::atomic<bool> done{false};
        std::thread render([&] {
            std::vector<float> p(3 * state.sample_count());
            while (!done) {
                if (!shots.read(p, {}).ok()) continue;
                for (std::uint32_t id = 0; id < state.class_count(); ++id)
                    for (const std::uint32_t copy : state.class_members(id))
                        if (std::memcmp(&p[copy], &p[state.class_members(id)[0]], 4) != 0) sound = false;
            }
        });
        for (int k = 0; k < 500; ++k) {
            ToolInput in;
            in.position = {float((k + seed) % 60), float(k * 3 % 61), -0.5f};
            ToolOutput out;
            if (!tick(state, table, {}, {&in, 1}, {&out, 1}) || !shots.publish(state)) sound = false;
        }
        done = true;
        render.join();
    };
    std::thread other(haptic, 17);
    haptic(3);
    other.join();
    EXPECT_TRUE(sound);
}
#endif

TEST(Snapshots, Refusals) {
    State state = make_state(grid_chart(9, 9, sheet)), other = make_state(grid_chart(9, 10, sheet));
    EXPECT_EQ(Snapshots::create(state, {.slots = 1}).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(Snapshots::create(state, {.slots = 17}).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(Snapshots::create(state, {.max_bytes = 1000}).error().code, ErrorCode::LimitExceeded);
    Snapshots shots = Snapshots::create(state, {.normals = false}).value();
    std::vector<float> p(3 * 81);
    EXPECT_EQ(shots.read(p, {}).error().code, ErrorCode::NotFound);
    EXPECT_EQ(shots.frame(), 0u);
    EXPECT_EQ(shots.publish(other).error().code, ErrorCode::BadArgument);
    ASSERT_TRUE(shots.publish(state, 5).ok());
    EXPECT_EQ(shots.read({p.data(), 3 * 81 - 1}, {}).error().code, ErrorCode::BufferTooSmall);
    EXPECT_EQ(shots.read({}, p).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(shots.read(p, {}).value().tag, 5u);
    for (std::uint32_t k = 0; k < 81; ++k) EXPECT_EQ(p[81 + k], state.positions()[k].y);
}

}  // namespace
}  // namespace dgm::test
