// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_calls_program.cpp
// Any calls with any options on an opened asset, in any order. After each call seam copies are equal to the bit,
// positions finite, reports within bounds; an error has changed nothing, to the bit.
#include <dgm/changed.h>
#include <dgm/collide.h>
#include <dgm/contact.h>
#include <dgm/force.h>
#include <dgm/pick.h>
#include <dgm/reconstruct.h>
#include <dgm/snapshot.h>
#include <dgm/tick.h>
#include <dgm/validate.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "call_checks.h"
#include "fuzz_calls.h"

namespace dgm::test {

namespace {

/// Finite, of any size, or now and then no number at all; around a point of the shape where sizes are real.
Vec3 random_place(Dice& dice, const State& state) {
    const Vec3 p = state.positions()[dice.below(state.sample_count())];
    const float step = state.mean_step();
    Vec3 out{p.x + step * dice.real(-2, 2), p.y + step * dice.real(-2, 2), p.z + step * dice.real(-2, 2)};
    if (dice.one_in(5)) *dice.of({&out.x, &out.y, &out.z}) = dice.size(-kMaxCoordinate, kMaxCoordinate);
    if (dice.one_in(60)) *dice.of({&out.x, &out.y, &out.z}) = dice.absurd();
    return out;
}
Vec3 random_vector(Dice& dice, float step) {
    Vec3 d{step * dice.real(-3, 3), step * dice.real(-3, 3), step * dice.real(-3, 3)};
    if (dice.one_in(8)) *dice.of({&d.x, &d.y, &d.z}) = dice.size(-kMaxCoordinate, kMaxCoordinate);
    if (dice.one_in(8))
        d = dice.of({Vec3{}, Vec3{1e-45f, 0, 0}, Vec3{kMaxCoordinate, kMaxCoordinate, -kMaxCoordinate}});
    if (dice.one_in(60)) d.y = dice.absurd();
    return d;
}
float random_length(Dice& dice, float step) {
    if (dice.one_in(60)) return dice.absurd();
    return dice.one_in(3) ? dice.size(1e-38f, 3e38f) : step * dice.real(0.01f, 4);
}
float random_step(Dice& dice) {
    if (dice.one_in(60)) return dice.absurd();
    return dice.one_in(3) ? dice.size(kMinStep, kMaxStep) : 0;
}

class Program {
 public:
    Program(Dice& dice, State& state, State& other)
        : dice_(dice),
          state_(state),
          other_(other),
          watched_(!dice.one_in(4)),
          base_(shape_of(state.rest_positions())) {
        std::vector<float> values;
        for (std::uint32_t k = dice.between(1, 3); k > 0; --k)
            if (auto table = DeformTable::create(random_kernel(dice, values)))
                tables_.push_back(std::move(table).value());
        if (auto solver = ContactSolver::create(state)) solver_.emplace(std::move(solver).value());
        SnapshotOptions options;
        options.slots = dice.between(2, 5);
        options.normals = !dice.one_in(4);
        if (auto made = Snapshots::create(state, options)) snapshots_.emplace(std::move(made).value());
    }

    void run() {
        DGM_SAY("state %u x %u, %u samples, %u classes, mean step %g\n", state_.rows(), state_.cols(),
                state_.sample_count(), state_.class_count(), state_.mean_step());
        for (std::uint32_t k = dice_.between(4, 30); k > 0; --k) {
            step();
            if (watched_ || dice_.one_in(6) || is_saying()) check_state(state_);
        }
        release();
        state_.reset();
        base_ = shape_of(state_.rest_positions());
        promise(same_bits(shape_of(state_.positions()), base_), "reset() is not the rest shape");
        check_state(state_);
    }

 private:
    void step() {
        switch (dice_.below(16)) {
            case 0:
            case 1:
            case 2:
                return touch();
            case 3:
            case 4:
            case 5:
            case 6:
                return turn();
            case 7:
            case 8:
            case 9:
                return contact();
            case 10:
                changes();
                pick();
                return search();
            case 11:
                return release();
            case 12:
                return relax();
            case 13:
                return publish();
            case 14:
                state_.update_normals();
                check_normals(state_);
                return static_cast<void>(state_.normal(dice_.below(state_.sample_count() + 2)));
            default:
                reconstruct_any(dice_, state_);
                if (!dice_.one_in(6)) return;
                state_.reset();
                base_ = shape_of(state_.rest_positions());
        }
    }

    [[nodiscard]] DeformMode mode() {
        if (dice_.one_in(60)) return static_cast<DeformMode>(9);
        return dice_.one_in(4) ? DeformMode::Plastic : DeformMode::Elastic;
    }
    [[nodiscard]] Footprint footprint() { return static_cast<Footprint>(dice_.below(dice_.one_in(30) ? 9 : 4)); }
    [[nodiscard]] const DeformTable& table() {
        return tables_[dice_.below(static_cast<std::uint32_t>(tables_.size()))];
    }
    [[nodiscard]] Shape before() const { return watched_ ? shape_of(state_.positions()) : Shape{}; }
    void check_unchanged(const Shape& before) const {
        if (watched_) promise(same_bits(before, shape_of(state_.positions())), "a call that failed changed the shape");
    }
    /// Notes the shape to which release() must return after a plastic call.
    void note_base(bool plastic) {
        if (!plastic) return;
        state_.release();
        base_ = shape_of(state_.positions());
    }

    void touch() {
        if (tables_.empty()) return;
        Touch t;
        t.sample = dice_.below(state_.sample_count() + (dice_.one_in(20) ? 3 : 0));
        t.displacement = random_vector(dice_, state_.mean_step());
        t.d_max = random_length(dice_, state_.mean_step());
        t.footprint = footprint();
        t.mode = mode();
        t.step = random_step(dice_);
        const Shape old = before();
        const DeformTable& kernel = table();
        DGM_SAY("deform sample %u d %g %g %g d_max %g footprint %u mode %u step %g reach %u\n", t.sample,
                t.displacement.x, t.displacement.y, t.displacement.z, t.d_max, static_cast<unsigned>(t.footprint),
                static_cast<unsigned>(t.mode), t.step, kernel.reach());
        const auto done = deform(state_, kernel, t);
        if (!done) return check_unchanged(old);
        const DeformReport& r = done.value();
        promise(state_.on_surface(t.sample), "a touch of no sample went well");
        promise(r.samples <= state_.sample_count(), "more samples in reach than there are");
        promise(is_finite(r.displacement) && length(r.displacement) <= t.d_max * 1.00001, "d_c is longer than d_max");
        for (std::size_t k = 0; k < old.size(); ++k) {  // weights and mobility are at most 1
            const Vec3 p = state_.positions()[k], moved = p - old[k];
            const double slack = 1e-5 * (length(r.displacement) + length(p) + length(old[k])) + 1e-44;
            promise(length(moved) <= length(r.displacement) + slack, "a sample moved farther than d_c");
        }
        note_base(t.mode == DeformMode::Plastic);
    }

    void turn() {
        if (tables_.empty()) return;
        std::vector<ToolInput> tools(dice_.below(4));
        std::vector<ToolOutput> out(dice_.one_in(10) ? 0 : tools.size());
        for (std::uint32_t k = 0; k < tools.size(); ++k)
            tools[k] = {dice_.one_in(30) ? dice_.below(70) : k,
                        static_cast<ToolKind>(dice_.below(dice_.one_in(40) ? 5 : 3)), random_place(dice_, state_),
                        !dice_.one_in(4)};
        TickOptions o;
        o.dt = dice_.one_in(4) ? dice_.size(0, 1e30f) : 1e-3f;
        o.d_max = random_length(dice_, state_.mean_step());
        o.f_max = dice_.one_in(4) ? dice_.size(0, 1e38f) : 1;
        o.relax_rate = dice_.of({std::numeric_limits<float>::infinity(), 0.0f, 3.0f, 1e-30f, 3e38f});
        o.settle_time = dice_.one_in(3) ? dice_.size(0, 1e30f) : 0.01f;
        o.grasp_distance = dice_.of({0.0f, 0.0f, 1.0f, 1e30f, std::numeric_limits<float>::infinity()});
        o.rule = dice_.of({ContactRule::Smooth, ContactRule::Smooth, ContactRule::Printed});
        o.footprint = footprint();
        o.mode = mode();
        o.step = random_step(dice_);
        o.normals = !dice_.one_in(4);
        const Shape old = before();
        const DeformTable& kernel = table();
        DGM_SAY(
            "tick of %zu, dt %g d_max %g relax %g settle %g rule %u footprint %u mode %u step %g reach %u middle %g\n",
            tools.size(), o.dt, o.d_max, o.relax_rate, o.settle_time, static_cast<unsigned>(o.rule),
            static_cast<unsigned>(o.footprint), static_cast<unsigned>(o.mode), o.step, kernel.reach(),
            kernel.profile(0));
        for (const ToolInput& t : tools)
            DGM_SAY("  tool %u kind %u at %g %g %g engaged %d\n", t.tool, static_cast<unsigned>(t.kind), t.position.x,
                    t.position.y, t.position.z, t.engaged ? 1 : 0);
        const auto done = tick(state_, kernel, o, tools, out);
        for (const ToolOutput& t : out)
            DGM_SAY("  contact %u displaced %g %g %g\n", t.contact, t.displacement.x, t.displacement.y,
                    t.displacement.z);
        if (!done && done.error().code != ErrorCode::LimitExceeded) return check_unchanged(old);
        note_base(o.mode == DeformMode::Plastic);
        if (!done) return;
        promise(done.value().contacts <= tools.size(), "more contacts than tools");
        promise(done.value().samples <= std::uint64_t{state_.sample_count()} * tools.size(), "too many samples");
        for (const ToolOutput& t : out) {
            promise(state_.on_surface(t.sample), "a tool's sample is off the surface");
            promise(t.contact == kNone || state_.on_surface(t.contact), "a contact is off the surface");
            promise(t.distance >= 0 && std::isfinite(t.distance), "a tool's distance is not finite");
            promise(is_finite(t.displacement) && length(t.displacement) <= o.d_max * 1.00001, "longer than d_max");
            promise(
                std::fabs(t.force.x) <= o.f_max && std::fabs(t.force.y) <= o.f_max && std::fabs(t.force.z) <= o.f_max,
                "a force is larger than f_max");
        }
    }

    [[nodiscard]] Obstacle random_obstacle() {
        Obstacle o;
        const float step = state_.mean_step();
        o.kind = static_cast<ObstacleKind>(dice_.below(dice_.one_in(40) ? 7 : 5));
        o.point = random_place(dice_, state_);
        o.normal = dice_.one_in(2) ? Vec3{0, 0, dice_.of({1.0f, -1.0f, 1e-30f, 1e18f})} : random_vector(dice_, 1);
        o.end = random_place(dice_, state_);
        o.radius = dice_.one_in(4) ? dice_.size(1e-30f, kMaxCoordinate) : step * dice_.real(0.1f, 5);
        o.half = {o.radius, step * dice_.real(0.1f, 5), dice_.one_in(4) ? dice_.size(1e-30f, kMaxCoordinate) : step};
        if (dice_.one_in(40)) *dice_.of({&o.radius, &o.half.y, &o.reach, &o.rotation[4]}) = dice_.absurd();
        if (dice_.one_in(2)) {
            const float a = dice_.real(-3, 3), c = std::cos(a), s = std::sin(a);
            const float turn[9] = {c, -s, 0, s, c, 0, 0, 0, 1};
            std::copy_n(turn, 9, o.rotation);
        }
        if (dice_.one_in(3)) o.reach = dice_.one_in(2) ? step : dice_.size(1e-30f, kMaxCoordinate);
        o.surface = dice_.one_in(30) ? dice_.of({&state_, static_cast<State*>(nullptr)}) : &other_;
        if (o.kind == ObstacleKind::Surface && dice_.one_in(2))
            o.point = {step * dice_.real(-1, 1), step, -0.5f * step};
        return o;
    }

    void contact() {
        if (!solver_) return;
        const Obstacle obstacle = random_obstacle();
        const Vec3 place = random_place(dice_, state_);
        DGM_SAY(
            "obstacle %u point %g %g %g normal %g %g %g end %g %g %g radius %g half %g %g %g reach %g; from %g %g %g\n",
            static_cast<unsigned>(obstacle.kind), obstacle.point.x, obstacle.point.y, obstacle.point.z,
            obstacle.normal.x, obstacle.normal.y, obstacle.normal.z, obstacle.end.x, obstacle.end.y, obstacle.end.z,
            obstacle.radius, obstacle.half.x, obstacle.half.y, obstacle.half.z, obstacle.reach, place.x, place.y,
            place.z);
        if (const auto far = obstacle_distance(obstacle, place)) {
            promise(std::isfinite(far.value().distance), "a distance from an obstacle is not finite");
            promise(is_finite(far.value().nearest), "the nearest point of an obstacle is not finite");
        }
        std::vector<RingSize> rings(dice_.one_in(3) ? dice_.between(1, 3) : 0);
        for (RingSize& r : rings)
            r = {dice_.size(0, 1e30f), dice_.size(1e-15f, kMaxCoordinate), dice_.size(1e-30f, 1e36f)};
        ContactOptions o;
        if (dice_.one_in(3)) o.max_depth = dice_.size(0, 1e30f);
        if (dice_.one_in(3)) o.max_total = dice_.size(0, 1e30f);
        o.bulge = static_cast<Bulge>(dice_.below(dice_.one_in(40) ? 5 : 3));
        o.rings = rings;
        o.mode = mode();
        o.smoothing = dice_.one_in(30) ? 65 : dice_.below(65);
        const Shape old = before(), others = shape_of(other_.positions());
        const auto done = resolve_contact(state_, *solver_, obstacle, o);
        promise(same_bits(others, shape_of(other_.positions())), "a contact moved the obstacle");
        if (!done) return check_unchanged(old);
        const ContactReport& r = done.value();
        DGM_SAY("  status %u samples %u ring %u deepest %g total %g R %g beta %g\n", static_cast<unsigned>(r.status),
                r.samples, r.ring, r.deepest, r.total, r.ring_reach, r.beta);
        if (r.status == ContactStatus::Clear || r.status == ContactStatus::Restored) check_unchanged(old);
        promise(r.samples <= state_.sample_count() && r.ring <= state_.sample_count(), "too many samples in contact");
        promise(r.deepest >= 0 && r.total >= 0 && !std::isnan(r.total), "a contact's depth is no number");
        promise(!std::isnan(solver_->volume(state_)), "the volume is no number");
        note_base(o.mode == DeformMode::Plastic);
    }

    void pick() {
        const Vec3 from = random_place(dice_, state_);
        const Vec3 to = dice_.one_in(3) ? random_vector(dice_, 1) : random_place(dice_, state_) - from;
        PickOptions o;
        if (dice_.one_in(3)) o.max_distance = random_length(dice_, state_.mean_step());
        o.back_faces = !dice_.one_in(3);
        const auto hit = pick_ray(state_, from, to, o);
        if (!hit) return;
        const RayHit& h = hit.value();
        DGM_SAY("ray from %g %g %g along %g %g %g: %g\n", from.x, from.y, from.z, to.x, to.y, to.z, h.distance);
        promise(state_.on_surface(h.sample), "a ray hit a sample off the surface");
        promise(h.distance >= 0 && h.distance <= o.max_distance && is_finite(h.point), "a ray's hit is not finite");
        promise(o.back_faces || h.front, "a ray hit a back face that was to be passed");
        for (int k = 0; k < 3; ++k)
            promise(state_.on_surface(h.corners[k]) && h.barycentric[k] >= 0 && h.barycentric[k] <= 1.001f,
                    "a ray hit beside a triangle");
    }

    /// Whatever has other bits than at the last time is in a range.
    void changes() {
        ChangedRange ranges[6];
        const std::size_t most = dice_.between(state_.sample_count() > state_.rows() * state_.cols() ? 2 : 1, 6);
        const auto count = changed_rows(state_, cursor_, {ranges, most});
        promise(count.ok() && count.value() <= most, "changes do not fit into two ranges");
        const Shape now = shape_of(state_.positions());
        std::vector<bool> told(now.size());
        for (std::size_t k = 0; k < count.value(); ++k)
            for (std::uint32_t r = 0; r < ranges[k].rows; ++r)
                for (std::uint32_t c = 0; c < ranges[k].columns; ++c) {
                    const std::uint32_t sample = ranges[k].first + r * state_.cols() + c;
                    promise(sample < now.size(), "a range of changes goes beyond the samples");
                    told[sample] = true;
                }
        for (std::size_t k = 0; k < seen_.size(); ++k)
            promise(told[k] || std::memcmp(&now[k], &seen_[k], sizeof now[k]) == 0, "a change was not told");
        seen_ = now;
    }

    /// nearest_sample() against all samples, as it rounds.
    void search() {
        const Vec3 tool = random_place(dice_, state_);
        const auto found = nearest_sample(state_, tool);
        const std::uint32_t last = dice_.below(state_.sample_count()), a = dice_.below(9);
        const auto window = track_sample(state_, tool, last, a);
        const auto sure = track_nearest(state_, tool, last, a);
        promise(window.ok() == sure.ok(), "track_sample() and track_nearest() disagree about an error");
        promise(!window || state_.on_surface(window.value().sample), "a tracked sample is off the surface");
        if (!found) return;
        promise(state_.on_surface(found.value().sample), "the nearest sample is off the surface");
        promise(!sure || sure.value().sample == found.value().sample || !std::isfinite(sure.value().distance),
                "track_nearest() is not nearest_sample()");
        float best = std::numeric_limits<float>::infinity();
        std::uint32_t nearest = kNone;
        for (std::uint32_t k = 0; k < state_.sample_count(); ++k) {
            if (!state_.on_surface(k)) continue;
            const Vec3 d = state_.positions()[k] - tool;
            const float square = d.x * d.x + d.y * d.y + d.z * d.z;
            if (!(square < best)) continue;
            best = square;
            nearest = k;
        }
        promise(nearest == kNone || nearest == found.value().sample, "nearest_sample() is not the nearest");
        const Vec3 v = random_vector(dice_, 1), n = random_vector(dice_, 1);
        static_cast<void>(hit_test(v, n).ok());
        const auto force = contact_force(v, random_length(dice_, 1), dice_.size(0, 1e38f));
        promise(!force || is_finite(force.value()), "a force is not finite");
    }

    void release() {
        state_.release();
        for (std::uint32_t k = 0; is_saying() && k < base_.size(); ++k)
            if (const Vec3 p = state_.positions()[k]; std::memcmp(&p, &base_[k], sizeof p) != 0)
                DGM_SAY("sample %u: %a %a %a is not %a %a %a\n", k, p.x, p.y, p.z, base_[k].x, base_[k].y, base_[k].z);
        promise(same_bits(shape_of(state_.positions()), base_), "release() is not the permanent shape, to the bit");
    }

    void relax() {
        const float dt = dice_.one_in(4) ? dice_.size(0, 1e38f) : 1e-2f, rate = dice_.one_in(4) ? dice_.absurd() : 2;
        const Shape old = before();
        if (!state_.relax(dt, rate)) check_unchanged(old);
    }

    void publish() {
        if (!snapshots_) return;
        promise(snapshots_->publish(state_, 7).ok(), "a snapshot was refused");
        const std::size_t count = state_.sample_count();
        std::vector<float> p(3 * count), n(3 * count);
        const auto read = snapshots_->read(p, dice_.one_in(3) ? std::span<float>(n) : std::span<float>());
        if (!read) return;
        const PointView now = state_.positions();
        promise(
            std::memcmp(p.data(), now.x, 4 * count) == 0 && std::memcmp(p.data() + 2 * count, now.z, 4 * count) == 0,
            "a snapshot is not the shape");
    }

    Dice& dice_;
    State& state_;
    State& other_;
    const bool watched_;  ///< every call is looked at; else what fades may wait
    Shape base_, seen_;
    std::uint64_t cursor_ = 0;
    std::vector<DeformTable> tables_;
    std::optional<ContactSolver> solver_;
    std::optional<Snapshots> snapshots_;
};

Result<State> random_state(Dice& dice, const Chart& chart) {
    StateOptions options;
    options.max_reach = dice.one_in(4) ? dice.between(1, 12) : 65;
    options.metric = dice.one_in(2);
    options.max_tools = dice.one_in(8) ? dice.below(65) : 4;
    options.plain_loops = dice.one_in(4);
    return State::create(chart, options);
}

/// The n-th allocation fails.
void fail_allocations(Dice& dice, const Chart& chart) {
    struct Memory {
        std::uint32_t left;
        static void* allocate(void* user, std::size_t bytes, std::size_t alignment) {
            auto& left = static_cast<Memory*>(user)->left;
            return left-- == 0 ? nullptr
                               : std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
        }
        static void release(void*, void* memory, std::size_t) { std::free(memory); }
    } memory{dice.below(60)};
    StateOptions options;
    options.allocator = {&memory, &Memory::allocate, &Memory::release};
    const auto state = State::create(chart, options);
    promise(state.ok() || state.error().code == ErrorCode::OutOfMemory, "another error than OutOfMemory");
}
}  // namespace

void call_all(Dice& dice, const Asset& asset) {
    std::vector<State> states;
    for (std::uint32_t c = 0; c < asset.chart_count(); ++c) {
        auto found = asset.chart(c);
        if (!found) continue;
        const Chart& chart = found.value();
        reconstruct_any(dice, chart);
        const bool valid = validate_chart(chart).ok();
        auto state = random_state(dice, chart);
        promise(state.ok() == valid, "validate_chart() and State::create() disagree");
        if (!valid) continue;
        if (dice.one_in(10)) fail_allocations(dice, chart);
        states.push_back(std::move(state).value());
        if (auto twin = random_state(dice, chart)) states.push_back(std::move(twin).value());
    }
    if (states.size() < 2) return;
    const auto any = [&] { return dice.below(static_cast<std::uint32_t>(states.size())); };
    for (std::uint32_t k = dice.between(1, 2); k > 0; --k) {
        const std::uint32_t one = any(), another = any();
        Program(dice, states[one], states[one == another ? (one + 1) % states.size() : another]).run();
    }
}
}  // namespace dgm::test
