// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/encoder_test.cpp
// Places behind quantised readings: how far off, and how even.
#include <dgm/encoder.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace dgm {
namespace {

constexpr double kQuantum = 30e-6, kTick = 1e-3;

Vec3 read(double x) {
    const auto r = static_cast<float>(kQuantum * std::floor(x / kQuantum + 0.5));
    return {r, -r, 0};
}
/// How a track of `place(t)` goes, in its first axis.
struct Course {
    double off = 0;    ///< farthest from the place, m
    double blow = 0;   ///< largest change of its speed in a tick, m/s
    double reads = 0;  ///< the same of the readings
};
template <class F>
Course follow(F place, double from, double to) {
    EncoderTrack track(static_cast<float>(kQuantum));
    Course out;
    double x[3] = {}, r[3] = {};
    for (int k = 0; k * kTick < to; ++k) {
        const double now = place(k * kTick);
        const Vec3 at = track.follow(read(now));
        EXPECT_EQ(at.y, -at.x);
        EXPECT_EQ(at.z, 0.0f);
        for (int c = 2; c > 0; --c) x[c] = x[c - 1], r[c] = r[c - 1];
        x[0] = double{at.x};
        r[0] = double{read(now).x};
        if (k * kTick < from || k < 3) continue;
        out.off = std::max(out.off, std::fabs(x[0] - now));
        out.blow = std::max(out.blow, std::fabs(x[0] - 2 * x[1] + x[2]) / kTick);
        out.reads = std::max(out.reads, std::fabs(r[0] - 2 * r[1] + r[2]) / kTick);
    }
    return out;
}

TEST(EncoderTrack, EvenMotionHasNoLag) {
    for (const double speed : {0.0, 0.001, 0.01, 0.07, 0.31, -0.05}) {
        const Course c = follow([&](double t) { return speed * t; }, 0.3, 1);
        const bool slow = std::fabs(speed) < 0.3 * kQuantum / kTick;
        EXPECT_LE(c.off, (slow ? 1 : 0.51) * kQuantum) << speed;
        EXPECT_LE(c.blow, 0.2 * kQuantum / kTick) << speed;
        EXPECT_GE(c.reads, speed != 0 ? 0.99 * kQuantum / kTick : 0) << speed;
    }
}

TEST(EncoderTrack, LagsBehindAccelerationAsItSays) {
    for (const double a : {0.5, 1.0, 3.0}) {
        const double most = 16 * a * kTick * kTick + 1.0 * kQuantum;  // half a quantum of the reading is on top
        const Course c = follow([&](double t) { return 0.5 * a * t * t; }, 0.1, 0.5);
        EXPECT_LE(c.off, most + 1e-7) << a;
    }
    // A hand that goes to and fro by 10 mm twice in a second: 1.6 m/s^2.
    const auto hand = [](double t) { return 0.01 * std::cos(2 * std::numbers::pi * 2 * t); };
    const Course c = follow(hand, 0, 3);
    EXPECT_LE(c.off, 16 * 1.6 * kTick * kTick + kQuantum);
    EXPECT_LE(c.blow, 0.3 * c.reads);
}

TEST(EncoderTrack, FollowsAtOnceWhatIsFarAway) {
    EncoderTrack track(1);
    for (int k = 0; k < 10; ++k) EXPECT_EQ(track.follow({0, 0, 0}), Vec3{});
    EXPECT_EQ(track.follow({100, 0, 0}), (Vec3{100, 0, 0}));
    EXPECT_EQ(track.follow({100, 0, 0}), (Vec3{100, 0, 0})) << "without the speed of the leap";
    EXPECT_TRUE(std::isnan(track.follow({std::numeric_limits<float>::quiet_NaN(), 0, 0}).x));
    EXPECT_EQ(track.follow({5, 6, 7}), (Vec3{5, 6, 7}));
    EncoderTrack exact(0);
    EXPECT_EQ(exact.follow({0.1f, 0, 0}), (Vec3{0.1f, 0, 0}));
    EXPECT_EQ(exact.follow({0.2f, 0, 0}), (Vec3{0.2f, 0, 0}));
}

}  // namespace
}  // namespace dgm
