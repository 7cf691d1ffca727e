// SPDX-License-Identifier: MIT
// libdgm/src/touch/tick.cpp
#include <dgm/tick.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include <dgm/force.h>

#include "base/portable_math.h"
#include "touch/state_impl.h"
#include "touch/table_impl.h"

namespace dgm {
namespace detail {
namespace {

/// Distances are trusted to this part: float rounding is a hundred times smaller.
constexpr float kSlack = 1e-5f;
/// Side of the window that is looked through each tick (a = 4, but for a row): one row is one load of eight lanes.
/// Measured (docs/speed-against-error.md): alone, such a window takes 0.1 us and misses the nearest sample in up to a
/// third of the ticks of a tool that leaps; a = 16 takes four times as long and still misses it in a tenth. With the
/// certificate none is missed, in 0.45 us; half the window changes that by less than the noise.
constexpr std::uint32_t kPatch = 8;

float length(Vec3 v) noexcept {
    return std::sqrt(dot(v, v));
}
double product(Vec3 a, Vec3 b) noexcept {
    return double{a.x} * b.x + double{a.y} * b.y + double{a.z} * b.z;
}

Result<void> check(const StateImpl& s, const TableImpl& t, const TickOptions& o, std::span<const ToolInput> tools,
                   std::span<ToolOutput> outputs) noexcept {
    const auto bad = [](const char* message) { return Error{ErrorCode::BadArgument, kNoOffset, message}; };
    if (!(o.dt >= 0) || !std::isfinite(o.dt)) return bad("the time step is not a number from 0");
    if (!(o.f_max >= 0) || !std::isfinite(o.f_max)) return bad("f_max is not a number from 0");
    if (!(o.relax_rate >= 0)) return bad("the relaxation rate is not a number from 0");
    if (!(o.settle_time >= 0) || !std::isfinite(o.settle_time)) return bad("the settle time is not a number from 0");
    if (!(o.grasp_distance >= 0)) return bad("the grasp distance is not a number from 0");
    if (o.rule > ContactRule::Printed) return Error{ErrorCode::Unsupported, kNoOffset, "the contact rule is not known"};
    if (auto r = check_contact(s, t, o.footprint, o.mode, o.d_max, o.step); !r) return r;
    if (!outputs.empty() && outputs.size() < tools.size()) return bad("there are fewer outputs than tools");
    std::uint64_t named = 0;
    for (const ToolInput& in : tools) {
        if (!is_place(in.position)) return bad("a coordinate of a tool is beyond 1e18");
        if (in.kind > ToolKind::Grasp) return Error{ErrorCode::Unsupported, kNoOffset, "the tool kind is not known"};
        if (in.tool >= s.tools.size()) return bad("the state was made for fewer tools");
        if ((named >> in.tool & 1) != 0) return bad("a tool is named twice");
        named |= std::uint64_t{1} << in.tool;
    }
    return {};
}

/// The window of a certificate: kPatch samples square around a sample, shifted into the grid.
Rect patch_around(const StateImpl& s, std::uint32_t sample) noexcept {
    const auto span = [](std::uint32_t k, std::uint32_t size, std::uint32_t& low, std::uint32_t& high) {
        if (size <= kPatch) {
            low = 0;
            high = size - 1;
            return;
        }
        low = std::min(k > kPatch / 2 ? k - kPatch / 2 : 0, size - kPatch);
        high = low + kPatch - 1;
    };
    Rect r;
    span(sample / s.tables.cols, s.tables.rows, r.i0, r.i1);
    span(sample % s.tables.cols, s.tables.cols, r.j0, r.j1);
    return r;
}

bool all_on_surface(const StateImpl& s, const Rect& r) noexcept {
    if (s.tables.mask == nullptr) return true;
    for (std::uint32_t i = r.i0; i <= r.i1; ++i)
        for (std::uint32_t j = r.j0; j <= r.j1; ++j)
            if (s.tables.mask[std::size_t{i} * s.tables.cols + j] == 0) return false;
    return true;
}

/// Looks for the nearest sample outside a patch around the best one known. If there is none nearer, that one is the
/// answer, and stays in the patch as long as the tool has moved less than the difference of the two distances.
/// @return false if a nearer one was found; it is the nearest of all then, and in `best`.
bool certify(const StateImpl& s, ToolSlot& slot, Vec3 tool, Best& best) noexcept {
    slot.certified = false;
    if (best.sample >= s.tables.grid) return false;
    slot.patch = patch_around(s, best.sample);
    if (!all_on_surface(s, slot.patch)) return false;
    s.rows_of->nearest({slot.patch, s.tables.cols, s.base_boxes.at, {tool.x, tool.y, tool.z}}, best.d2, best.sample);
    // A larger bound would not be used up before the tool has left the patch.
    const float enough = std::sqrt(best.d2) + static_cast<float>(kPatch / 2) * s.mean_step;
    Best other{enough * enough, kNone};
    search_pyramid(s, s.base_boxes, tool, other, &slot.patch);
    if (other.sample != kNone && (other.d2 < best.d2 || (other.d2 == best.d2 && other.sample < best.sample))) {
        best = other;
        return false;
    }
    slot.clear = std::sqrt(other.d2) * (1 - kSlack);
    slot.origin = tool;
    slot.base_version = s.base_version;
    slot.certified = std::isfinite(slot.clear);
    return slot.certified;
}

/// Exact nearest sample of the base shape. @return whether the pyramid had to be searched.
bool find_nearest(StateImpl& s, ToolSlot& slot, Vec3 tool, Best& best) noexcept {
    if (slot.certified && slot.base_version == s.base_version) {
        s.rows_of->nearest({slot.patch, s.tables.cols, s.base_boxes.at, {tool.x, tool.y, tool.z}}, best.d2,
                           best.sample);
        const float moved = length(tool - slot.origin) * (1 + kSlack);
        if (std::sqrt(best.d2) * (1 + kSlack) < slot.clear - moved) return false;
    } else if (slot.placed && s.usable(slot.sample)) {
        const Vec3 d = StateImpl::at(s.base, slot.sample) - tool;
        best.offer(dot(d, d), slot.sample);
    }
    refit(s, s.base_boxes);
    if (best.sample != kNone && certify(s, slot, tool, best)) return true;
    search_pyramid(s, s.base_boxes, tool, best);
    certify(s, slot, tool, best);
    return true;
}

/// Beside an open rim the nearest sample is on it, and "behind the surface" means nothing. The end of a seam has no
/// copy either, but is no rim.
bool beside_rim(const StateImpl& s, std::uint32_t sample, Vec3 v, Vec3 n) noexcept {
    if (!s.open_surface || (sample < s.tables.grid && (s.ring[sample] & kRingRim) == 0)) return false;
    if (s.class_id(sample) != kNone) return false;
    const double h = product(v, n);
    return product(v, v) - h * h > double{s.mean_step} * s.mean_step;
}

/// The displacement that the contact asks for now; begins and ends contacts.
Vec3 wished(const StateImpl& s, ToolSlot& slot, const ToolInput& in, const TickOptions& o, ToolOutput& out) noexcept {
    const ConstPlanes base = StateImpl::fixed(s.base);
    const Vec3 v = in.position - StateImpl::at(s.base, out.sample), n = sample_normal(s, base, out.sample);
    const double h = product(v, n);
    out.hit = h < 0 && !beside_rim(s, out.sample, v, n);
    if (static_cast<std::uint32_t>(in.kind) != slot.kind) slot.holding = false;
    slot.kind = static_cast<std::uint32_t>(in.kind);
    if (!in.engaged) slot.holding = false;
    const Vec3 along = static_cast<float>(h) * n;
    switch (in.kind) {
        case ToolKind::Touch:
            slot.holding = in.engaged && out.hit;
            if (!slot.holding) return {};
            slot.contact = out.sample;
            return o.rule == ContactRule::Printed ? v : along;
        case ToolKind::Poke:
            if (slot.holding && product(in.position - slot.anchor, sample_normal(s, base, slot.contact)) >= 0)
                slot.holding = false;
            else if (!slot.holding && in.engaged && out.hit) {
                slot.holding = true;
                slot.contact = out.sample;
                slot.anchor = in.position - along;  // where the tool came through
            }
            break;
        case ToolKind::Grasp: {
            const float reach = o.grasp_distance > 0 ? o.grasp_distance : 4 * s.mean_step;
            if (!slot.holding && in.engaged && out.distance <= reach) {
                slot.holding = true;
                slot.contact = out.sample;
                slot.anchor = in.position;
            }
            break;
        }
    }
    return slot.holding ? in.position - slot.anchor : Vec3{};
}

/// tick.h: steps of at most twice the tool's own, the rest carried.
Vec3 settled(ToolSlot& slot, Vec3 wish, Vec3 tool, const TickOptions& o) noexcept {
    if (!(o.settle_time > 0) || o.rule == ContactRule::Printed) {
        slot.carried = {};
        return wish;
    }
    if (!(slot.carried == Vec3{})) slot.carried = portable_exp(-o.dt / o.settle_time) * slot.carried;
    const Vec3 change = wish - slot.wish;
    const float jump = length(change), allowed = slot.placed ? 2 * length(tool - slot.at) : 0;
    if (jump > allowed) slot.carried = slot.carried - (1 - allowed / jump) * change;
    if (length(slot.carried) <= 1e-6f * o.d_max) slot.carried = {};
    return wish + slot.carried;
}

struct Press {
    Contact contact;
    bool active;
};

/// Everything about one tool but the shape.
Press move_tool(StateImpl& s, const TickOptions& o, const ToolInput& in, ToolOutput& out) noexcept {
    ToolSlot& slot = s.tools[in.tool];
    Best best;
    out.lost = find_nearest(s, slot, in.position, best);
    if (best.sample == kNone) {  // squares overflow so far away: nothing there can be touched
        best.sample = slot.placed && s.usable(slot.sample) ? slot.sample : s.any_sample;
        best.d2 = std::numeric_limits<float>::max();
    }
    out.sample = best.sample;
    out.distance = std::sqrt(best.d2);
    const Vec3 wish = clamped(wished(s, slot, in, o, out), o.d_max);
    const Vec3 asked = settled(slot, wish, in.position, o), d = asked == wish ? wish : clamped(asked, o.d_max);
    out.holding = slot.holding;
    out.displacement = d;
    if (const auto force = contact_force(d, o.d_max, o.f_max)) out.force = force.value();
    Vec3 applied = d;
    if (o.mode == DeformMode::Plastic) {
        // The permanent shape follows: a touch asks only for the missing part, the others for the new part.
        applied = in.kind == ToolKind::Touch || !slot.holding ? (slot.holding ? wish : Vec3{}) : wish - slot.wish;
    }
    slot.wish = slot.holding ? wish : Vec3{};
    slot.at = in.position;
    slot.sample = out.sample;
    slot.placed = true;
    const bool active = slot.contact != kNone && !(applied == Vec3{});
    const Contact contact{active ? slot.contact : 0, applied, o.footprint, o.mode == DeformMode::Plastic,
                          o.step > 0 ? o.step : s.mean_step};
    if (!slot.holding && d == Vec3{}) slot.contact = kNone;
    out.contact = slot.contact;
    return {contact, active};
}

void restore(const StateImpl& s, std::uint32_t i0, std::uint32_t i1, std::uint32_t j0, std::uint32_t j1) noexcept {
    const std::size_t bytes = (j1 - j0 + 1) * sizeof(float);
    for (std::uint32_t i = i0; i <= i1; ++i) {
        const std::size_t at = std::size_t{i} * s.tables.cols + j0;
        std::memcpy(s.now.x + at, s.base.x + at, bytes);
        std::memcpy(s.now.y + at, s.base.y + at, bytes);
        std::memcpy(s.now.z + at, s.base.z + at, bytes);
    }
}

/// now = base in `old` but not in `fresh`.
void restore_around(const StateImpl& s, const Rect& old, const Rect& fresh) noexcept {
    const Rect both{std::max(old.i0, fresh.i0), std::min(old.i1, fresh.i1), std::max(old.j0, fresh.j0),
                    std::min(old.j1, fresh.j1)};
    if (both.empty()) return restore(s, old.i0, old.i1, old.j0, old.j1);
    if (old.i0 < both.i0) restore(s, old.i0, both.i0 - 1, old.j0, old.j1);
    if (both.i1 < old.i1) restore(s, both.i1 + 1, old.i1, old.j0, old.j1);
    if (old.j0 < both.j0) restore(s, both.i0, both.i1, old.j0, both.j0 - 1);
    if (both.j1 < old.j1) restore(s, both.i0, both.i1, both.j1 + 1, old.j1);
}

/// One elastic contact in a plain window on a surface that springs back at once, which is the common case: rest and
/// displacement in one pass, and of the tick before only what sticks out. @return false if it is another case.
bool press_window(StateImpl& s, const TableImpl& t, const Contact& c) noexcept {
    if (c.footprint != Footprint::Grid || c.plastic || !s.stiffness.empty()) return false;
    if (!s.fading.empty() || s.elastic.count > 1 || s.elastic.border_low <= s.elastic.border_high) return false;
    if (!is_plain_window(s, c.sample, t.options.reach)) return false;
    const Rect r = s.window(c.sample, t.options.reach);
    if (s.elastic.count == 1) {
        const Rect old = s.elastic.rects[0];
        if (!(old == r)) {
            restore_around(s, old, r);
            s.note(old);
            s.now_boxes.dirty.add(old);
            s.normal_dirty.add(old);
        }
    }
    MoveJob job = window_job(s, t, r, c.sample, c.d);
    job.from = StateImpl::fixed(s.base);
    job.to = s.now;
    s.rows_of->move(job);
    s.elastic.clear();
    s.touch(r, false);
    return true;
}

/// Weight times mobility at the contact itself.
float share_at(const StateImpl& s, const TableImpl& t, std::uint32_t sample) noexcept {
    return t.profile(0) * (s.mobility.empty() || sample >= s.tables.grid ? 1 : s.mobility[sample]);
}

/// Several contacts, or a surface on which displacements fade.
Result<TickReport> press_all(StateImpl& s, const TableImpl& t, const TickOptions& o, std::span<const Contact> contacts,
                             bool at_once) noexcept {
    TickReport report;
    s.fading.in_tick = !at_once;
    if (at_once)
        release_elastic(s);
    else
        advance_fading(s, double{o.relax_rate} * o.dt);
    for (Contact c : contacts) {
        if (!at_once && !c.plastic) {
            // The contact is to be displaced by d in all, whatever of earlier ticks is still there.
            fade(s, c.sample);
            const Vec3 there = s.point(c.sample) - StateImpl::at(s.base, c.sample);
            c.d = c.d - (1 / share_at(s, t, c.sample)) * there;
        }
        auto done = apply_contact(s, t, c);
        if (!done) {
            if (!at_once) end_fading_tick(s, o.normals);
            return done.error();
        }
        report.samples += done.value().samples;
        report.crossed_seam = report.crossed_seam || done.value().crossed_seam;
        report.truncated = report.truncated || done.value().truncated;
    }
    return report;
}
}  // namespace
}  // namespace detail

Result<TickReport> tick(State& state, const DeformTable& table, const TickOptions& o, std::span<const ToolInput> tools,
                        std::span<ToolOutput> outputs) noexcept {
    detail::StateImpl& s = *state.unsettled();
    const detail::TableImpl& t = *table.impl();
    if (auto r = detail::check(s, t, o, tools, outputs); !r) return r.error();
    if (s.any_sample == kNone) return Error{ErrorCode::NotFound, kNoOffset, "the chart has no sample to be near to"};

    detail::Contact contacts[64];
    std::uint32_t count = 0;
    bool at_once = std::isinf(o.relax_rate);
    for (std::size_t k = 0; k < tools.size(); ++k) {
        ToolOutput out;
        const detail::Press press = detail::move_tool(s, o, tools[k], out);
        if (!outputs.empty()) outputs[k] = out;
        if (!press.active) continue;
        contacts[count++] = press.contact;
        // A contact with hardly any mobility is not asked to make up for a fading displacement.
        at_once = at_once || !(detail::share_at(s, t, press.contact.sample) > 1e-6f);
    }

    if (s.fading.normals_owed && !o.normals) detail::settle(s);  // they stay as they are now
    TickReport report;
    if (count == 1 && at_once && detail::press_window(s, t, contacts[0])) {
        report.samples = static_cast<std::uint32_t>(detail::RectList::area(s.elastic.rects[0]));
    } else if (DeformReport pressed;
               count == 1 && at_once && o.normals && detail::press_patch(s, t, contacts[0], pressed)) {
        report.samples = pressed.samples;
        report.crossed_seam = pressed.crossed_seam;
    } else {
        auto done = detail::press_all(s, t, o, {contacts, count}, at_once);
        if (!done) return done.error();
        report = done.value();
    }
    report.contacts = count;
    if (!at_once) {
        detail::end_fading_tick(s, o.normals);
    } else if (o.normals) {
        detail::update_normals(s);
        s.fading.normals_owed = false;
    }
    return report;
}

}  // namespace dgm
