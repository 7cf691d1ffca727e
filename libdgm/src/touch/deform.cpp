// SPDX-License-Identifier: MIT
// libdgm/src/touch/deform.cpp
// Paper eq. 7: a footprint's weights times the displacement of the contact.
#include <dgm/deform.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "touch/state_impl.h"
#include "touch/table_impl.h"

namespace dgm {
namespace detail {
namespace {

MoveJob job_of(const StateImpl& s, const Rect& rect, const Planes& shape, Vec3 d) noexcept {
    MoveJob job{};
    job.rect = rect;
    job.cols = s.tables.cols;
    job.from = StateImpl::fixed(shape);
    job.to = shape;
    job.mobility = s.mobility.empty() ? nullptr : s.mobility.data();
    job.d[0] = d.x;
    job.d[1] = d.y;
    job.d[2] = d.z;
    return job;
}

/// The rounding of rows.h, one sample at a time.
void move_sample(const StateImpl& s, const Planes& shape, std::uint32_t k, Vec3 d) noexcept {
    float w = s.footprint.weight[k];
    if (!s.mobility.empty() && k < s.tables.grid) w = w * s.mobility[k];
    shape.x[k] = shape.x[k] + w * d.x;
    shape.y[k] = shape.y[k] + w * d.y;
    shape.z[k] = shape.z[k] + w * d.z;
}

void weld_copies(const StateImpl& s, const Planes& shape) noexcept {
    for (std::uint32_t k = 0; k < s.footprint.class_count; ++k) {
        const auto members = s.members(s.footprint.classes[k]);
        for (const std::uint32_t copy : members.subspan(1)) {
            shape.x[copy] = shape.x[members[0]];
            shape.y[copy] = shape.y[members[0]];
            shape.z[copy] = shape.z[members[0]];
        }
    }
}

/// A sample in two frames' rectangles must move once: after a rectangle its weights are 0.
void move_footprint(StateImpl& s, const Contact& c) noexcept {
    FootprintScratch& f = s.footprint;
    for (std::uint32_t k = 0; k < f.frame_count; ++k) {
        const Rect& r = f.frames[k].rect;
        MoveJob job = job_of(s, r, s.now, c.d);
        job.weights = f.weight.data() + std::size_t{r.i0} * s.tables.cols + r.j0;
        job.weight_step = s.tables.cols;
        s.rows_of->move(job);
        if (c.plastic) {
            job.from = StateImpl::fixed(s.base);
            job.to = s.base;
            s.rows_of->move(job);
        }
        if (k + 1 == f.frame_count) break;
        for (std::uint32_t i = r.i0; i <= r.i1; ++i)
            std::fill_n(f.weight.data() + std::size_t{i} * s.tables.cols + r.j0, r.width(), 0.0f);
    }
    for (std::uint32_t k = 0; k < f.sample_count; ++k) {
        move_sample(s, s.now, f.samples[k], c.d);
        if (c.plastic) move_sample(s, s.base, f.samples[k], c.d);
    }
    // Whatever order and however often copies were met, they hold the bits of the first.
    weld_copies(s, s.now);
    if (c.plastic) weld_copies(s, s.base);
}

/// Moves a frame's rectangle by the rows of the table.
void move_frame(StateImpl& s, const TableImpl& t, const Frame& f, const Contact& c) noexcept {
    MoveJob job = job_of(s, f.rect, s.now, c.d);
    const auto i0 = static_cast<std::int32_t>(f.rect.i0), j0 = static_cast<std::int32_t>(f.rect.j0);
    const std::int32_t x = f.c * i0 - f.s * j0 + f.x, y = f.s * i0 + f.c * j0 + f.y;
    // Kernels are even: (row, column) of the first sample, rows growing with i and columns with j. Turned frames take
    // a kernel that is mirrored as well, whose sign of rows is free.
    const std::int32_t row = f.c != 0 ? f.c * x : f.s * y, column = f.c != 0 ? f.c * y : -f.s * x;
    job.weight_step = t.width();
    job.mirrored = t.mirrored && row < 0;
    job.centre = static_cast<std::uint32_t>(i0 - row);
    job.weights = t.row(job.mirrored ? 0 : row, f.c == 0) + column;
    s.rows_of->move(job);
    if (!c.plastic) return;
    job.from = StateImpl::fixed(s.base);
    job.to = s.base;
    s.rows_of->move(job);
}

/// All copies of a class take the place of the one nearest to the contact, whose rectangle has moved; those in no frame
/// are listed.
void weld_nearest(StateImpl& s, const TableImpl& t, std::uint32_t id, bool plastic) noexcept {
    FootprintScratch& f = s.footprint;
    const auto a = static_cast<float>(t.a), b = static_cast<float>(t.b), c = static_cast<float>(t.c);
    const auto members = s.members(id);
    std::uint32_t nearest = members[0];
    float best = __builtin_inff();
    for (const std::uint32_t copy : members) {
        const std::uint32_t i = copy / s.tables.cols, j = copy % s.tables.cols;
        const Frame* in =
            std::find_if(f.frames, f.frames + f.frame_count, [&](const Frame& frame) { return frame.rect.has(i, j); });
        if (in == f.frames + f.frame_count) {
            f.samples[f.sample_count++] = copy;
            continue;
        }
        const auto row = static_cast<std::int32_t>(i), column = static_cast<std::int32_t>(j);
        const auto x = static_cast<float>(in->c * row - in->s * column + in->x);
        const auto y = static_cast<float>(in->s * row + in->c * column + in->y);
        const float key = a * x * x + b * x * y + c * y * y;
        if (!(key < best)) continue;
        best = key;
        nearest = copy;
    }
    for (const std::uint32_t copy : members) {
        s.now.x[copy] = s.now.x[nearest];
        s.now.y[copy] = s.now.y[nearest];
        s.now.z[copy] = s.now.z[nearest];
        if (!plastic) continue;
        s.base.x[copy] = s.base.x[nearest];
        s.base.y[copy] = s.base.y[nearest];
        s.base.z[copy] = s.base.z[nearest];
    }
}

void touch_footprint(StateImpl& s, bool plastic) noexcept {
    const FootprintScratch& f = s.footprint;
    RectList moved;
    for (std::uint32_t k = 0; k < f.frame_count; ++k) moved.add(f.frames[k].rect);
    for (std::uint32_t k = 0; k < f.sample_count; ++k) {
        if (f.samples[k] < s.tables.grid)
            s.list_tile(s.tile_of(f.samples[k]));
        else
            moved.add_border(f.samples[k]);
    }
    for (std::uint32_t k = 0; k < s.tile_count_listed; ++k) moved.add(s.tile_rect(s.tile_list[k]));
    s.end_tile_list();
    s.touch(moved, plastic);
}

void fade_footprint(StateImpl& s) noexcept {
    if (!s.fading.behind) return;
    const FootprintScratch& f = s.footprint;
    for (std::uint32_t k = 0; k < f.frame_count; ++k) fade(s, f.frames[k].rect);
    for (std::uint32_t k = 0; k < f.sample_count; ++k) fade(s, f.samples[k]);
}

/// A footprint of frames that do not meet: no sample has two places, so that all but copies of classes move in rows.
/// The tiles of these all fade together, so listed copies are up to date when the frames are.
void move_frames_apart(StateImpl& s, const TableImpl& t, const Contact& c, DeformReport& report) noexcept {
    FootprintScratch& f = s.footprint;
    for (std::uint32_t k = 0; k < f.frame_count; ++k) {
        fade(s, f.frames[k].rect);
        report.samples += static_cast<std::uint32_t>(RectList::area(f.frames[k].rect));
    }
    // Tiles with classes fade together: copies outside of the frames as well.
    if (f.class_count != 0) fade(s, s.members(f.classes[0])[0]);
    for (std::uint32_t k = 0; k < f.frame_count; ++k) move_frame(s, t, f.frames[k], c);
    for (std::uint32_t k = 0; k < f.class_count; ++k) weld_nearest(s, t, f.classes[k], c.plastic);
    report.samples += f.sample_count;
    report.crossed_seam = f.class_count != 0;
    touch_footprint(s, c.plastic);
    f.frame_count = 0;  // no keys and weights to be cleared
    end_footprint(s);
}

void move_patch(StateImpl& s, const Patch& p, const Contact& c, DeformReport& report) noexcept {
    for (std::uint32_t k = 0; k < p.moved.count; ++k) fade(s, p.moved.rects[k]);
    if (p.moved.border_low <= p.moved.border_high) fade(s, p.moved.border_low);
    for (const Planes* shape : {&s.now, &s.base}) {
        if (shape == &s.base && !c.plastic) break;
        s.rows_of->move_patch(
            {p.rows.data(), p.row_count, StateImpl::fixed(*shape), *shape, p.weight.data(), {c.d.x, c.d.y, c.d.z}});
    }
    s.touch(p.moved, c.plastic);
    report.samples = p.samples;
    report.crossed_seam = p.crossed_seam;
}

std::uint32_t count_samples(const StateImpl& s) noexcept {
    const FootprintScratch& f = s.footprint;
    std::uint32_t count = f.sample_count;
    bool apart = true;
    for (std::uint32_t k = 0; k < f.frame_count; ++k) {
        count += static_cast<std::uint32_t>(RectList::area(f.frames[k].rect));
        for (std::uint32_t e = 0; e < k && apart; ++e) apart = !f.frames[e].rect.meets(f.frames[k].rect);
    }
    if (apart) return count;
    count = f.sample_count;
    for (std::uint32_t k = 0; k < f.frame_count; ++k) {
        const Rect& r = f.frames[k].rect;
        for (std::uint32_t i = r.i0; i <= r.i1; ++i)
            for (std::uint32_t j = r.j0; j <= r.j1; ++j) {
                bool counted = false;
                for (std::uint32_t e = 0; e < k && !counted; ++e) counted = f.frames[e].rect.has(i, j);
                count += counted ? 0 : 1;
            }
    }
    return count;
}
}  // namespace

/// A difference of floats may be infinite: it counts as the largest float, so that no infinity meets a 0.
Vec3 clamped(Vec3 d, float d_max) noexcept {
    constexpr double kMost = std::numeric_limits<float>::max();
    const double x = std::clamp(double{d.x}, -kMost, kMost), y = std::clamp(double{d.y}, -kMost, kMost),
                 z = std::clamp(double{d.z}, -kMost, kMost);
    const double length = std::sqrt(x * x + y * y + z * z);
    if (length <= d_max) return d;
    const double f = d_max / length;
    return {static_cast<float>(x * f), static_cast<float>(y * f), static_cast<float>(z * f)};
}

Result<void> check_contact(const StateImpl& s, const TableImpl& t, Footprint footprint, DeformMode mode, float d_max,
                           float step) noexcept {
    if (!std::isfinite(d_max) || !(d_max > 0))
        return Error{ErrorCode::BadArgument, kNoOffset, "d_max is not a positive number"};
    if (t.options.reach > s.max_reach)
        return Error{ErrorCode::BadArgument, kNoOffset, "the table reaches farther than the state was made for"};
    if (step != 0 && !(step >= kMinStep && step <= kMaxStep))
        return Error{ErrorCode::BadArgument, kNoOffset, "the step is neither 0 nor in 1e-15 .. 1e15"};
    if (footprint > Footprint::Grid) return Error{ErrorCode::Unsupported, kNoOffset, "the footprint is not supported"};
    if (mode != DeformMode::Elastic && mode != DeformMode::Plastic)
        return Error{ErrorCode::Unsupported, kNoOffset, "the mode is not supported"};
    return {};
}

MoveJob window_job(const StateImpl& s, const TableImpl& t, const Rect& r, std::uint32_t sample, Vec3 d) noexcept {
    const std::uint32_t i = sample / s.tables.cols, j = sample % s.tables.cols;
    MoveJob job = job_of(s, r, s.now, d);
    job.weights = t.row(t.mirrored ? 0 : static_cast<std::int32_t>(r.i0) - static_cast<std::int32_t>(i)) - (j - r.j0);
    job.weight_step = t.width();
    job.mirrored = t.mirrored;
    job.centre = i;
    return job;
}

Result<DeformReport> apply_contact(StateImpl& s, const TableImpl& t, const Contact& c) noexcept {
    DeformReport report;
    report.displacement = c.d;
    if (c.footprint != Footprint::Grid) {
        move_patch(s, patch_of(s, t, c), c, report);
        return report;
    }
    if (s.stiffness.empty() && is_plain_window(s, c.sample, t.options.reach)) {
        const Rect r = s.window(c.sample, t.options.reach);
        fade(s, r);
        MoveJob job = window_job(s, t, r, c.sample, c.d);
        s.rows_of->move(job);
        if (c.plastic) {
            job.from = StateImpl::fixed(s.base);
            job.to = s.base;
            s.rows_of->move(job);
        }
        s.touch(r, c.plastic);
        report.samples = static_cast<std::uint32_t>(RectList::area(r));
        return report;
    }
    if (s.stiffness.empty() && !s.tables.free_domain && place_frames_apart(s, t, c.sample, t.options.reach)) {
        move_frames_apart(s, t, c, report);
        return report;
    }
    if (auto r = begin_footprint(s, t, c); !r) return r.error();
    fade_footprint(s);
    report.samples = count_samples(s);
    report.crossed_seam = s.footprint.class_count != 0;
    report.truncated = s.footprint.truncated;
    move_footprint(s, c);
    touch_footprint(s, c.plastic);
    end_footprint(s);
    return report;
}
}  // namespace detail

Result<DeformReport> deform(State& state, const DeformTable& table, const Touch& touch) noexcept {
    detail::StateImpl& s = *state.impl();
    const detail::TableImpl& t = *table.impl();
    if (!s.usable(touch.sample))
        return Error{ErrorCode::BadArgument, kNoOffset, "the contact is no sample of the surface"};
    if (!detail::is_place(touch.displacement))
        return Error{ErrorCode::BadArgument, kNoOffset, "a component of the displacement is beyond 1e18"};
    if (auto r = detail::check_contact(s, t, touch.footprint, touch.mode, touch.d_max, touch.step); !r)
        return r.error();
    return detail::apply_contact(s, t,
                                 {touch.sample, detail::clamped(touch.displacement, touch.d_max), touch.footprint,
                                  touch.mode == DeformMode::Plastic, touch.step > 0 ? touch.step : s.mean_step});
}

}  // namespace dgm
