// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/physics_sweep.cpp
#include "bench/physics_sweep.h"

#include <dgm/physics.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "bench/interrupt.h"
#include "bench/machine_facts.h"
#include "bench/physics_beside.h"
#include "bench/run_sweep.h"
#include "bench/runtime_error.h"
#include "files/temporary_folder.h"

namespace dgm::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kDiagonal = 0.15;  ///< metres
constexpr double kRadius = 0.1;     ///< of the ball, in diagonals
constexpr double kDepth = 0.05;     ///< of the deepest touch, in diagonals
constexpr double kPress = 0.1;      ///< seconds from the first touch to the deepest
constexpr std::uint32_t kConverged = 300;
constexpr std::uint32_t kOnTheWay = 3;  ///< cycles of the steps before the one that is looked at
constexpr std::size_t kWarmUp = 50, kLetGo = 200;
constexpr double kMoments[] = {0.001, 0.02, 0.06, 0.1};  ///< seconds of the press at which a step is looked at

using Points = std::vector<std::array<double, 3>>;

/// How a body is simulated.
struct Way {
    double metres_per_unit, dt;
    std::string solver;
};

/// A body with a ball above its highest sample.
class Poked {
 public:
    /// With a stride, physics of every stride-th sample, shown on all.
    Poked(const Subject& subject, const Way& way, std::uint32_t stride = 0) : state_(subject.state()), dt_(way.dt) {
        const Extent extent = extent_of(state_);
        top_ = extent.highest;
        diagonal_ = extent.diagonal;
        PhysicsOptions options;
        options.dt = static_cast<float>(way.dt);
        options.metres_per_unit = metres_per_unit_of(extent, way.metres_per_unit);
        options.solver = way.solver == "factors" ? Solver::Factors : Solver::Multigrid;
        if (stride != 0) make_coarse(stride);
        if (!refusal_.empty()) return;
        auto made = Physics::create(simulated(), options);
        if (made)
            physics_.emplace(std::move(made).value());
        else
            refusal_ = made.error().message;
    }
    /// Why there is no physics; empty: there is.
    [[nodiscard]] const std::string& refusal() const { return refusal_; }

    /// One step with the ball so deep, in shares of the deepest; nullopt: without it.
    StepReport go(std::optional<double> share, std::uint32_t cycles) {
        StepOptions options;
        options.cycles = cycles;
        options.tool_radius = static_cast<float>(kRadius * diagonal_);
        ToolInput ball;
        ball.position = top_;
        ball.position.z += static_cast<float>((kRadius - kDepth * share.value_or(0)) * diagonal_);
        const std::size_t tools = share ? 1 : 0;
        const StepReport report = take(step(simulated(), *physics_, options, {&ball, tools}, {&answer_, tools}));
        if (detail_) {
            const auto shown = detail_->show(*coarse_, state_);
            if (!shown) throw model::Error(model::codes::kReadFailed, shown.error().message);
        }
        return report;
    }
    /// How far each sample is from rest.
    [[nodiscard]] Points displacements() const {
        Points out = points();
        const PointView rest = state_.rest_positions();
        for (std::uint32_t k = 0; k < rest.count; ++k) {
            out[k][0] -= rest[k].x;
            out[k][1] -= rest[k].y;
            out[k][2] -= rest[k].z;
        }
        return out;
    }
    [[nodiscard]] State& simulated() { return coarse_ ? *coarse_ : state_; }
    /// The ball goes in, step by step, for so long.
    void press_for(double seconds) {
        const auto steps = static_cast<std::size_t>(std::lround(seconds / dt_));
        for (std::size_t k = 1; k < steps; ++k) (void)go(share_at(static_cast<double>(k) * dt_), kOnTheWay);
        time_ = static_cast<double>(std::max<std::size_t>(steps, 1)) * dt_;
    }
    /// The step after press_for(). @return how far each sample went
    Points next(std::uint32_t cycles, StepReport& report) {
        const Points before = points();
        report = go(share_at(time_), cycles);
        Points moved = points();
        for (std::size_t k = 0; k < moved.size(); ++k)
            for (std::size_t c = 0; c < 3; ++c) moved[k][c] -= before[k][c];
        return moved;
    }
    [[nodiscard]] static double share_at(double seconds) { return std::min(1.0, seconds / kPress); }
    [[nodiscard]] const StepTool& answer() const { return answer_; }

 private:
    [[nodiscard]] Points points() const {
        Points out;
        const PointView now = state_.positions();
        for (std::uint32_t k = 0; k < now.count; ++k) out.push_back({now[k].x, now[k].y, now[k].z});
        return out;
    }
    void make_coarse(std::uint32_t stride) {
        auto coarse = coarse_state(state_, stride);
        if (!coarse) {
            refusal_ = coarse.error().message;
            return;
        }
        coarse_.emplace(std::move(coarse).value());
        detail_.emplace(take(Detail::create(state_, *coarse_, stride)));
    }
    State state_;
    std::optional<State> coarse_;
    std::optional<Detail> detail_;
    std::optional<Physics> physics_;
    std::string refusal_;
    Vec3 top_;
    double diagonal_ = 0, dt_, time_ = 0;
    StepTool answer_;
};

double length(const Points& a) {
    double sum = 0;
    for (const auto& x : a) sum += x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
    return std::sqrt(sum);
}
Points minus(Points a, const Points& b) {
    for (std::size_t k = 0; k < a.size(); ++k)
        for (std::size_t c = 0; c < 3; ++c) a[k][c] -= b[k][c];
    return a;
}
double length(Vec3 v) {
    return std::sqrt(double{v.x} * double{v.x} + double{v.y} * double{v.y} + double{v.z} * double{v.z});
}

/// What a step of `cycles` is worth beside one that has converged, from the same states.
struct Accuracy {
    double error = 0, force_error = 0, residual = 0, volume_error = 0;
    std::uint32_t contacts = 0;
};
struct Moment {
    double seconds;
    Points converged;
    Vec3 force;
};
using Moments = std::vector<Moment>;

Moments converged_steps(const Subject& subject, const Way& way) {
    Moments out;
    for (const double seconds : kMoments) {
        Poked body(subject, way);
        body.press_for(seconds);
        StepReport report;
        Points moved = body.next(kConverged, report);
        out.push_back({seconds, std::move(moved), body.answer().force});
        stop_if_interrupted();
    }
    return out;
}

Accuracy accuracy_of(const Subject& subject, const Way& way, std::uint32_t cycles, const Moments& moments) {
    Accuracy worst;
    for (const Moment& m : moments) {
        Poked body(subject, way);
        body.press_for(m.seconds);
        StepReport report;
        const Points moved = body.next(cycles, report);
        const double far = length(m.converged), force = length(m.force);
        if (far > 0) worst.error = std::max(worst.error, length(minus(moved, m.converged)) / far);
        if (force > 0) worst.force_error = std::max(worst.force_error, length(body.answer().force - m.force) / force);
        worst.residual = std::max(worst.residual, report.residual);
        worst.volume_error = std::max(worst.volume_error, std::fabs(report.volume_error));
        worst.contacts = std::max(worst.contacts, report.contacts);
    }
    return worst;
}

/// Largest rise of kinetic plus elastic energy in a step after the ball is gone, in shares of what there was then.
double energy_rise(const Subject& subject, const Way& way, std::uint32_t cycles) {
    Poked body(subject, way);
    body.press_for(kPress);
    double first = 0, last = 0, rise = 0;
    for (std::size_t k = 0; k < kLetGo; ++k) {
        const StepReport report = body.go({}, cycles);
        const double now = report.kinetic + report.elastic;
        if (k == 0) first = now;
        if (k > 0 && first > 0) rise = std::max(rise, (now - last) / first);
        last = now;
    }
    return rise;
}

TickTimes step_times(const Subject& subject, const Way& way, std::uint32_t cycles, std::size_t steps,
                     std::uint32_t stride = 0) {
    Poked body(subject, way, stride);
    // In and out, all the time in touch.
    const auto turn = [&](std::size_t k) {
        const double t = std::fmod(static_cast<double>(k) * way.dt, 2 * kPress) / kPress;
        (void)body.go(0.1 + 0.9 * (t < 1 ? t : 2 - t), cycles);
    };
    return time_ticks(kWarmUp, steps, {}, turn);
}

Table step_table() {
    Table t;
    t.key = "physics";
    t.title = "Implicit steps";
    t.note =
        "A ball of a tenth of the diagonal is pressed into the highest sample, to half its radius within 0.1 s. Error: "
        "how far samples are after a step from where 300 cycles take them from the same state, over the way that they "
        "go in it (root mean squares), at the worst of four moments of the press. Force error: the same of the force "
        "on "
        "the ball. Residual: force left unbalanced over that at the start of the step. Energy rise: of a step after "
        "the ball is gone, at most, over the energy then. Times are those of whole calls with the ball in touch.";
    t.columns = subject_columns(
        {key_column("dt_ms", "step"), key_column("solver", "solver"), key_column("cycles", "cycles"),
         time_column("p50_us", "p50", "us"), time_column("p99_us", "p99", "us"), time_column("p999_us", "p99.9", "us"),
         exact_column("error", "error", "", Sense::kLower, 1e-3),
         exact_column("force_error", "force error", "", Sense::kLower, 1e-3),
         exact_column("residual", "residual", "", Sense::kLower, 1e-3),
         exact_column("volume_error", "volume error", "", Sense::kLower, 1),
         exact_column("energy_rise", "energy rise", "", Sense::kLower, 1),
         exact_column("contacts", "samples in touch", "", Sense::kNone), text_column("outcome", "outcome")});
    t.plots = {{"Error against time", "p50_us", "error", "grid", "asset", true},
               {"Force error against time", "p50_us", "force_error", "grid", "asset", true}};
    return t;
}

Table detail_table() {
    Table t;
    t.key = "detail";
    t.title = "Levels of detail";
    t.note =
        "The same ball, and physics of every k-th row and column, shown on all samples. Error: how far samples are at "
        "the "
        "end of the press from where physics of all samples has them, over the way that they have gone (root mean "
        "squares). Force error: the same of the force on the ball. Both have the most cycles that are measured. Times "
        "are "
        "those of whole steps with the ball in touch, and of showing them.";
    t.columns = subject_columns(
        {key_column("dt_ms", "step"), key_column("stride", "stride"), key_column("simulated", "samples"),
         time_column("p50_us", "p50", "us"), time_column("p99_us", "p99", "us"), time_column("p999_us", "p99.9", "us"),
         exact_column("error", "error", "", Sense::kLower, 1e-3),
         exact_column("force_error", "force error", "", Sense::kLower, 1e-3), text_column("outcome", "outcome")});
    t.plots = {{"Error against time", "p50_us", "error", "grid", "asset", true}};
    return t;
}

void add_detail_rows(Table& table, const Subject& subject, const PhysicsSweepOptions& options) {
    const std::uint32_t cycles = *std::max_element(options.cycles.begin(), options.cycles.end());
    for (const double ms : options.milliseconds) {
        const double dt = ms / 1000;
        const Way way{options.metres_per_unit, dt, options.solvers.front()};
        Poked full(subject, way);
        if (!full.refusal().empty()) continue;  // its row is in the other table
        const auto press = [&](Poked& body) {
            for (double t = dt; t < kPress * (1 + 1e-9); t += dt) (void)body.go(Poked::share_at(t), cycles);
            return body.displacements();
        };
        const Points wanted = press(full);
        for (const std::uint32_t stride : options.strides) {
            stop_if_interrupted();
            SubjectRow row(table, subject);
            row.set("dt_ms", fmt::format("{:g}", ms));
            row.set("stride", std::to_string(stride));
            Poked body(subject, way, stride);
            row.set("outcome", body.refusal().empty() ? std::string("solved") : body.refusal());
            if (body.refusal().empty()) {
                row.set("simulated", std::to_string(body.simulated().sample_count()));
                row.set("error", exactly(length(minus(press(body), wanted)) / length(wanted)));
                row.set("force_error",
                        exactly(length(body.answer().force - full.answer().force) / length(full.answer().force)));
                row.set_percentiles(step_times(subject, way, cycles, options.steps, stride));
            }
            table.rows.push_back(row.row());
        }
    }
}

void add_rows(Run& run, const Subject& subject, const PhysicsSweepOptions& options, const std::string& solver) {
    Table& table = run.tables.front();
    for (const double ms : options.milliseconds) {
        const Way way{options.metres_per_unit, ms / 1000, solver};
        if (const Poked body(subject, way); !body.refusal().empty()) {
            SubjectRow refused(table, subject);
            refused.set("dt_ms", fmt::format("{:g}", ms));
            refused.set("solver", solver);
            refused.set("outcome", body.refusal());
            table.rows.push_back(refused.row());
            continue;
        }
        const Moments moments = converged_steps(subject, way);
        std::uint32_t enough = 0;
        double at_enough = 0;
        for (const std::uint32_t cycles : options.cycles) {
            stop_if_interrupted();
            const Accuracy accuracy = accuracy_of(subject, way, cycles, moments);
            const TickTimes times = step_times(subject, way, cycles, options.steps);
            SubjectRow row(table, subject);
            row.set("dt_ms", fmt::format("{:g}", ms));
            row.set("solver", solver);
            row.set("cycles", std::to_string(cycles));
            row.set_percentiles(times);
            row.set("error", exactly(accuracy.error));
            row.set("force_error", exactly(accuracy.force_error));
            row.set("residual", exactly(accuracy.residual));
            row.set("volume_error", exactly(accuracy.volume_error));
            row.set("energy_rise", exactly(energy_rise(subject, way, cycles)));
            row.set("contacts", exactly(accuracy.contacts));
            row.set("outcome", std::string("solved"));
            table.rows.push_back(row.row());
            if (accuracy.error <= 0.01 && (enough == 0 || cycles < enough)) {
                enough = cycles;
                at_enough = times.p99.value;
            }
        }
        const std::string who = fmt::format("{} {}, steps of {:g} ms, {}: ", subject.asset, subject.grid, ms, solver);
        run.findings.push_back(enough == 0
                                   ? who + "none of these numbers of cycles comes within 1 % of the converged step"
                                   : who + fmt::format("{} cycles come within 1 % of the converged step, p99 {} us",
                                                       enough, three_digits(at_enough)));
    }
}

}  // namespace

Extent extent_of(const State& body) {
    const PointView rest = body.rest_positions();
    Extent out{rest[0], rest[0]};
    std::array<double, 3> low{rest[0].x, rest[0].y, rest[0].z}, high = low;
    for (std::uint32_t k = 1; k < rest.count; ++k) {
        const std::array<double, 3> x{rest[k].x, rest[k].y, rest[k].z};
        for (std::size_t c = 0; c < 3; ++c) {
            low[c] = std::min(low[c], x[c]);
            high[c] = std::max(high[c], x[c]);
        }
        if (rest[k].z < out.lowest.z) out.lowest = rest[k];
        if (rest[k].z > out.highest.z) out.highest = rest[k];
    }
    out.diagonal = std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
    return out;
}

double metres_per_unit_of(const Extent& body, double asked) {
    return asked > 0 ? asked : kDiagonal / body.diagonal;
}

Run sweep_physics(const PhysicsSweepOptions& options, bool quiet) {
    Run run;
    run.command = "physics";
    run.machine = machine_facts();
    run.tables = {step_table(), beside_table()};
    if (!options.strides.empty()) run.tables.push_back(detail_table());
    const formats::TemporaryFolder folder("dgm-bench");
    ProgressBar bar(quiet, static_cast<double>(options.assets.size() * options.sizes.size()));
    each_subject(options.assets, options.sizes, folder.path(), options.time_limit_seconds, bar,
                 [&](const Subject& subject) {
                     for (const std::string& solver : options.solvers) add_rows(run, subject, options, solver);
                     add_beside_rows(run.tables[1], subject, options);
                     if (!options.strides.empty()) add_detail_rows(run.tables.back(), subject, options);
                 });
    run.settings = {
        {"sizes", fmt::format("{}", fmt::join(options.sizes, ", "))},
        {"solvers", fmt::format("{}", fmt::join(options.solvers, ", "))},
        {"cycles", fmt::format("{}", fmt::join(options.cycles, ", "))},
        {"milliseconds a step", fmt::format("{}", fmt::join(options.milliseconds, ", "))},
        {"steps", std::to_string(options.steps)},
        {"warm-up", fmt::format("{} steps", kWarmUp)},
        {"material", "that of dgm::Material, without viscosity"},
        {"metres a unit", options.metres_per_unit > 0 ? fmt::format("{:g}", options.metres_per_unit)
                                                      : fmt::format("so that the diagonal is {:g} m", kDiagonal)},
        {"spread", "95 % interval for another run's median (Student's t on logarithms, at least 2 %)"}};
    return run;
}

}  // namespace dgm::bench
