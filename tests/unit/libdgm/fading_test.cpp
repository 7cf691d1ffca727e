// SPDX-License-Identifier: GPL-3.0-or-later
// Elastic touches that fade, beside a slow model in double that fades every sample in every tick.
#include <gtest/gtest.h>

#include <dgm/collide.h>
#include <dgm/deform.h>
#include <dgm/snapshot.h>
#include <dgm/tick.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "opened.h"

namespace dgm::test {
namespace {

Point sheet(double i, double j) {
    return {static_cast<float>(i), static_cast<float>(j), static_cast<float>(1.5 * std::sin(i / 5) * std::cos(j / 6))};
}
Point flat(double i, double j) {
    return {static_cast<float>(i), static_cast<float>(j), 0};
}
/// A grid's coordinates reach 41: the last place of a float is 3.8e-6 there. A sample under a tool is rounded in each
/// of the 1 / (1 - f) ticks that its displacement lasts, f >= 0.98.
constexpr double kTolerance = 1e-4;

struct Double3 {
    double x = 0, y = 0, z = 0;
};

/// Permanent shape and elastic displacement of every sample. Weights come from deform() on a state of its own.
class Model {
 public:
    explicit Model(const ChartSpec& chart) : probe_(make_state(chart)), elastic_(probe_.sample_count()) {
        for (std::uint32_t k = 0; k < probe_.sample_count(); ++k) {
            const Vec3 p = probe_.rest_positions()[k];
            base_.push_back({p.x, p.y, p.z});
        }
    }
    void fade(double factor) {
        const double still = 1e-6 * static_cast<double>(probe_.mean_step());
        for (Double3& e : elastic_) {
            e = {e.x * factor, e.y * factor, e.z * factor};
            if (std::max({std::fabs(e.x), std::fabs(e.y), std::fabs(e.z)}) <= still) e = {};
        }
    }
    void add(const DeformTable& table, Footprint footprint, std::uint32_t sample, const Double3& d, bool plastic) {
        const std::vector<double> w = weights(table, footprint, sample);
        for (std::size_t k = 0; k < w.size(); ++k) {
            Double3& to = plastic ? base_[k] : elastic_[k];
            to = {to.x + w[k] * d.x, to.y + w[k] * d.y, to.z + w[k] * d.z};
        }
    }
    /// The contact is displaced by d in all.
    void press(const DeformTable& table, Footprint footprint, std::uint32_t sample, Vec3 d) {
        const Double3 e = elastic_[sample];
        add(table, footprint, sample, {d.x - e.x, d.y - e.y, d.z - e.z}, false);
    }
    [[nodiscard]] Double3 at(std::size_t k) const {
        return {base_[k].x + elastic_[k].x, base_[k].y + elastic_[k].y, base_[k].z + elastic_[k].z};
    }
    [[nodiscard]] std::uint32_t displaced(double by) const {
        std::uint32_t count = 0;
        for (const Double3& e : elastic_) count += std::max({std::fabs(e.x), std::fabs(e.y), std::fabs(e.z)}) > by;
        return count;
    }

 private:
    std::vector<double> weights(const DeformTable& table, Footprint footprint, std::uint32_t sample) {
        probe_.reset();
        Touch touch;
        touch.sample = sample;
        touch.displacement = {0, 0, 1024};
        touch.d_max = 1024;
        touch.footprint = footprint;
        EXPECT_TRUE(deform(probe_, table, touch).ok());
        const PointView now = probe_.positions(), rest = probe_.rest_positions();
        std::vector<double> w;
        for (std::uint32_t k = 0; k < probe_.sample_count(); ++k) w.push_back((double{now.z[k]} - rest.z[k]) / 1024);
        return w;
    }
    State probe_;
    std::vector<Double3> base_, elastic_;
};

void expect_shape(State& state, const Model& model) {
    const PointView p = state.positions();
    for (std::uint32_t k = 0; k < state.sample_count(); ++k) {
        const Double3 want = model.at(k);
        ASSERT_NEAR(double{p.x[k]}, want.x, kTolerance) << k;
        ASSERT_NEAR(double{p.y[k]}, want.y, kTolerance) << k;
        ASSERT_NEAR(double{p.z[k]}, want.z, kTolerance) << k;
    }
    for (std::uint32_t id = 0; id < state.class_count(); ++id)
        for (const std::uint32_t copy : state.class_members(id)) {
            ASSERT_TRUE(same_bits(p[copy], p[state.class_members(id)[0]])) << id;
        }
}

/// Incremental is full, to the bit: normal() computes from the positions alone.
void expect_normals(const State& state) {
    const PointView n = state.normals();
    for (std::uint32_t k = 0; k < state.sample_count(); ++k) ASSERT_TRUE(same_bits(n[k], state.normal(k))) << k;
}

void expect_nearest(State& state, Vec3 tool) {
    const Nearest found = nearest_sample(state, tool).value();
    float best = std::numeric_limits<float>::infinity();
    for (std::uint32_t k = 0; k < state.sample_count(); ++k) {
        if (!state.on_surface(k)) continue;
        const Vec3 v = state.positions()[k] - tool;
        best = std::min(best, v.x * v.x + v.y * v.y + v.z * v.z);
    }
    ASSERT_EQ(found.distance, std::sqrt(best));
}

void expect_snapshot(Snapshots& shots, const State& state) {
    std::vector<float> p(3 * std::size_t{state.sample_count()}), n(p.size());
    ASSERT_TRUE(shots.publish(state, 1).ok());
    ASSERT_TRUE(shots.read(p, n).ok());
    const std::size_t total = state.sample_count();
    for (std::size_t k = 0; k < total; ++k) {
        ASSERT_TRUE(same_bits({p[k], p[total + k], p[2 * total + k]}, state.positions()[k])) << k;
        ASSERT_TRUE(same_bits({n[k], n[total + k], n[2 * total + k]}, state.normals()[k])) << k;
    }
}

DeformTable table_of(std::uint32_t reach) {
    KernelOptions kernel;
    kernel.reach = reach;
    kernel.sigma = static_cast<float>(reach) * 1.3f;
    return DeformTable::create(kernel).value();
}

/// Two states live the same life: `seldom` is read now and then, `often` after every step.
void live(const ChartSpec& chart, Footprint footprint, unsigned seed, bool plain_loops = false) {
    StateOptions options;
    options.plain_loops = plain_loops;
    const Opened opened(build({chart}));
    State seldom = State::create(opened.chart(), options).value(), often = State::create(opened.chart()).value();
    Snapshots shots = Snapshots::create(seldom).value();
    Model model(chart);
    const DeformTable table = table_of(6);
    std::mt19937 random(seed);
    const auto number = [&](double low, double high) {
        return static_cast<float>(low + (high - low) * static_cast<double>(random() % 10000) / 10000);
    };
    TickOptions o;
    o.d_max = 2;
    o.settle_time = 0;
    o.footprint = footprint;
    Vec3 tool[2] = {};
    for (int round = 0; round < 500; ++round) {
        if (round % 40 == 0)
            for (Vec3& t : tool) t = {number(0, 40), number(0, 40), 0};
        o.dt = round % 7 == 0 ? 0.004f : 0.001f;
        o.relax_rate = number(20, 60);
        o.normals = round / 50 % 4 != 3;
        ToolInput in[2];
        ToolOutput out[2], same[2];
        for (std::uint32_t t = 0; t < 2; ++t) {
            tool[t] = tool[t] + Vec3{number(-1, 1), number(-1, 1), 0};
            in[t].tool = t;
            in[t].position = {tool[t].x, tool[t].y, number(-2.2, 1.7)};
        }
        const std::size_t tools = random() % 3;
        ASSERT_TRUE(tick(seldom, table, o, {in, tools}, out).ok());
        ASSERT_TRUE(tick(often, table, o, {in, tools}, same).ok());
        model.fade(std::exp(-double{o.relax_rate} * o.dt));
        for (std::size_t t = 0; t < tools; ++t) {
            ASSERT_EQ(out[t].contact, same[t].contact);
            if (out[t].contact != kNone && out[t].displacement != Vec3{})
                model.press(table, footprint, out[t].contact, out[t].displacement);
        }
        if (o.normals) expect_normals(often);
        if (round % 90 == 50) {  // normals() stay as the tick left them
            for (State* s : {&seldom, &often}) ASSERT_TRUE(s->relax(0.003f, 40).ok());
            model.fade(std::exp(-double{40} * 0.003f));
        }
        if (round % 60 == 33) {
            Touch touch;
            touch.sample = tools > 0 ? out[0].sample : 20 * 41 + 20;
            touch.displacement = {0.05f, 0, 0.1f};
            touch.footprint = Footprint::Grid;
            touch.d_max = 1;
            touch.mode = DeformMode::Plastic;
            if (seldom.on_surface(touch.sample)) {
                for (State* s : {&seldom, &often}) ASSERT_TRUE(deform(*s, table, touch).ok());
                model.add(table, Footprint::Grid, touch.sample, {0.05f, 0, 0.1f}, true);
            }
        }
        if (::testing::Test::HasFatalFailure()) return;
        const unsigned look = random() % 40;
        if (look < 2) expect_shape(seldom, model);
        if (look == 3 && o.normals && round % 90 != 50 && round % 60 != 33) expect_normals(seldom);
        if (look == 4) expect_nearest(seldom, tool[0]);
        if (look == 5) expect_snapshot(shots, seldom);
        if (look == 6) { ASSERT_GE(seldom.usage().active_samples, model.displaced(kTolerance)); }
        if (look == 7) {
            for (std::uint32_t k = 0; k < seldom.sample_count(); ++k) {
                const Vec3 d = seldom.normals()[k] - often.normals()[k];
                ASSERT_LT(std::sqrt(dot(d, d)), 5e-4f) << k << ' ' << round;
            }
        }
        expect_shape(often, model);
        if (::testing::Test::HasFatalFailure()) {
            ADD_FAILURE() << "round " << round;
            return;
        }
    }
    // A surface that is not touched any more comes to rest and is forgotten, without any reader.
    for (int k = 0; k < 3000; ++k) ASSERT_TRUE(tick(seldom, table, o, {}, {}).ok());
    EXPECT_EQ(seldom.usage().active_samples, 0u);
    for (int k = 0; k < 3000; ++k) model.fade(std::exp(-double{o.relax_rate} * o.dt));
    EXPECT_EQ(model.displaced(0), 0u);
    expect_shape(seldom, model);
}

TEST(Fading, OpenSheet) {
    live(grid_chart(41, 41, sheet), Footprint::Grid, 1);
    live(grid_chart(41, 41, sheet), Footprint::Grid, 2, true);
    live(grid_chart(41, 41, sheet), Footprint::Geodesic, 3);
}
TEST(Fading, Seams) {
    live(grid_chart(41, 41, sheet, octahedral_seams(41)), Footprint::Grid, 4);
    live(grid_chart(41, 37, flat, tube_seams(41, 37)), Footprint::Grid, 5);
    live(grid_chart(41, 37, flat, tube_seams(41, 37)), Footprint::Geodesic, 6);
}
TEST(Fading, FreeBorder) {
    live(free_chart(41, 41, sheet), Footprint::Grid, 7);
    live(free_chart(41, 41, sheet), Footprint::Geodesic, 8);
}

TEST(Fading, AHugeStepDoesNotStopTheClock) {
    State state = make_state(grid_chart(33, 33, flat));
    const DeformTable table = table_of(5);
    Touch touch;
    touch.displacement = {0, 0, 1};
    touch.d_max = 1;
    for (const std::uint32_t sample : {8u * 33 + 8, 24u * 33 + 24}) {
        touch.sample = sample;
        ASSERT_TRUE(deform(state, table, touch).ok());
        ASSERT_TRUE(state.relax(0.1f, 10).ok());
        EXPECT_NEAR(double{state.positions().z[sample]}, std::exp(-1.0), 1e-6);
        ASSERT_TRUE(state.relax(1e30f, 1e30f).ok());
        EXPECT_EQ(state.positions().z[sample], 0.0f);
        ASSERT_TRUE(deform(state, table, touch).ok());
        ASSERT_TRUE(state.relax(1e8f, 1e-30f).ok());
        EXPECT_EQ(state.positions().z[sample], 1.0f);
        ASSERT_TRUE(state.relax(0.01f, 10).ok());
        EXPECT_NEAR(double{state.positions().z[sample]}, std::exp(-0.1), 1e-6);
    }
}

TEST(Fading, EndsWhereRoundingWouldHoldItBack) {
    // At 4096 a float's last place is 4.9e-4: less than half of it is asked for in a tick.
    const ChartSpec chart = grid_chart(17, 17, [](double i, double j) {
        return Point{static_cast<float>(4096 + i), static_cast<float>(4096 + j), 4096};
    });
    for (const bool plain : {true, false}) {
        StateOptions options;
        options.plain_loops = plain;
        State state = State::create(Opened(build({chart})).chart(), options).value();
        Touch touch;
        touch.sample = 8 * 17 + 8;
        touch.displacement = {0.01f, -0.01f, 0.25f};
        touch.d_max = 1;
        const DeformTable table = table_of(5);
        ASSERT_TRUE(deform(state, table, touch).ok());
        float before = state.positions().z[touch.sample];
        int steps = 0;
        for (; steps < 2000 && state.usage().active_samples != 0; ++steps) {
            ASSERT_TRUE(state.relax(0.001f, 10).ok());
            const float now = state.positions().z[touch.sample];
            ASSERT_LE(now, before);
            before = now;
        }
        EXPECT_LT(steps, 2000);
        for (std::uint32_t k = 0; k < 17 * 17; ++k)
            ASSERT_TRUE(same_bits(state.positions()[k], state.rest_positions()[k])) << k;
    }
}

}  // namespace
}  // namespace dgm::test
