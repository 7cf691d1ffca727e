// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/physics_beside.cpp
#include "bench/physics_beside.h"

#include <dgm/physics.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "bench/interrupt.h"
#include "bench/runtime_error.h"

namespace dgm::bench {
namespace {

constexpr std::size_t kWarmUp = 50;
constexpr double kOverlap = 0.02;  ///< how far the body dips in, in heights
constexpr double kSwing = 0.01;    ///< of what goes, to both sides, in heights
constexpr double kTurn = 0.02;     ///< radians a step of that swing

enum class Beside { kNothing, kPlane, kStays, kGoes, kIsWritten };
constexpr struct {
    Beside what;
    const char* name;
} kAll[] = {{Beside::kNothing, "nothing"},
            {Beside::kPlane, "a plane"},
            {Beside::kStays, "a surface"},
            {Beside::kGoes, "a surface that goes"},
            {Beside::kIsWritten, "a surface that is written"}};

/// A body, and what is above it and dips into it.
class Pair {
 public:
    Pair(const Subject& subject, const PhysicsSweepOptions& sweep, Beside what)
        : body_(subject.state()), other_(subject.state()), what_(what) {
        const Extent extent = extent_of(body_);
        PhysicsOptions options;
        options.dt = static_cast<float>(sweep.milliseconds.front() / 1000);
        options.metres_per_unit = metres_per_unit_of(extent, sweep.metres_per_unit);
        if (auto made = Physics::create(body_, options)) physics_.emplace(std::move(made).value());
        height_ = double{extent.highest.z} - double{extent.lowest.z};
        const auto dip = static_cast<float>(kOverlap * height_);
        if (what == Beside::kPlane) {
            thing_.point.z = extent.highest.z - dip;
            thing_.normal = {0, 0, -1};
        } else {
            thing_.kind = ObstacleKind::Surface;
            thing_.surface = &other_;
            thing_.point = extent.highest - extent.lowest;
            thing_.point.z -= dip;
        }
        start_ = thing_.point.x;
    }
    [[nodiscard]] bool has_physics() const { return physics_.has_value(); }
    void prepare(std::size_t k) {
        const double way = kSwing * height_ * std::sin(kTurn * static_cast<double>(k));
        if (what_ == Beside::kGoes) thing_.point.x = start_ + static_cast<float>(way);
        if (what_ == Beside::kIsWritten) other_.reset();
    }
    StepReport go() {
        StepOptions how;
        how.cycles = 1;
        how.obstacles = {&thing_, what_ == Beside::kNothing ? std::size_t{0} : std::size_t{1}};
        return take(step(body_, *physics_, how));
    }

 private:
    State body_, other_;
    Beside what_;
    std::optional<Physics> physics_;
    Obstacle thing_;
    double height_ = 0;
    float start_ = 0;
};

}  // namespace

Table beside_table() {
    Table t;
    t.key = "beside";
    t.title = "Implicit steps beside other bodies";
    t.note =
        "Steps of one cycle of a body whose top dips by 2 % of its height into a plane, or into a body of the same "
        "shape that stays, goes to and fro by 1 % of the height, or is written anew before each step, as one that is "
        "simulated itself.";
    t.columns = subject_columns({key_column("beside", "beside"), time_column("p50_us", "p50", "us"),
                                 time_column("p99_us", "p99", "us"), time_column("p999_us", "p99.9", "us"),
                                 exact_column("contacts", "samples in touch", "", Sense::kNone)});
    return t;
}

void add_beside_rows(Table& table, const Subject& subject, const PhysicsSweepOptions& options) {
    for (const auto& [what, name] : kAll) {
        stop_if_interrupted();
        Pair pair(subject, options, what);
        if (!pair.has_physics()) return;
        std::uint32_t most = 0;
        const TickTimes times = time_ticks(
            kWarmUp, options.steps, [&](std::size_t k) { pair.prepare(k); },
            [&](std::size_t) { most = std::max(most, pair.go().contacts); });
        SubjectRow row(table, subject);
        row.set("beside", std::string(name));
        row.set_percentiles(times);
        row.set("contacts", exactly(most));
        table.rows.push_back(row.row());
    }
}

}  // namespace dgm::bench
