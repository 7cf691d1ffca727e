// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/dgm_target_bench.cpp
// dgm_target_bench: microseconds a tick, a deform with normals and a contact on the target it is built for, the least
// and the median of batches of 50. It needs the standard library alone, so it also runs in Node:
//   scripts/platforms --bench wasm
#include <dgm/contact.h>
#include <dgm/deform.h>
#include <dgm/tick.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <utility>
#include <vector>

#include "../unit/libdgm/exact_shapes.h"

namespace dgm::bench {
namespace {

constexpr int kBatches = 200, kBatch = 50;

/// @return the least and the median time of a call, microseconds.
template <class F>
std::pair<double, double> measure(int batches, int batch, F call) {
    using Clock = std::chrono::steady_clock;
    std::vector<double> times;
    int k = 0;
    for (int b = 0; b < batches; ++b) {
        const auto start = Clock::now();
        for (int e = 0; e < batch; ++e) call(k++);
        times.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count() / batch);
    }
    std::sort(times.begin(), times.end());
    return {times.front(), times[times.size() / 2]};
}
void print(const char* what, std::uint32_t side, std::pair<double, double> times) {
    std::printf("%-28s %4u x %-4u  %8.2f  %8.2f\n", what, side, side, times.first, times.second);
}
void check(bool ok) {
    if (!ok) std::abort();
}

void run(std::uint32_t side, bool plain) {
    test::ChartSpec chart = test::grid_chart(side, side, test::bent_sheet);
    const test::Image image = test::build({chart});
    const Asset asset = Asset::open_memory(image.bytes).value();
    StateOptions options;
    options.plain_loops = plain;
    State state = State::create(asset.chart(0).value(), options).value();
    if (side == 81) std::printf("loops %s; least and median, microseconds\n", state.loops());
    const DeformTable table = DeformTable::create({}).value();
    // Presses and slides about an eighth of a step a tick, half in and half out of contact.
    print("tick", side, measure(kBatches, kBatch, [&](int k) {
              const test::Turn a = test::turn(k / 4000.0), b = test::turn(k / 37.0);
              ToolInput in;
              const double middle = side / 2.0;
              in.position = {static_cast<float>(middle + 20 * a.cosine), static_cast<float>(middle + 20 * a.sine),
                             static_cast<float>(0.2 * b.sine)};
              ToolOutput out;
              check(tick(state, table, {}, {&in, 1}, {&out, 1}).ok());
          }));
    state.release();
    Touch touch;
    touch.sample = side / 2 * side + side / 2;
    touch.displacement = {0, 0, -1};
    touch.d_max = 1;
    print("deform, normals, release", side, measure(kBatches, kBatch, [&](int) {
              check(deform(state, table, touch).ok());
              state.update_normals();
              state.release();
          }));
    const test::Image ball =
        test::build({test::grid_chart(side, side, test::ball(side), test::octahedral_seams(side))});
    const Asset ball_asset = Asset::open_memory(ball.bytes).value();
    State closed = State::create(ball_asset.chart(0).value(), options).value();
    const ContactSolver solver = ContactSolver::create(closed).value();
    Obstacle plane;
    plane.point = {0, 0, 9.8f};
    plane.normal = {0, 0, -1};
    print("plane contact, volume kept", side, measure(10, 5, [&](int) {
              closed.release();
              check(resolve_contact(closed, solver, plane).value().status == ContactStatus::Contact);
          }));
}
}  // namespace
}  // namespace dgm::bench

int main(int argc, char**) {
    for (const std::uint32_t side : {81u, 257u}) dgm::bench::run(side, argc > 1);
    return 0;
}
