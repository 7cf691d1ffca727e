// SPDX-License-Identifier: MIT
// libdgm/src/physics/touching.cpp
// Contacts of a step: which samples may touch, and how firmly they are held.
#include <algorithm>
#include <cmath>

#include "physics/physics_impl.h"

namespace dgm::detail::physics {
namespace {

/// Share of a contact's stiffness that goes into the matrix: that holds a sample in all directions, a contact in one.
/// Conjugate gradients find the few directions with more; what a patch of contacts may do along the surface is smooth,
/// and too stiff a matrix hides it (docs/physics.md).
constexpr float kHeldInMatrix = 0.1f;
/// Factors are used while fewer than one in so many unknowns are held: they do not know of it.
constexpr std::uint32_t kFew = 16;

/// Place of a sample before the step, local units.
Double3 place(const PhysicsImpl& p, const StateImpl& s, std::uint32_t k) noexcept {
    const double by = 1 / p.scale;
    return {double{s.rest.x[k]} + by * p.at[0][k], double{s.rest.y[k]} + by * p.at[1][k],
            double{s.rest.z[k]} + by * p.at[2][k]};
}

/// Contacts of the step before: both lists are sorted by obstacle, then sample.
class Remembered {
 public:
    Remembered(const Array<Touching>& list, std::uint32_t count) noexcept : list_(list), count_(count) {}
    const Touching* of(std::uint32_t obstacle, std::uint32_t sample) const noexcept {
        const auto before = [&](const Touching& t, int) {
            return t.obstacle != obstacle ? t.obstacle < obstacle : t.sample < sample;
        };
        const Touching* at = std::lower_bound(list_.begin(), list_.begin() + count_, 0, before);
        const bool found = at != list_.begin() + count_ && at->obstacle == obstacle && at->sample == sample;
        return found ? at : nullptr;
    }

 private:
    const Array<Touching>& list_;
    std::uint32_t count_;
};

Tile tile_of(const PhysicsImpl& p, const StateImpl& s, std::uint32_t i0, std::uint32_t j0) noexcept {
    Tile out;
    for (std::uint32_t i = i0; i < std::min(i0 + kTile, p.rows); ++i)
        for (std::uint32_t j = j0; j < std::min(j0 + kTile, p.cols); ++j) {
            const Double3 x = place(p, s, i * p.cols + j);
            out.low = least(out.low, x);
            out.high = greatest(out.high, x);
        }
    return out;
}

/// Boxes of all tiles before the step. @return that of the body
Tile take_tiles(PhysicsImpl& p, const StateImpl& s) noexcept {
    Tile all;
    Tile* to = p.tiles.data();
    for (std::uint32_t i0 = 0; i0 < p.rows; i0 += kTile)
        for (std::uint32_t j0 = 0; j0 < p.cols; j0 += kTile) {
            *to = tile_of(p, s, i0, j0);
            all.low = least(all.low, to->low);
            all.high = greatest(all.high, to->high);
            ++to;
        }
    return all;
}

/// Notes of tiles about one obstacle.
struct Notes {
    Surroundings* tiles = nullptr;  ///< null: none are kept
    double way = 0;                 ///< SurfaceSeen::way
};

/// Looks at one obstacle from all samples, a row of tiles at a time: what is near a tile serves all its samples, and
/// distances change by no more than the way gone.
class Lookout {
 public:
    Lookout(PhysicsImpl& p, const StateImpl& s, const Shape& shape, double reach, Notes notes) noexcept
        : p_(p), s_(s), shape_(shape), reach_(reach), notes_(notes) {}
    /// Whether some of the body may be within reach.
    [[nodiscard]] bool meets(const Tile& body) noexcept { return is_near(body, body_); }
    /// Fills PhysicsImpl::sights for rows i0 to i0 + kTile.
    void look_from(std::uint32_t i0) noexcept {
        const std::uint32_t across = (p_.cols + kTile - 1) / kTile;
        for (std::uint32_t j0 = 0; j0 < p_.cols; j0 += kTile) {
            const std::uint32_t k = i0 / kTile * across + j0 / kTile;
            Surroundings passing;
            Surroundings& from = notes_.tiles != nullptr ? notes_.tiles[k] : passing;
            const bool near = is_near(p_.tiles[k], from);
            if (near) look_into(shape_, p_.tiles[k].box());
            Surroundings last = from;
            for (std::uint32_t i = i0; i < std::min(i0 + kTile, p_.rows); ++i)
                for (std::uint32_t j = j0; j < std::min(j0 + kTile, p_.cols); ++j) {
                    Sight& sight = p_.sights[(i - i0) * p_.cols + j];
                    sight.near = near && sees(i * p_.cols + j, sight, from, last);
                }
        }
    }

 private:
    bool is_near(const Tile& tile, Surroundings& from) const noexcept {
        const Double3 centre = tile.centre();
        const double far = tile.radius() + reach_;
        if (shape_.kind != ObstacleKind::Surface) return !(probe(shape_, centre).distance > far);
        if (clearance(from, centre) > far || clearance(body_, centre) > far) return false;
        from.note(centre, probe(shape_, centre).distance, notes_.way);
        return !(clearance(from, centre) > far);
    }
    /// @param last  the sample of the tile that was looked from last
    bool sees(std::uint32_t k, Sight& sight, const Surroundings& from, Surroundings& last) const noexcept {
        if (p_.fine().own[k] == 0 || p_.free[k] == 0) return false;
        const Double3 x = place(p_, s_, k);
        if (clearance(last, x) > reach_ || clearance(from, x) > reach_) return false;
        sight.there = probe(shape_, x);
        sight.triangle = shape_.hint;
        last.note(x, sight.there.distance, notes_.way);
        return sight.there.distance < reach_;
    }
    [[nodiscard]] double clearance(const Surroundings& from, Double3 x) const noexcept {
        return from.clearance(shape_, x, notes_.way);
    }

    PhysicsImpl& p_;
    const StateImpl& s_;
    const Shape& shape_;
    double reach_;
    Notes notes_;
    Surroundings body_;  ///< of its middle
};

/// Memory for searches of the surfaces of a scene, as far as it goes.
class Memory {
 public:
    explicit Memory(PhysicsImpl& p) noexcept : p_(p) {}
    [[nodiscard]] Notes of(const Scene& before, Scene& scene, std::uint32_t o) noexcept {
        Shape& shape = scene.shapes[o];
        if (shape.kind != ObstacleKind::Surface || used_ == PhysicsImpl::kSurfaces) return {};
        NearTiles& near = p_.near_tiles[used_];
        near.listed = near.wanted = false;
        shape.near = &near;
        Surroundings* const tiles = p_.tiles_seen.data() + used_ * p_.tiles.size();
        SurfaceSeen& seen = p_.surface_seen[used_++];
        const bool known = seen.obstacle == scene.ids[o] && has_kept_shape(before, scene, o);
        if (!known) std::fill(tiles, tiles + p_.tiles.size(), Surroundings{});
        seen = {scene.ids[o], known ? seen.way + longest_way(last_of(before, scene, o), shape) : 0};
        return {tiles, seen.way};
    }
    /// What was noted is of a scene that will not be.
    void forget() noexcept { std::fill(p_.surface_seen, p_.surface_seen + PhysicsImpl::kSurfaces, SurfaceSeen{}); }

 private:
    PhysicsImpl& p_;
    std::uint32_t used_ = 0;
};

/// Makes a contact with a ball one by way of its soft layer.
void soften(const PhysicsImpl& p, const Shape& ball, Touching& t) noexcept {
    constexpr double kTurn = 6.283185307179586;
    const double cell = double{p.mass[t.sample]} / double{p.material.density};
    t.stiffness = p.layer * cell;
    t.blunt = cell / (kTurn * ball.radius * p.scale);
    t.multiplier = 0;
}

/// Friction goes on from that of the step before, along the surface as it lies now.
void take_friction(double friction, const Touching& was, Double3 way, Touching& t) noexcept {
    t.most = static_cast<float>(friction * was.multiplier);
    if (!t.rubs()) return;
    t.hold = narrow(t.flat(widen(was.hold)));
    t.slid = narrow(t.flat(widen(was.slid) - way));
}

/// Distance within which a sample may come to touch in this step, local units.
double reach_of(const PhysicsImpl& p, const StateImpl& s) noexcept {
    double fastest = 0;
    for (const float* v : p.velocity.p)
        for (std::uint32_t k = 0; k < p.fine().grid; ++k) fastest = std::max(fastest, std::fabs(double{v[k]}));
    return 2 * double{s.mean_step} + 4 * fastest * double{p.options.dt} / p.scale;
}
}  // namespace

bool find_touching(PhysicsImpl& p, const StateImpl& s) noexcept {
    Scene& scene = p.scene[1 - p.touching_now];
    const Scene& before = p.scene[p.touching_now];
    const Remembered memory(p.touching[p.touching_now], p.touching_count);
    Array<Touching>& to = p.touching[1 - p.touching_now];
    Memory notes(p);
    std::uint32_t count = 0;
    bool fits = true;
    const double reach = scene.count == 0 ? 0 : reach_of(p, s);
    const Tile body = scene.count == 0 ? Tile{} : take_tiles(p, s);
    for (std::uint32_t o = 0; o < scene.count; ++o) {
        Shape& shape = scene.shapes[o];
        const bool moves = !has_stayed(before, scene, o);
        const Shape& stood = kFriction && moves ? last_of(before, scene, o) : shape;
        Lookout lookout(p, s, shape, reach, notes.of(before, scene, o));
        if (!lookout.meets(body)) continue;
        const auto add = [&](std::uint32_t k, const Sight& sight) {
            const Double3 x = place(p, s, k);
            shape.hint = sight.triangle;  // normals and ways are those of the triangle that was found last
            const Double3 normal = normal_at(shape, sight.there, x);
            if (!(dot(normal, normal) > 0)) return;
            if (count == to.size()) {
                fits = false;
                return;
            }
            Touching& t = to[count++];
            const Touching* was = memory.of(scene.ids[o], k);
            t = {k, scene.ids[o], normal, sight.there.distance * p.scale, double{p.grip[k]}};
            t.multiplier = was != nullptr ? was->multiplier : 0;
            t.moves = moves;
            if (p.layer > 0 && is_tool(t)) soften(p, shape, t);
            if (kFriction && p.friction > 0 && was != nullptr)
                take_friction(p.friction, *was, p.scale * way_come(stood, shape, x, sight.there), t);
        };
        for (std::uint32_t i = 0; i < p.rows && fits; ++i) {
            if (i % kTile == 0) lookout.look_from(i);
            const Sight* const row = p.sights.data() + (i % kTile) * p.cols;
            for (std::uint32_t j = 0; j < p.cols; ++j)
                if (row[j].near) add(i * p.cols + j, row[j]);
        }
        if (!fits) {
            notes.forget();
            return false;
        }
    }
    p.touching_now = 1 - p.touching_now;
    p.touching_count = count;
    return true;
}

void let_slide(PhysicsImpl& p) noexcept {
    Array<Touching>& list = p.touching[p.touching_now];
    const double dt2 = double{p.options.dt} * double{p.options.dt};
    bool any = false;
    for (std::uint32_t k = 0; k < p.touching_count; ++k) {
        Touching& t = list[k];
        if (!t.rubs()) continue;
        const std::uint32_t s = t.sample;
        const double mass = double{p.mass[s]}, back = double{t.most} * dt2 / mass;
        const Double3 way = point(p.inertial, s), to = widen(t.slid) + t.flat(way);
        const double size = std::sqrt(dot(to, to));
        if (!(size > back)) continue;
        const Double3 force = (-double{t.most} / size) * to, now = way + (dt2 / mass) * force;
        // The search starts where what bears the sample leads, but not beyond the border.
        const double up = std::min(dt2 / mass * t.multiplier, std::max(0.0, -t.gap - dot(t.normal, way)));
        const Double3 borne = now + up * t.normal;
        const double x[3] = {now.x, now.y, now.z}, from[3] = {borne.x, borne.y, borne.z};
        for (int c = 0; c < 3; ++c) {
            p.inertial.p[c][s] = static_cast<float>(x[c]);
            p.delta.p[c][s] = static_cast<float>(from[c]);
        }
        p.at_rest += 0.5 * mass * (dot(now, now) - dot(way, way)) / dt2;
        t.hold = narrow(force);
        t.slid = {};
        t.slides = any = true;
    }
    if (!any) return;
    share_copies(p.fine(), p.inertial);
    share_copies(p.fine(), p.delta);
}

void move_grasps(PhysicsImpl& p, const StateImpl& s, std::span<const ToolInput> tools, float radius) noexcept {
    std::uint64_t wanted = 0;
    for (const ToolInput& t : tools)
        if (t.kind == ToolKind::Grasp && t.engaged) wanted |= std::uint64_t{1} << t.tool;
    std::uint32_t kept = 0;
    for (std::uint32_t k = 0; k < p.grasped_count; ++k)
        if ((wanted >> p.grasped[k].tool & 1) != 0) p.grasped[kept++] = p.grasped[k];
    p.grasped_count = kept;
    const Level& l = p.fine();
    float* taken = l.d0.p[0];
    std::fill(taken, taken + l.grid, 0.0f);
    for (std::uint32_t k = 0; k < kept; ++k) taken[p.grasped[k].sample] = 1;
    for (const ToolInput& t : tools) {
        const std::uint64_t bit = std::uint64_t{1} << t.tool;
        if ((wanted & bit) == 0 || (p.holding & bit) != 0) continue;
        const Double3 tool = widen(t.position);
        double best = std::numeric_limits<double>::infinity();
        Double3 middle;
        for (std::uint32_t d = 0; d < l.dofs; ++d) {
            const Double3 x = place(p, s, l.sample_of[d]), way = x - tool;
            if (!(dot(way, way) < best)) continue;
            best = dot(way, way);
            middle = x;
        }
        const double limit = std::max(double{radius}, 4 * double{s.mean_step});
        if (!(best <= limit * limit)) {
            wanted &= ~bit;  // too far away: it may begin later
            continue;
        }
        for (std::uint32_t d = 0; d < l.dofs; ++d) {
            const std::uint32_t k = l.sample_of[d];
            const Double3 x = place(p, s, k), way = x - middle;
            if (p.free[k] == 0 || taken[k] != 0 || dot(way, way) > double{radius} * double{radius}) continue;
            taken[k] = 1;
            p.grasped[p.grasped_count++] = {k, t.tool, p.scale * (x - tool), {}, double{p.grip[k]}, {}, {}};
        }
    }
    p.holding = wanted;
    for (std::uint32_t k = 0; k < p.grasped_count; ++k) {
        Grasped& g = p.grasped[k];
        for (const ToolInput& t : tools)
            if (t.tool == g.tool) g.aim = g.offset + p.scale * (widen(t.position) - place(p, s, g.sample));
    }
}

void take_holds(PhysicsImpl& p) noexcept {
    Level& l = p.fine();
    std::fill(p.pressed, p.pressed + l.grid, 0.0f);
    const Array<Touching>& list = p.touching[p.touching_now];
    std::uint32_t count = p.grasped_count;
    for (std::uint32_t k = 0; k < p.touching_count; ++k) {
        const Touching& t = list[k];
        if (!(t.multiplier > 0 || t.gap < 0)) continue;
        p.pressed[t.sample] += static_cast<float>(t.soft() ? press_of(t, t.gap).stiffness : t.stiffness);
        ++count;
    }
    if (kFactors) p.few_held = p.few_held && count <= l.dofs / kFew;
    for (std::uint32_t k = 0; k < p.grasped_count; ++k)
        p.pressed[p.grasped[k].sample] += static_cast<float>(p.grasped[k].stiffness);
    for (std::size_t k = 0; k < l.copies.size(); k += 2) p.pressed[l.copies[k]] = p.pressed[l.copies[k + 1]];
    // E1 M^-1 E2 scale is the stiffness of a sample that is held by both factors alike.
    const bool product = p.solver.factors != Factors::One;
    const auto by = static_cast<float>(1 / p.solver.scale);
    float* extra = l.d0.p[0];
    for (std::uint32_t s = 0; s < l.grid; ++s) {
        const float held = kHeldInMatrix * p.pressed[s];
        extra[s] = l.own[s] * ((p.free[s] == 0 ? p.hold : 0) + (product ? std::sqrt(held * by * p.mass[s]) : held));
    }
    for (std::uint32_t s = 0; s < l.grid; ++s) p.give[s] = l.own[s] / (p.firm[s] + p.pressed[s]);
    if (std::equal(extra, extra + l.grid, l.extra[0])) return;  // as in most steps
    std::copy(extra, extra + l.grid, l.extra[0]);
    take_extra(p.solver);
}

Outside outside(const PhysicsImpl& p) noexcept {
    if (p.driven || p.grasped_count != 0) return Outside::Moving;
    const Array<Touching>& list = p.touching[p.touching_now];
    Outside found = Outside::Nothing;
    for (std::uint32_t k = 0; k < p.touching_count; ++k)
        if (list[k].met)
            found = std::max(found, list[k].moves || list[k].soft() ? Outside::Moving
                                    : is_tool(list[k])              ? Outside::AtRest
                                                                    : Outside::Obstacles);
    return found;
}

void keep_multipliers(PhysicsImpl& p) noexcept {
    Array<Touching>& list = p.touching[p.touching_now];
    for (std::uint32_t k = 0; k < p.touching_count; ++k) {
        Touching& t = list[k];
        t.multiplier = t.force;
        if (!t.sticks()) continue;
        const Rub rub = rub_of(t, point(p.before, t.sample));
        t.hold = narrow(rub.force);
        t.slid = rub.slides ? Vec3{} : narrow(rub.along);
    }
    for (std::uint32_t k = 0; k < p.grasped_count; ++k) p.grasped[k].multiplier = p.grasped[k].force;
}

}  // namespace dgm::detail::physics
