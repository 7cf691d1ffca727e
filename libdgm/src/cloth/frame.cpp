// SPDX-License-Identifier: MIT
// libdgm/src/cloth/frame.cpp
// Advances a cloth by one frame.
//
// A substep of length h begins where samples would be without new forces: x + h v, and h^2 g further as far as they
// fell
// in the substep before. At rest that is x itself, so that a cloth whose forces balance does not move, however rough
// the solver. From there Newton's method goes one step; if that leads uphill, less of it.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "cloth/cloth_impl.h"
#include "cloth/frame.h"
#include "contact/surface_search.h"

namespace dgm::detail::cloth {
namespace {

/// What stays the same in a frame.
struct Frame {
    const ClothStep& o;
    std::span<const ToolInput> tools;
    std::span<StepTool> answers;
    double h;
    std::uint32_t levels;
    StateImpl& state;
    const Obstacle& itself;
};

template <class F>
void each_sample(const ClothImpl& c, F f) noexcept {
    for (std::uint32_t i = 0; i < c.rows; ++i) {
        const Spot row = i * static_cast<Spot>(c.level[0].on.pitch);
        for (std::uint32_t j = 0; j < c.cols; ++j) f(row + j);
    }
}

/// Puts pins and grasped samples where they are asked to be. `share`: of what is left of the frame.
void move_held(ClothImpl& c, const Frame& f, double share) noexcept {
    Level& l = c.fine();
    const auto put_at = [&](std::uint32_t sample, Double3 to) {
        const Double3 way = share * (to - c.place(c.spot_of(sample)));
        each_copy(c, sample, [&](std::uint32_t s) {
            const Spot k = c.spot_of(s);
            l.at[0][k] += way.x;
            l.at[1][k] += way.y;
            l.at[2][k] += way.z;
        });
    };
    for (std::uint32_t k = 0; k < c.held_count; ++k)
        put_at(c.held[k].sample, c.held[k].offset + c.scale * widen(f.tools[c.held[k].tool & 0xffff].position));
    for (const Pin& pin : f.o.pins) put_at(pin.sample, c.scale * widen(pin.position));
}

/// Puts samples where the solution starts, and notes where they were. @return inertial part of the potential there
double begin(ClothImpl& c, const Frame& f, double share) noexcept {
    Level& l = c.fine();
    const Vec3 g = f.o.gravity;
    const double sum = c.kernels->start({l.count,
                                         {l.at[0], l.at[1], l.at[2]},
                                         {c.was[0], c.was[1], c.was[2]},
                                         c.velocity,
                                         c.inertial,
                                         c.fall,
                                         l.free,
                                         l.on.mass,
                                         f.h,
                                         {double{g.x}, double{g.y}, double{g.z}}});
    move_held(c, f, share);
    return sum / (2 * f.h * f.h);
}

/// Starts nearer to where samples were: `part` of the way is taken back.
void step_back(ClothImpl& c, double part) noexcept {
    Level& l = c.fine();
    for (int d = 0; d < 3; ++d)
        each_sample(c, [&](Spot k) {
            const double less = part * double{l.free[k]} * (l.at[d][k] - c.was[d][k]);
            l.at[d][k] -= less;
            c.inertial.p[d][k] -= static_cast<float>(less);
        });
}

/// Goes where the solution leads, or as far as that lowers the potential. @return elastic energy there
double go(ClothImpl& c, double before, double by_dt2, double elastic) noexcept {
    Level& l = c.fine();
    constexpr int kMost = 8;
    // Edges ahead are rounded to floats: that changes the energy by strain times modulus times the change of strain, by
    // chance in each quad. Where a step gains less, its energy cannot tell, and the solution's slope leads down.
    constexpr double kRounding = 1.2e-7;
    const double unsure = kRounding * std::sqrt(2 * std::fabs(elastic) * c.stiff / c.total);
    double by = 1, now = 0, inertia = 0;
    int k = 0;
    for (; k < kMost; ++k, by *= 0.5) {
        now = energy_ahead(c, by, inertia);
        const double all = now + 0.5 * by_dt2 * inertia + pressed_energy(c, by);
        if (all <= before + 1e-7 * std::fabs(before) + unsure) break;
    }
    if (k == kMost) {
        by = 0;
        now = elastic;
    }
    c.led *= by;
    if (c.led != 0) c.kernels->move({l.count, {l.at[0], l.at[1], l.at[2]}, c.lead, c.led});
    return now;
}

/// Velocities from the way gone, and the share of gravity that samples followed.
void end(ClothImpl& c, const Frame& f) noexcept {
    Level& l = c.fine();
    const Double3 g = widen(f.o.gravity);
    const double square = dot(g, g), by = square > 0 ? 1 / (f.h * square) : 0;
    FinishJob job{l.count,
                  {l.at[0], l.at[1], l.at[2]},
                  {c.was[0], c.was[1], c.was[2]},
                  c.velocity,
                  c.fall,
                  l.on.mass,
                  1 / f.h,
                  1 / (1 + f.h * double{c.options.fabric.damping}),
                  {by * g.x, by * g.y, by * g.z},
                  0,
                  {}};
    c.kernels->finish(job);
    c.kinetic = job.kinetic;
    std::copy_n(job.moment, 3, c.moment);
}

/// Of gravity, J.
double potential_of(const ClothImpl& c, Vec3 g) noexcept {
    return -(double{g.x} * c.moment[0] + double{g.y} * c.moment[1] + double{g.z} * c.moment[2]);
}

void write_shape(const ClothImpl& c, StateImpl& s) noexcept {
    const Level& l = c.fine();
    c.kernels->shape(
        {c.rows, c.cols, l.on.pitch, {l.at[0], l.at[1], l.at[2]}, {s.now.x, s.now.y, s.now.z}, 1 / c.scale});
    s.touch_all();
}

double largest_speed(const ClothImpl& c) noexcept {
    double most = 0;
    each_sample(c, [&](Spot k) {
        const Double3 v = at(c.velocity, k);
        most = std::max(most, dot(v, v));
    });
    return std::sqrt(most);
}

/// Lists which parts of the cloth may meet in a substep.
void look_around(ClothImpl& c, const Frame& f) noexcept {
    write_shape(c, f.state);
    static_cast<void>(make_shape(f.itself));  // brings the boxes of the state up to date
    const double speed = largest_speed(c) + f.h * std::sqrt(double{dot(f.o.gravity, f.o.gravity)});
    const double most = double{c.options.thickness} + 2 * c.mean_step;
    find_meetings(c, f.state, std::min(most, double{c.options.thickness} + 2 * f.h * speed));
}

/// Obstacles have gone by no more than so many metres; infinity: by nobody knows how many.
void note_way(ClothImpl& c, double most) noexcept {
    if (std::isfinite(most))
        c.scene_way += most;
    else
        ++c.scene_number;
}

/// Puts the scene where it is at the end of a substep.
void move_scene(ClothImpl& c, std::uint32_t number, std::uint32_t substeps) noexcept {
    FrameScene& scene = c.scene;
    double most = 0;
    for (std::uint32_t k = 0; k < scene.count; ++k) {
        if (!scene.moves[k]) continue;
        scene.last[k] = scene.here[k];
        scene.here[k] = between(scene.from[k], scene.shapes[k], double(number + 1) / substeps);
        scene.here[k].share = 1.0 / substeps;
        scene.here[k].ahead = 1 - double(number + 1) / substeps;
        const double way = c.scale * longest_way(scene.last[k], scene.here[k]) + (1 + 1e-9) * scene.way[k] / substeps;
        most = std::max(most, way);
    }
    note_way(c, most);
}

/// One substep. @return false: numbers that are not finite
bool advance(ClothImpl& c, const Frame& f, std::uint32_t number, ClothReport& report) noexcept {
    const auto by_dt2 = static_cast<float>(1 / (f.h * f.h));
    move_scene(c, number, f.o.substeps);
    if (c.options.self_contact) look_around(c, f);
    const double unmoved = c.elastic + begin(c, f, 1.0 / (f.o.substeps - number));
    double elastic = 0, before = 0;
    // Inertia may lead uphill, as from a stretched shape into its mirror image.
    constexpr int kMost = 3;
    for (int k = 0; k <= kMost; ++k) {
        double inertia = 0;
        elastic = evaluate(c, by_dt2, &inertia);
        before = elastic + 0.5 * double{by_dt2} * inertia;
        if (k == kMost || !(before > unmoved * (1 + 1e-6) + 1e-30)) break;
        step_back(c, k + 1 < kMost ? 0.5 : 1);
    }
    sum_classes(c.fine(), c.gradient.p);
    find_contacts(c, f.h, double{f.o.friction});
    before += press(c);
    if (!std::isfinite(before)) return false;
    report.residual = solve(c, by_dt2, f.levels, f.o.cycles);
    c.elastic = go(c, before, double{by_dt2}, elastic);
    end_contacts(c, f.answers, double{f.o.friction}, 1.0 / f.o.substeps);
    push_out(c);
    if (c.options.self_contact) {
        report.touches = keep_apart(c, double{f.o.friction});
        if (report.touches != 0) push_out(c);
    }
    end(c, f);
    return std::isfinite(c.elastic) && std::isfinite(c.kinetic);
}

/// Begins and ends grasps.
void take_hold(ClothImpl& c, const Frame& f) noexcept {
    std::uint64_t wanted = 0;
    for (const ToolInput& t : f.tools)
        if (t.kind == ToolKind::Grasp && t.engaged) wanted |= std::uint64_t{1} << t.tool;
    std::uint32_t kept = 0;
    for (std::uint32_t k = 0; k < c.held_count; ++k) {
        Held h = c.held[k];
        const std::uint32_t number = h.tool >> 16;
        if ((wanted >> number & 1) == 0) continue;
        for (std::uint32_t t = 0; t < f.tools.size(); ++t)
            if (f.tools[t].tool == number) h.tool = number << 16 | t;
        c.held[kept++] = h;
    }
    c.held_count = kept;
    for (std::uint32_t t = 0; t < f.tools.size(); ++t) {
        const std::uint64_t bit = std::uint64_t{1} << f.tools[t].tool;
        if ((wanted & bit) == 0 || (c.holding & bit) != 0) continue;
        const Double3 tool = c.scale * widen(f.tools[t].position);
        Double3 middle;
        double best = 1e300;
        each_sample(c, [&](Spot k) {
            const Double3 way = c.place(k) - tool;
            if (dot(way, way) < best) {
                best = dot(way, way);
                middle = c.place(k);
            }
        });
        const double radius = c.scale * double{f.o.tool_radius};
        if (!(best <= 4 * radius * radius)) {
            wanted &= ~bit;  // too far away: it may begin later
            continue;
        }
        for (std::uint32_t k = 0; k < c.total; ++k) {
            const Spot s = c.spot_of(k);
            const Double3 way = c.place(s) - middle;
            if (c.fine().own[s] == 0 || c.mobile[s] == 0 || c.pinned[k] != 0 || dot(way, way) > radius * radius)
                continue;
            each_copy(c, k, [&](std::uint32_t copy) { c.pinned[copy] = 2; });
            c.held[c.held_count++] = {s, k, f.tools[t].tool << 16 | t, c.place(s) - tool};
        }
    }
    c.holding = wanted;
}

/// Which samples are held in this frame.
void mark_free(ClothImpl& c) noexcept {
    if (!c.held_anew && std::memcmp(c.pinned.data(), c.was_pinned.data(), c.total) == 0) return;
    std::memcpy(c.was_pinned.data(), c.pinned.data(), c.total);
    c.held_anew = true;
    for (std::uint32_t i = 0; i < c.rows; ++i) {
        const Spot row = i * static_cast<Spot>(c.fine().on.pitch);
        for (std::uint32_t j = 0; j < c.cols; ++j)
            c.fine().free[row + j] = c.pinned[i * c.cols + j] != 0 ? 0.0f : c.mobile[row + j];
    }
}

/// Puts the scene where it was in the frame before.
/// @return true if obstacles are there still, and tools stay where they were
bool start_scene(ClothImpl& c) noexcept {
    FrameScene& scene = c.scene;
    bool still = scene.count == c.before_scene.count;
    double most = still ? 0 : kInfinity;
    std::uint32_t surfaces = 0;
    for (std::uint32_t k = 0; k < scene.count; ++k) {
        if (scene.shapes[k].kind == ObstacleKind::Surface && surfaces < c.near_tiles.size()) {
            NearTiles& tiles = c.near_tiles[surfaces++];
            tiles.listed = tiles.wanted = false;
            scene.shapes[k].near = &tiles;
        }
        const bool stays = has_stayed(c.before_scene, scene, k);
        if (scene.tool[k] == kNone) scene.from[k] = last_of(c.before_scene, scene, k);
        scene.moves[k] = !stays;
        scene.way[k] = stays ? 0 : c.scale * farthest_way(scene.shapes[k]);
        scene.last[k] = scene.here[k] = stays ? scene.shapes[k] : scene.from[k];
        scene.here[k].near = scene.shapes[k].near;
        still = still && stays;
        if (stays) continue;
        // A tool may start with another radius than it ended with.
        const double jump = has_kept_shape(c.before_scene, scene, k)
                                ? c.scale * longest_way(last_of(c.before_scene, scene, k), scene.here[k])
                                : kInfinity;
        most = std::max(most, jump);
    }
    note_way(c, most);
    return still;
}
/// Nothing does work on the cloth in this frame but gravity.
bool is_left_alone(ClothImpl& c, const ClothStep& o) noexcept {
    bool alone = start_scene(c) && c.held_count == 0;
    for (const Pin& pin : o.pins) {
        const Double3 way = c.place(c.spot_of(pin.sample)) - c.scale * widen(pin.position);
        alone =
            alone && dot(way, way) <= 1e-24 * (1 + dot(c.place(c.spot_of(pin.sample)), c.place(c.spot_of(pin.sample))));
    }
    return alone;
}

}  // namespace

void place_at(ClothImpl& c, const ConstPlanes& shape) noexcept {
    const float* from[3] = {shape.x, shape.y, shape.z};
    for (std::uint32_t k = 0; k < c.total; ++k) {
        const Spot to = c.spot_of(k);
        for (int d = 0; d < 3; ++d) {
            c.fine().at[d][to] = c.scale * double{from[d][k]};
            c.velocity.p[d][to] = 0;
        }
        c.fall[to] = 1;
        c.pressed[to] = 0;
    }
    std::fill(c.rubs.begin(), c.rubs.end(), Rub{});
    c.highest = c.first_bound;
    c.held_count = 0;
    c.holding = c.known = 0;
    c.elastic = evaluate(c);
    for (int d = 0; d < 3; ++d) std::copy(c.fine().at[d], c.fine().at[d] + c.fine().count, c.was[d]);
    c.kinetic = 0;
    for (int d = 0; d < 3; ++d) {
        c.moment[d] = 0;
        each_sample(c, [&](Spot k) { c.moment[d] += double{c.fine().on.mass[k]} * c.fine().at[d][k]; });
    }
}

ClothReport run_frame(ClothImpl& c, State& state, const ClothStep& o, std::span<const ToolInput> tools,
                      std::span<StepTool> answers) noexcept {
    const std::uint32_t levels = o.levels == 0 ? c.levels : std::min(o.levels, c.levels);
    StateImpl& s = *state.impl();
    Obstacle itself;
    itself.kind = ObstacleKind::Surface;
    itself.surface = &state;
    const Frame f{o, tools, answers, double{o.dt} / o.substeps, levels, s, itself};
    for (StepTool& a : answers) a = {};
    ClothReport report;
    take_hold(c, f);
    for (std::uint32_t k = 0; k < c.held_count; ++k)
        each_copy(c, c.held[k].sample, [&](std::uint32_t copy) { c.pinned[copy] = 2; });
    mark_free(c);
    const bool alone = is_left_alone(c, o);
    const double energy = c.kinetic + c.elastic + potential_of(c, o.gravity);
    for (std::uint32_t k = 0; k < o.substeps; ++k)
        if (!advance(c, f, k, report)) {
            for (int d = 0; d < 3; ++d) {
                std::copy(c.was[d], c.was[d] + c.fine().count, c.fine().at[d]);
                std::fill(c.velocity.p[d], c.velocity.p[d] + c.fine().count, 0.0f);
            }
            end(c, f);
            report.clamped = true;
            c.elastic = evaluate(c);
            note_way(c, kInfinity);  // obstacles go on without the cloth
            break;
        }
    report.kinetic = c.kinetic;
    report.elastic = c.elastic;
    report.potential = potential_of(c, o.gravity);
    const double gained = report.kinetic + report.elastic + report.potential - energy;
    if (alone && gained > 0 && report.kinetic > 0) {
        const double by = std::sqrt(std::max(0.0, 1 - gained / report.kinetic));
        const Level& l = c.fine();  // what is held does not move
        c.kernels->add({l.count, static_cast<float>(by), 0, c.velocity, c.velocity, c.velocity, l.free});
        report.kinetic *= by * by;
        c.kinetic = report.kinetic;
    }
    for (std::uint32_t k = 0; k < c.contact_count; ++k)
        report.contacts += c.pressed[c.spot_of(c.contacts[k].sample)] > 0 ? 1 : 0;
    std::fill(c.pinned.begin(), c.pinned.end(), std::uint8_t{0});
    c.known = 0;
    for (const ToolInput& t : tools) {
        c.tool_before[t.tool] = t.position;
        c.known |= std::uint64_t{1} << t.tool;
    }
    c.before_scene = static_cast<const Scene&>(c.scene);
    write_shape(c, s);
    return report;
}

}  // namespace dgm::detail::cloth
