// SPDX-License-Identifier: MIT
// libdgm/src/physics/physics.cpp
// Makes a Physics, checks the arguments of a step, and runs it. What is not in every step is cold: built small.
#include <dgm/limits.h>
#include <dgm/physics.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/physics_impl.h"

namespace dgm {
namespace detail {
namespace {
using namespace physics;

constexpr Error bad(const char* message) noexcept {
    return {ErrorCode::BadArgument, kNoOffset, message};
}
constexpr Error unsupported(const char* message) noexcept {
    return {ErrorCode::Unsupported, kNoOffset, message};
}
bool within(double v, double low, double high) noexcept {
    return v >= low && v <= high;
}
bool is_dt(float dt) noexcept {
    return within(double{dt}, 0.99e-5, 10);
}

[[gnu::cold]] Result<void> check_options(const PhysicsOptions& o) noexcept {
    constexpr const char* kFaults[] = {
        "the unit is not in 1e-9 .. 1e9 m",         "the membrane is not in 1e-6 .. 1e12 N/m",
        "Poisson's ratio is not in 0 .. 0.49",      "the bending is not in 0 .. 1e12 N m",
        "the foundation is not in 0 .. 1e12 N/m^3", "the density is not in 1e-6 .. 1e12 kg/m^2",
        "the viscosity is not in 0 .. 1e6 s"};
    const Material& m = *o.material;
    const double values[] = {o.metres_per_unit,    double{m.membrane}, double{m.poisson},  double{m.bending},
                             double{m.foundation}, double{m.density},  double{m.viscosity}};
    if (!is_valid(o.allocator)) return bad("the allocator is half empty");
    if (!is_dt(o.dt)) return bad("the time step is not in 1e-5 .. 10 s");
    if (o.solver > (kFactors ? Solver::Factors : Solver::Multigrid)) return bad("the solver is not known here");
    if (o.metres_per_unit == 0) return unsupported("the unit is not known: set metres_per_unit or bake with --unit");
    for (std::size_t k = 0; k < kMaterialValues; ++k)
        if (!within(values[k], double{kMaterialLow[k]}, double{kMaterialHigh[k]})) return bad(kFaults[k]);
    return {};
}

/// Diagonal of the rest shape's box, local units.
[[gnu::cold]] double diagonal_of(const StateImpl& s) noexcept {
    double sum = 0;
    for (const float* x : {s.rest.x, s.rest.y, s.rest.z}) {
        const auto [low, high] = std::minmax_element(x, x + s.total());
        sum += (double{*high} - double{*low}) * (double{*high} - double{*low});
    }
    return std::sqrt(sum);
}

[[gnu::cold]] Result<void> check_map(const StateImpl& s, const PhysicsOptions& o) noexcept {
    if (s.tables.free_domain) return unsupported("free domains have no physics; bake it with --domain square");
    if (!s.reversed.empty()) return unsupported("a surface with one side has no physics");
    if (s.tables.rows < 3 || s.tables.cols < 3) return unsupported("the grid has fewer than 3 x 3 samples");
    if (kFactors && o.solver == Solver::Factors && s.total() > kMostFactored)
        return Error{ErrorCode::LimitExceeded, kNoOffset, "factors are for at most 129 x 129 samples"};
    const double diagonal = diagonal_of(s) * o.metres_per_unit;
    if (!within(diagonal, 1e-6, 1e6)) return unsupported("the body's diagonal is not in 1e-6 .. 1e6 m");
    if (double{o.material->bending} > double{o.material->membrane} * diagonal * diagonal)
        return Error{ErrorCode::LimitExceeded, kNoOffset,
                     "the material bends over a length beyond the body: check unit and moduli"};
    return {};
}

/// Upper bound of what build_model() takes, measured on grids of 9 x 9 to 257 x 257.
[[gnu::cold]] std::uint64_t bytes_needed(std::uint32_t rows, std::uint32_t cols) noexcept {
    const std::uint64_t plane = plane_size(rows, cols) * sizeof(float), grid = std::uint64_t{rows} * cols;
    return 120 * plane + 1430 * grid + 65536 + PhysicsImpl::kSurfaces * sizeof(NearTiles) +
           std::uint64_t{physics::kTile} * cols * sizeof(physics::Sight);
}

void write_shape(const PhysicsImpl& p, StateImpl& s) noexcept {
    const double by = 1 / p.scale;
    float* to[3] = {s.now.x, s.now.y, s.now.z};
    const float* rest[3] = {s.rest.x, s.rest.y, s.rest.z};
    for (int c = 0; c < 3; ++c)
        for (std::uint32_t k = 0; k < p.total; ++k) to[c][k] = static_cast<float>(double{rest[c][k]} + by * p.at[c][k]);
    s.touch_all();
}

}  // namespace

[[gnu::cold]] Result<void> physics::check_tools(const StepOptions& o, std::span<const ToolInput> tools,
                                                std::size_t answers) noexcept {
    if (answers != 0 && answers < tools.size()) return bad("there are fewer answers than tools");
    if (tools.size() + o.obstacles.size() > Scene::kMost)
        return Error{ErrorCode::LimitExceeded, kNoOffset, "there are more than 64 tools and obstacles"};
    if (!tools.empty() && !(o.tool_radius > 0 && o.tool_radius <= kMaxCoordinate))
        return bad("the tools' radius is not a number above 0");
    if (o.tool_layer != 0 && !within(double{o.tool_layer}, 1, 1e12))
        return bad("the layer under tools is not 0 or in 1 .. 1e12 N/m^3");
    std::uint64_t named = 0;
    for (const ToolInput& in : tools) {
        if (!is_place(in.position)) return bad("a coordinate of a tool is beyond 1e18");
        if (in.kind > ToolKind::Grasp) return unsupported("the tool kind is not known");
        if (in.tool >= Scene::kMost) return bad("a tool's number is beyond 63");
        if ((named >> in.tool & 1) != 0) return bad("a tool is named twice");
        named |= std::uint64_t{1} << in.tool;
    }
    return {};
}

[[gnu::cold]] Result<void> physics::check_step(const PhysicsImpl& p, const StateImpl& s,
                                               const StepOptions& o) noexcept {
    if (p.rows != s.tables.rows || p.cols != s.tables.cols || p.total != s.total())
        return bad("the physics was made for a state of another size");
    if (o.cycles < 1 || o.cycles > 1000) return bad("the number of cycles is not in 1 .. 1000");
    if (kFriction && !within(double{o.friction}, 0, 100)) return bad("the friction is not in 0 .. 100");
    if (!is_finite(o.gravity) || !(dot(o.gravity, o.gravity) <= 1e12f)) return bad("gravity is not below 1e6 m/s^2");
    for (const Pin& pin : o.pins) {
        if (pin.sample >= p.total) return bad("a pin names no sample");
        if (!is_place(pin.position)) return bad("a coordinate of a pin is beyond 1e18");
    }
    return {};
}

namespace {
Result<void> make_scene(const StateImpl& s, const StepOptions& o, std::span<const ToolInput> tools,
                        Scene& scene) noexcept {
    scene.count = 0;
    for (std::uint32_t t = 0; t < Scene::kMost; ++t)  // by number: lists of contacts are sorted so
        for (const ToolInput& in : tools) {
            if (in.tool != t || in.kind == ToolKind::Grasp || !in.engaged) continue;
            add_tool(scene, in, double{o.tool_radius});
        }
    return add_obstacles(scene, o.obstacles, s);
}

template <class F>
void each_copy(const PhysicsImpl& p, std::uint32_t sample, F f) noexcept {
    for (std::uint32_t k = p.fine().sample_of[p.fine().dof_of[sample]]; k != kNone; k = p.next_copy[k]) f(k);
}

}  // namespace

bool physics::mark_pins(PhysicsImpl& p, std::span<const Pin> pins) noexcept {
    const Level& l = p.fine();
    std::size_t count = 0;
    for (; count < pins.size(); ++count) {
        const std::uint32_t d = l.dof_of[pins[count].sample];
        if (p.pinned[d] != 0) break;
        p.pinned[d] = p.free[l.sample_of[d]] == 0 ? 2 : 1;
    }
    if (count == pins.size()) return true;
    while (count-- > 0) p.pinned[l.dof_of[pins[count].sample]] = 0;
    return false;
}

void physics::hold_pins(PhysicsImpl& p, std::span<const Pin> pins) noexcept {
    for (const Pin& pin : pins) each_copy(p, pin.sample, [&](std::uint32_t k) { p.free[k] = 0; });
}

namespace {
/// Where inertia leads, where the search starts, and pins in their new places.
void begin_step(PhysicsImpl& p, const StateImpl& s, const StepOptions& o) noexcept {
    const Level& l = p.fine();
    const double dt = p.options.dt, by = p.scale;
    const float gravity[3] = {o.gravity.x, o.gravity.y, o.gravity.z};
    hold_pins(p, o.pins);
    double sum = 0, moving = 0;
    for (int c = 0; c < 3; ++c)
        for (std::uint32_t k = 0; k < p.total; ++k) {
            const double v = double{p.velocity.p[c][k]}, i = dt * (v + dt * double{gravity[c]});
            p.inertial.p[c][k] = static_cast<float>(i);
            p.delta.p[c][k] = p.free[k] * p.inertial.p[c][k];
            const double mass = double{l.own[k]} * double{p.mass[k]};
            sum += mass * i * i;
            moving += mass * v * v;
        }
    p.at_rest = 0.5 * sum / (dt * dt);
    p.elastic_before = p.elastic;
    p.energy_before = p.elastic + 0.5 * moving;
    p.driven = false;
    p.layer = double{o.tool_layer};
    if (kFriction) p.friction = double{o.friction};
    if (kFactors) p.few_held = o.pins.empty();
    for (const Pin& pin : o.pins) {
        const Double3 way = by * (widen(pin.position) - widen(StateImpl::at(s.rest, pin.sample)));
        const double to[3] = {way.x, way.y, way.z};
        each_copy(p, pin.sample, [&](std::uint32_t k) {
            for (int c = 0; c < 3; ++c) {
                p.delta.p[c][k] = static_cast<float>(to[c] - p.at[c][k]);
                p.driven = p.driven || p.delta.p[c][k] != 0;
            }
        });
    }
}

}  // namespace

void physics::release_pins(PhysicsImpl& p, std::span<const Pin> pins) noexcept {
    for (const Pin& pin : pins) {
        std::uint8_t& mark = p.pinned[p.fine().dof_of[pin.sample]];
        if (mark == 1) each_copy(p, pin.sample, [&](std::uint32_t k) { p.free[k] = 1; });
        mark = 0;
    }
}

namespace {
/// Clears what a step writes, which may not be finite: 0 times that would not be 0.
void forget(PhysicsImpl& p) noexcept {
    std::fill(p.moved.p[0], p.energy, 0.0f);
    for (std::uint32_t k = 0; k < p.solver.levels; ++k)
        std::fill(p.solver.level[k].x.p[0], p.solver.level[k].diagonal, 0.0f);
}

/// Lowers velocities so that they hold so much kinetic energy, but keeps their drift as long as that has less.
/// @return their kinetic energy
double slow_down(PhysicsImpl& p, double kinetic, double wanted) noexcept {
    Drift drift = drift_of(p, p.velocity);
    if (!(drift.energy < wanted)) drift = {};
    if (!(kinetic > drift.energy)) return kinetic;
    const double left = std::max(0.0, wanted - drift.energy), by = std::sqrt(left / (kinetic - drift.energy));
    for (int c = 0; c < 3; ++c)
        for (std::uint32_t k = 0; k < p.total; ++k) {
            const double v = double{p.velocity.p[c][k]};
            p.velocity.p[c][k] = static_cast<float>(drift.mean[c] + by * (v - drift.mean[c]));
        }
    return drift.energy + left;
}

/// Takes so much of the step's way back, which is in `before`, that energy has not risen: by halves, then all of it.
/// work: of gravity, on the whole way; most: kinetic energy of all of it
void shorten(PhysicsImpl& p, double work, double most, StepReport& report) noexcept {
    constexpr int kTries = 5;
    double by = 1;
    for (int tries = 0; tries <= kTries; ++tries) {
        const double less = tries < kTries ? 0.5 * by : by;
        by -= less;
        for (int c = 0; c < 3; ++c)
            for (std::uint32_t k = 0; k < p.total; ++k) {
                const double d = double{p.before.p[c][k]};
                p.at[c][k] -= less * d;
                p.velocity.p[c][k] = static_cast<float>(by * d / double{p.options.dt});
            }
        p.elastic = by > 0 ? evaluate(p).elastic : p.elastic_before;
        report.kinetic = by * by * most;
        const double left = p.energy_before + by * work - p.elastic;
        if (!(left >= 0)) continue;
        if (report.kinetic > left) report.kinetic = slow_down(p, report.kinetic, left);
        return;
    }
}

/// The step's displacement becomes part of the shape, or is thrown away.
void end_step(PhysicsImpl& p, const StepOptions& o, bool keep, StepReport& report) noexcept {
    const Level& l = p.fine();
    const double dt = p.options.dt;
    for (std::size_t k = 0; k < p.followers.size(); k += 2) {
        const std::uint32_t to = l.sample_of[p.followers[k]], from = p.followers[k + 1];
        for (float* f : p.delta.p) f[to] = f[from];
    }
    double kinetic = 0, work = 0;
    const float gravity[3] = {o.gravity.x, o.gravity.y, o.gravity.z};
    for (int c = 0; c < 3; ++c)
        for (std::uint32_t k = 0; k < p.total; ++k) {
            const float d = keep ? p.delta.p[c][k] : 0;
            p.at[c][k] += double{d};
            const double v = double{d} / dt, mass = double{l.own[k]} * double{p.mass[k]};
            p.velocity.p[c][k] = static_cast<float>(v);
            kinetic += mass * v * v;
            work += mass * double{gravity[c]} * double{d};
        }
    report.kinetic = kinetic / 2;
    // A search that has not converged may leave more energy than there was.
    const double most = p.energy_before + work - report.kinetic;
    const bool guarded = keep && outside(p) != Outside::Moving && (p.elastic + p.unsure > most || p.elastic < 0);
    std::swap(p.before, p.delta);
    for (float* f : p.delta.p) std::fill(f, f + l.count(), 0.0f);
    if (guarded) {
        p.elastic = evaluate(p).elastic;
        if (p.elastic > most) report.kinetic = slow_down(p, report.kinetic, report.kinetic + most - p.elastic);
        // What an impact has left in the multipliers pushes for a step or two; and a search may not have converged.
        if (p.elastic > p.energy_before + work && outside(p) == Outside::Obstacles)
            shorten(p, work, kinetic / 2, report);
    }
    report.elastic = p.elastic;
    release_pins(p, o.pins);
    if (keep) {
        keep_multipliers(p);
        if (p.stretch[0] != nullptr) {
            // The last evaluation may have been ahead of where the step ended.
            p.solver.kernels->place({l.count(), {p.at[0].data(), p.at[1].data(), p.at[2].data()}, p.delta, p.moved});
            StretchJob job{p.on(), {}};
            std::copy_n(p.stretch, 6, job.to);
            p.solver.kernels->stretches(job);
        }
    } else {
        p.touching_count = p.grasped_count = 0;
        p.holding = 0;
        p.factor.swell_age = 0;
        forget(p);
    }
}

/// What the soft layer under a sample holds when it presses with the contact's force.
double layer_energy(const Touching& t) noexcept {
    const double all = 0.5 * t.stiffness * t.blunt;  // the force when all of the cell has come to touch
    return press_of(t, t.force < all ? -t.blunt * std::sqrt(t.force / all) : -t.force / t.stiffness - 0.5 * t.blunt)
        .energy;
}

/// Sums of the multipliers, over samples.
void answer(const PhysicsImpl& p, std::span<const ToolInput> tools, std::span<StepTool> answers,
            StepReport& report) noexcept {
    const Array<Touching>& list = p.touching[p.touching_now];
    for (std::uint32_t k = 0; k < p.touching_count; ++k) {
        report.contacts += list[k].force > 0 ? 1 : 0;
        report.layers += list[k].soft() ? layer_energy(list[k]) : 0;
    }
    for (std::size_t t = 0; t < tools.size() && !answers.empty(); ++t) {
        Double3 sum;
        StepTool out;
        for (std::uint32_t k = 0; k < p.touching_count; ++k) {
            if (list[k].obstacle != tools[t].tool) continue;
            if (list[k].rubs()) sum = sum - widen(list[k].hold);
            if (!(list[k].force > 0)) continue;
            sum = sum - list[k].force * list[k].normal;
            ++out.contacts;
        }
        for (std::uint32_t k = 0; k < p.grasped_count; ++k) {
            if (p.grasped[k].tool != tools[t].tool) continue;
            sum = sum - p.grasped[k].force;
            ++out.contacts;
        }
        out.force = narrow(sum);
        answers[t] = out;
    }
}
}  // namespace
}  // namespace detail

[[gnu::cold]] StoredMaterial stored_material(const State& state) noexcept {
    const float(&m)[kMaterialValues] = state.impl()->material;
    StoredMaterial out;
    out.metres_per_unit = double{m[0]};
    if (m[5] > 0) out.material = {m[1], m[2], m[3], m[4], m[5], m[6]};
    return out;
}

[[gnu::cold]] Result<Physics> Physics::create(const State& state, const PhysicsOptions& asked) noexcept {
    const StoredMaterial stored = stored_material(state);
    PhysicsOptions options = asked;
    if (!options.material) options.material = stored.material.value_or(Material{});
    if (options.metres_per_unit == 0) options.metres_per_unit = stored.metres_per_unit;
    if (auto r = detail::check_options(options); !r) return r.error();
    const detail::StateImpl& s = *state.impl();
    if (auto r = detail::check_map(s, options); !r) return r.error();
    const std::uint64_t bytes = detail::bytes_needed(s.tables.rows, s.tables.cols);
    if (bytes > options.max_bytes) return detail::over_max_bytes();
    detail::PhysicsImpl* p = detail::create<detail::PhysicsImpl>(options.allocator, options.allocator);
    if (p == nullptr) return detail::physics::kNoMemory;
    Physics made(p);
    p->options = options;
    p->material = *options.material;
    p->rows = s.tables.rows;
    p->cols = s.tables.cols;
    p->total = s.total();
    p->scale = options.metres_per_unit;
    p->closed = !s.open_surface;
    p->solver.kernels = &detail::physics::choose_kernels(options.plain_loops);
    const double e = p->material.membrane, nu = p->material.poisson;
    p->shear = static_cast<float>(e / (2 * (1 + nu)));
    p->dilate = static_cast<float>(e * nu / (1 - nu * nu));
    if (auto r = detail::physics::build_model(*p, s); !r) return r.error();
    detail::physics::take_step_length(*p);
#ifndef DGM_NO_FACTORS
    if (options.solver == Solver::Factors)
        if (auto r = detail::physics::make_factor(*p, bytes, p->factor); !r) return r.error();
#endif
    made.reset();
    if (!p->solver.sound)
        return Error{ErrorCode::BadArgument, kNoOffset, "the matrix of material and map is not positive definite"};
    return made;
}

Physics::Physics(Physics&& other) noexcept : impl_(std::exchange(other.impl_, nullptr)) {}
Physics& Physics::operator=(Physics&& other) noexcept {
    std::swap(impl_, other.impl_);
    return *this;
}
Physics::~Physics() {
    detail::destroy(impl_);
}

[[gnu::cold]] Result<void> Physics::set_dt(float seconds) noexcept {
    if (!detail::is_dt(seconds)) return detail::bad("the time step is not in 1e-5 .. 10 s");
    if (seconds == impl_->options.dt) return {};
    impl_->options.dt = seconds;
    detail::physics::take_step_length(*impl_);
    return {};
}

[[gnu::cold]] void Physics::reset() noexcept {
    detail::PhysicsImpl& p = *impl_;
    for (int c = 0; c < 3; ++c)
        for (std::uint32_t k = 0; k < p.total; ++k) {
            p.at[c][k] = 0;
            p.velocity.p[c][k] = p.delta.p[c][k] = 0;
        }
    p.touching_count = p.grasped_count = 0;
    p.holding = 0;
    p.factor.swell_age = 0;
    p.elastic = p.pressure = 0;
    if (p.stretch[0] == nullptr) return;
    for (int k = 0; k < 6; ++k) std::fill_n(p.stretch[k], p.total, k % 3 == 1 ? 0.0f : 1.0f);
}

Result<StepReport> step(State& state, Physics& physics, const StepOptions& options, std::span<const ToolInput> tools,
                        std::span<StepTool> answers) noexcept {
    detail::PhysicsImpl& p = *physics.impl();
    detail::StateImpl& s = *state.impl();
    if (auto r = detail::physics::check_step(p, s, options); !r) return r.error();
    if (auto r = detail::physics::check_tools(options, tools, answers.size()); !r) return r.error();
    if (auto r = detail::make_scene(s, options, tools, p.scene[1 - p.touching_now]); !r) return r.error();
    if (!detail::physics::mark_pins(p, options.pins)) return detail::bad("a sample or a copy of it is pinned twice");
    detail::begin_step(p, s, options);
    if (!detail::physics::find_touching(p, s)) {
        detail::physics::release_pins(p, options.pins);
        return Error{ErrorCode::LimitExceeded, kNoOffset, "more than twice the samples are near obstacles: use fewer"};
    }
    state.release();  // touches of tick() end
    StepReport report;
    if (detail::physics::kFriction && p.friction > 0) detail::physics::let_slide(p);
    detail::physics::move_grasps(p, s, tools, options.tool_radius);
    const bool lower = p.solver.sound && detail::physics::minimise(p, options.cycles, report);
    report.clamped = !lower;
    detail::end_step(p, options, lower, report);
    detail::answer(p, tools, answers, report);
    detail::write_shape(p, s);
    return report;
}

}  // namespace dgm
