// SPDX-License-Identifier: MIT
// libdgm/src/cloth/touching.cpp
// Contacts of a substep with obstacles and tools, and their friction.
//
// An augmented Lagrangian: a sample that the substep would put into an obstacle bears the force of the substep before,
// and a spring along the normal brings it to the border; their sum is the force of the next substep. So a sample that
// lies still needs nothing new. Friction: if the force that would hold a sample in place is at most mu times what it
// bears, that force holds it; else one of that size opposes the way.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "cloth/cloth_impl.h"

namespace dgm::detail::cloth {
namespace {

/// Stiffness of inertia over that of sticking, at least: a stiffer one would bear more than friction can.
constexpr double kLoosest = 0.25;
/// Stiffness of a contact over that of inertia.
constexpr double kPress = 30;
/// Force that would hold a sample that stuck, over the most that friction can bear, from which on it slides at once.
constexpr double kGrip = 2;
constexpr float kNew = 1e-20f;  ///< N: mark of a contact whose force is not known yet

double length(Double3 v) noexcept {
    return std::sqrt(dot(v, v));
}

/// How far an obstacle is at least from the middle of a tile, metres; that it is no nearer than `radius` is known if
/// the answer is larger. As the tile saw the obstacle last, where that tells, as distances change by no more than the
/// ways gone.
double clearance_of(ClothImpl& c, std::uint32_t tile, const Shape& shape, Double3 middle, double radius) noexcept {
    const Double3 local = (1 / c.scale) * middle;
    if (shape.kind != ObstacleKind::Surface) return c.scale * probe(shape, local).distance;
    // The first surfaces have lists of near tiles and notes.
    TileSeen passing;
    TileSeen& seen =
        shape.near == nullptr
            ? passing
            : c.tiles_seen[static_cast<std::size_t>(shape.near - c.near_tiles.data()) * c.tile_count + tile];
    const double way = c.scene_way / c.scale;
    for (bool fresh = false;; fresh = true) {
        if (seen.scene == c.scene_number) {
            const double clear = c.scale * seen.from.clearance(shape, local, way);
            if (fresh || clear > radius || c.scale * seen.from.at_most(shape, local, way) <= radius) return clear;
        }
        seen.from.note(local, probe(shape, local).distance, way);
        seen.scene = c.scene_number;
    }
}

/// Calls f(sample, bits of obstacles, others) for samples in tiles within `margin` metres of some obstacle; from
/// obstacles that have no bit they are at least `others` metres, which is more. With `was_near`, by tile, also without
/// bits for those in tiles that were so near in the call before.
template <class F>
void each_near(ClothImpl& c, double margin, std::uint8_t* was_near, F f) noexcept {
    std::uint32_t tile = 0;
    for (std::uint32_t i0 = 0; i0 < c.rows; i0 += kTile)
        for (std::uint32_t j0 = 0; j0 < c.cols; j0 += kTile, ++tile) {
            const std::uint32_t i1 = std::min(i0 + kTile, c.rows), j1 = std::min(j0 + kTile, c.cols);
            double low[3], high[3];
            for (int d = 0; d < 3; ++d) {
                low[d] = high[d] = c.fine().at[d][c.spot_of(i0 * c.cols + j0)];
                for (std::uint32_t i = i0; i < i1; ++i)
                    for (std::uint32_t j = j0; j < j1; ++j) {
                        const double x = c.fine().at[d][c.spot_of(i * c.cols + j)];
                        low[d] = std::min(low[d], x);
                        high[d] = std::max(high[d], x);
                    }
            }
            const Double3 l{low[0], low[1], low[2]}, h{high[0], high[1], high[2]}, middle = 0.5 * (l + h);
            const double radius = 0.5 * length(h - l);
            double others = std::numeric_limits<double>::infinity();
            std::uint64_t near = 0;
            for (std::uint32_t o = 0; o < c.scene.count; ++o) {
                const Shape& shape = c.scene.here[o];
                const double to_come = shape.ahead * c.scene.way[o], enough = radius + margin + to_come;
                const double clear = clearance_of(c, tile, shape, middle, enough);
                if (clear > enough) {
                    others = std::min(others, clear - radius - to_come);
                    continue;
                }
                near |= std::uint64_t{1} << o;
                if (shape.kind != ObstacleKind::Surface) continue;
                Box box;
                for (int d = 0; d < 3; ++d) {
                    box.low[d] = static_cast<float>(low[d] / c.scale);
                    box.high[d] = static_cast<float>(high[d] / c.scale);
                }
                look_into(shape, box);
            }
            const auto is_near = static_cast<std::uint8_t>(near != 0 ? 1 : 0);
            const bool left = was_near != nullptr && std::exchange(was_near[tile], is_near) > is_near;
            if (near == 0 && !left) continue;
            for (std::uint32_t i = i0; i < i1; ++i)
                for (std::uint32_t j = j0; j < j1; ++j) f(i * c.cols + j, near, others);
        }
}

struct Found {
    std::uint32_t obstacle = kNone;
    double gap = 1e300;
    Double3 normal;
    Probe there;
};
/// The obstacle that a place is deepest in, or nearest to.
Found find(const ClothImpl& c, Double3 x, std::uint64_t near) noexcept {
    Found out;
    const Double3 local = (1 / c.scale) * x;
    for (; near != 0; near &= near - 1) {
        const auto o = static_cast<std::uint32_t>(__builtin_ctzll(near));
        const Shape& shape = c.scene.here[o];
        const Probe p = probe_underway(shape, local);
        const double gap = c.scale * p.distance - 0.5 * double{c.options.thickness};
        if (!(gap < out.gap)) continue;
        const Double3 normal = normal_at(shape, p, local);
        out = {o, gap, dot(normal, normal) > 0 ? normal : Double3{0, 0, 1}, p};
    }
    return out;
}

/// The same for a sample, and notes what it has seen.
/// @param others  as each_near()
Found look(ClothImpl& c, std::uint32_t sample, std::uint64_t near, double others) noexcept {
    const Double3 x = c.place(c.spot_of(sample));
    const Found out = find(c, x, near);
    double gap = std::min(out.gap, others - 0.5 * double{c.options.thickness});
    // Behind a surface of limited reach distances change sign again.
    for (std::uint64_t left = near; left != 0; left &= left - 1) {
        const Shape& shape = c.scene.here[__builtin_ctzll(left)];
        if (shape.is_limited()) gap = std::min(gap, out.gap - c.scale * shape.reach);
    }
    c.seen[sample] = {x, gap, c.scene_number, c.scene_way};
    return out;
}
/// In front of all obstacles by more than `by` metres, as distances change by no more than the way gone.
bool is_clear(const ClothImpl& c, std::uint32_t sample, double by) noexcept {
    const Seen& seen = c.seen[sample];
    if (seen.scene != c.scene_number) return false;
    const double gone = c.scene_way - seen.way + length(c.place(c.spot_of(sample)) - seen.at);
    return seen.gap - (1 + 1e-9) * gone > by;
}

/// How far an obstacle that was found at a place goes in the substep there, metres.
Double3 way_of(const ClothImpl& c, const Found& f, Double3 x) noexcept {
    if (!c.scene.moves[f.obstacle]) return {};
    return c.scale * way_come(c.scene.last[f.obstacle], c.scene.here[f.obstacle], (1 / c.scale) * x, f.there);
}

void add_friction(const ClothImpl& c, Contact& t, Spot k, double by_dt2, double friction, Double3 moved) noexcept {
    const Double3 force = Double3{} - at(c.gradient, k);
    const Double3 start = c.place(k) - Double3{c.was[0][k], c.was[1][k], c.was[2][k]} - moved;
    const auto flat = [&](Double3 v) { return v - dot(v, t.normal) * t.normal; };
    t.slid = flat(start);
    const double bears = c.pressed[k] > kNew ? double{c.pressed[k]} : std::max(0.0, -dot(force, t.normal));
    const Double3 wanted = flat(force) + (by_dt2 * double{c.weight[k]}) * t.slid;
    const double size = length(wanted), most = friction * bears;
    const Rub& before = c.rubs[t.sample];
    if (before.sticks && t.bears > 0 && by_dt2 * double{c.weight[k]} * length(t.slid) <= kGrip * most) {
        const Double3 held = flat(widen(before.force));
        const double holds = length(held);
        t.pull = holds > most ? (most / holds) * held : held;
        t.drag = kPress * by_dt2 * double{c.weight[k]};
        return;
    }
    if (size > most) {
        t.pull = (-most / size) * wanted;
        return;
    }
    t.pull = Double3{} - wanted;
    t.drag = std::min(size / kLoosest, most) * (size > 0 ? by_dt2 * double{c.weight[k]} / size : 0);
}
}  // namespace

void find_contacts(ClothImpl& c, double h, double friction) noexcept {
    Level& l = c.fine();
    for (std::uint32_t k = 0; k < c.contact_count; ++k) {
        const Spot s = c.spot_of(c.contacts[k].sample);
        l.on.press[s] = l.on.drag[s] = 0;
        put(l.on.normal, s, {});
    }
    std::fill(l.on.touched, l.on.touched + l.rows, std::uint8_t{0});
    c.contact_count = 0;
    if (c.scene.count == 0 && std::find(c.tiles_met.begin(), c.tiles_met.end(), std::uint8_t{1}) == c.tiles_met.end())
        return;
    const double keep = std::max(double{c.options.thickness}, 1e-3 * c.mean_step);
    // What is farther than `keep` is no contact; what is seen to be farther by as much need not be asked again soon.
    const double margin = 0.5 * double{c.options.thickness} + 2 * keep;
    each_near(c, margin, c.tiles_met.data(), [&](std::uint32_t sample, std::uint64_t near, double others) {
        const Spot k = c.spot_of(sample);
        if (l.own[k] == 0) return;
        const auto let_go = [&] { each_copy(c, sample, [&](std::uint32_t s) { c.pressed[c.spot_of(s)] = 0; }); };
        if (near == 0 || l.free[k] == 0 || is_clear(c, sample, keep)) return let_go();
        const Found f = look(c, sample, near, others);
        Contact t{sample, f.obstacle, f.normal, f.gap, 0, 0, 0, {}, {}};
        t.press = double{c.firm[k]} + kPress * double{c.weight[k]} / (h * h);
        t.bears = f.gap < keep && c.pressed[k] > kNew ? double{c.pressed[k]} : 0;
        if (!(f.gap < 0 || t.press * f.gap < t.bears)) return let_go();
        add_friction(c, t, k, 1 / (h * h), friction, way_of(c, f, c.place(k)));
        put(l.on.normal, k, t.normal);
        l.on.press[k] = static_cast<float>(t.press);
        l.on.drag[k] = static_cast<float>(t.drag);
        l.on.touched[k / static_cast<Spot>(l.on.pitch)] = 1;
        c.contacts[c.contact_count++] = t;
    });
}

double press(ClothImpl& c) noexcept {
    for (std::uint32_t n = 0; n < c.contact_count; ++n) {
        const Contact& t = c.contacts[n];
        const Double3 slope = (t.press * t.gap - t.bears) * t.normal + t.drag * t.slid - t.pull;
        each_copy(c, t.sample,
                  [&](std::uint32_t s) { put(c.gradient, c.spot_of(s), at(c.gradient, c.spot_of(s)) + slope); });
    }
    return pressed_energy(c, 0);
}

double pressed_energy(const ClothImpl& c, double by) noexcept {
    double energy = 0;
    for (std::uint32_t n = 0; n < c.contact_count; ++n) {
        const Contact& t = c.contacts[n];
        const Double3 d = by != 0 ? by * c.led * at(c.lead, c.spot_of(t.sample)) : Double3{};
        const double gap = t.gap + dot(t.normal, d);
        const Double3 slid = t.slid + d - dot(t.normal, d) * t.normal;
        energy += 0.5 * t.press * gap * gap + 0.5 * t.drag * dot(slid, slid) - dot(t.pull + t.bears * t.normal, d);
    }
    return energy;
}

void end_contacts(ClothImpl& c, std::span<StepTool> answers, double friction, double share) noexcept {
    for (std::uint32_t n = 0; n < c.contact_count; ++n) {
        const Contact& t = c.contacts[n];
        const Spot k = c.spot_of(t.sample);
        const Double3 d = c.led * at(c.lead, k);
        const double bears = std::max(0.0, t.bears - t.press * (t.gap + dot(t.normal, d)));
        each_copy(c, t.sample, [&](std::uint32_t s) { c.pressed[c.spot_of(s)] = static_cast<float>(bears); });
        Double3 rubs = t.pull - t.drag * (t.slid + d - dot(t.normal, d) * t.normal);
        const double size = length(rubs), most = friction * bears;
        if (size > most) rubs = (most / size) * rubs;
        c.rubs[t.sample] = {narrow(rubs), t.drag > 0 && size <= most};
        const std::uint32_t tool = c.scene.tool[t.obstacle];
        if (!(bears > 0) || tool >= answers.size()) continue;
        answers[tool].force = answers[tool].force - narrow(share * (bears * t.normal + rubs));
        ++answers[tool].contacts;
    }
}

void push_out(ClothImpl& c) noexcept {
    const Level& l = c.fine();
    if (c.scene.count == 0) return;
    const double margin = 0.5 * double{c.options.thickness};
    each_near(c, margin, nullptr, [&](std::uint32_t sample, std::uint64_t near, double others) {
        const Spot k = c.spot_of(sample);
        if (l.own[k] == 0 || l.free[k] == 0) return;
        for (int round = 0; round < 3; ++round) {  // out of one obstacle may be into another one
            // It stays a rounding error inside, so that the next substep knows it.
            const double rounding = 1e-9 * (1 + length(c.place(k)));
            if (is_clear(c, sample, -2 * rounding)) return;
            const Found f = look(c, sample, near, others);
            if (!(f.gap < -2 * rounding)) return;
            const Double3 out = (-rounding - f.gap) * f.normal;
            each_copy(c, sample, [&](std::uint32_t s) {
                const Spot to = c.spot_of(s);
                l.at[0][to] += out.x;
                l.at[1][to] += out.y;
                l.at[2][to] += out.z;
                c.pressed[to] = std::max(c.pressed[to], kNew);
            });
        }
    });
}

}  // namespace dgm::detail::cloth
