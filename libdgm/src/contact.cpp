// SPDX-License-Identifier: MIT
// libdgm/src/contact.cpp
// Paper section 6: what lies beyond the obstacle is found, measured and projected, or all is left as it was.
#include <dgm/contact.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "contact_impl.h"
#include "contact_resolver.h"

namespace dgm {
namespace detail {
namespace {
constexpr float kUnmet = std::numeric_limits<float>::infinity();
}

ContactReport Resolver::run() noexcept {
    refit(s_, s_.now_boxes);
    find_contact();
    if (report_.samples == 0) return finish(ContactStatus::Clear);
    if (report_.deepest > o_.max_depth || report_.total > o_.max_total) return finish(ContactStatus::Restored);
    size_ring();
    const bool bulging = c_.closed && o_.bulge != Bulge::None;
    if (bulging) update_normals(s_);
    if (bulging || (!c_.closed && o_.smoothing != 0))
        grow_ring(s_, c_, shape_, report_.ring_reach, bulging ? ~0u : o_.smoothing);
    if (bulging) weigh();
    list_quads();
    save();
    project();
    if (c_.closed) {
        collect(c_.near, kTileSinking | kTileBulging, kTileSinking | kTileBulging);
        sunk_ = swept(c_.inner);
        removed_ = -(sunk_ + swept(c_.near) + swept_faces());
        c_.near.count = 0;
        report_.removed = removed_ / 6;
        report_.volume_error = -1;
    }
    if (bulging && report_.ring != 0) bulge();
    if (!c_.closed) {
        smooth_contact(s_, c_, shape_, o_.smoothing);
        report_.ring = 0;
    }
    report_.volume_kept = c_.closed && std::fabs(report_.volume_error) <= kKept;
    if (o_.mode == DeformMode::Plastic) keep();
    touch();
    return finish(c_.closed ? ContactStatus::Contact : ContactStatus::Open);
}

void Resolver::find_contact() noexcept {
    const Pyramid& y = s_.now_boxes;
    const Box& root = y.boxes[y.start[y.levels - 1]];
    double largest = 0;
    for (int k = 0; k < 3; ++k)
        largest = std::max({largest, std::fabs(double{root.low[k]}), std::fabs(double{root.high[k]})});
    tolerance_ = 2e-7 * largest;
    each_tile(
        y, [&](const Box& box) { return box_distance(shape_, box) < -tolerance_; },
        [&](std::uint32_t tile) { mark_tile(tile); });
}

void Resolver::mark_tile(std::uint32_t tile) noexcept {
    const Rect r = s_.tile_rect(tile);
    if (is_simple(tile)) {
        PlaneSums sums;
        sums.deepest = report_.deepest;
        c_.rows_of->mark(plane_job(r), sums);
        if (sums.count == 0) return;
        report_.samples += sums.count;
        deepen(sums.deepest);
        total_ += sums.total;
        report_.total = static_cast<float>(total_);
        c_.add_tile(tile, kTilePhi);
        return;
    }
    bool any = false, sunk = false;
    look_into(shape_, s_.now_boxes.boxes[tile]);
    // Copies of a class must agree: each by a search of its own.
    const bool plain = remembers() && s_.tables.mask == nullptr && (s_.tile_flags[tile] & kTileSpecial) == 0;
    const auto clear = [&](const Rect& part) {
        if (!plain) return false;
        const Double3 p = widen(s_.point(part.i0 * s_.tables.cols + part.j0));
        if (!(around_.clearance(shape_, p) > 0)) around_.note(p, probe(shape_, p).distance);
        return around_.clearance(shape_, p) > 0 && is_apart(shape_, s_, part);
    };
    if (clear(r)) return;
    for (std::uint32_t i = r.i0; i <= r.i1; ++i)
        for (std::uint32_t j = r.j0; j <= r.j1; j += 4) {
            const std::uint32_t last = std::min(j + 3, r.j1), cols = s_.tables.cols;
            if (!sunk && clear({i, i, j, last})) continue;  // beside one that is beyond most are
            for (std::uint32_t k = i * cols + j; k <= i * cols + last; ++k) {
                sunk = s_.tables.on_surface(k) && mark_sample(k);
                any = any || sunk;
            }
        }
    for (std::uint32_t b = s_.tile_border_start[tile]; b < s_.tile_border_start[tile + 1]; ++b)
        if (mark_sample(s_.tile_border[b])) c_.border = any = true;
    if (any) c_.add_tile(tile, kTilePhi);
}

bool Resolver::mark_sample(std::uint32_t k) noexcept {
    const Double3 p = widen(s_.point(k));
    if (around_.clearance(shape_, p) > 0) return false;
    const Probe there = probe(shape_, p);
    const double d = there.distance;
    around_.note(p, d);
    if (!(d < -tolerance_)) return false;
    c_.marks[k] = kInside;
    if (remembers()) {
        const Vec3 to = projected(k, p, there);
        const Planes saved = c_.before();
        saved.x[k] = to.x;
        saved.y[k] = to.y;
        saved.z[k] = to.z;
        if (!c_.closed) c_.source[k] = there.facet;  // the walk of an open surface's ring leaves it
    }
    if (s_.representative(k) != k) return true;
    const double m = mobility_of(s_, k);
    report_.sunk = report_.sunk || -d * (1 - m) > tolerance_;
    ++report_.samples;
    deepen(-d * m);
    total_ -= d * m;
    report_.total = static_cast<float>(total_);
    return true;
}

void Resolver::size_ring() noexcept {
    for (std::uint32_t k = 0; k < c_.tile_count; ++k) {
        const QuadJob job = quad_job(s_.tile_rect(c_.tiles[k]));
        if (!job.rect.empty()) area_ += c_.rows_of->area(job, c_.marks.data());
    }
    if (!o_.rings.empty()) {
        std::size_t k = 0;
        while (k + 1 < o_.rings.size() && report_.total > o_.rings[k].total) ++k;
        report_.ring_reach = o_.rings[k].reach;
        report_.ring_sigma = o_.rings[k].sigma;
        return;
    }
    const double reach = std::max(std::sqrt(area_ / 3.14159265358979), 2 * double{s_.mean_step});
    report_.ring_reach = static_cast<float>(reach);
    report_.ring_sigma = static_cast<float>(reach * reach / 4);
}

void Resolver::list_quads() noexcept {
    const std::uint32_t listed = c_.tile_count;
    for (std::uint32_t k = 0; k < listed; ++k) {
        const std::uint32_t tile = c_.tiles[k], ti = tile / s_.tile_cols, tj = tile % s_.tile_cols;
        const auto bits =
            static_cast<std::uint8_t>(kTileMoving | ((c_.tile_bits[tile] & kTilePhi) != 0 ? kTileSinking : 0) |
                                      ((c_.tile_bits[tile] & kTilePsi) != 0 ? kTileBulging : 0));
        for (std::uint32_t i = ti == 0 ? 0 : ti - 1; i <= ti; ++i)
            for (std::uint32_t j = tj == 0 ? 0 : tj - 1; j <= tj; ++j) c_.add_tile(i * s_.tile_cols + j, bits);
    }
    c_.tile_range = {s_.tile_rows, 0, s_.tile_cols, 0};
    for (std::uint32_t k = 0; k < c_.tile_count; ++k) {
        const std::uint32_t ti = c_.tiles[k] / s_.tile_cols, tj = c_.tiles[k] % s_.tile_cols;
        c_.tile_range = {std::min(c_.tile_range.i0, ti), std::max(c_.tile_range.i1, ti), std::min(c_.tile_range.j0, tj),
                         std::max(c_.tile_range.j1, tj)};
    }
    collect(c_.inner, kTileMoving | kTileBulging, kTileMoving);
    collect(c_.ring, kTileBulging, kTileBulging);
    c_.near.count = 0;
}

void Resolver::collect(Runs& runs, std::uint8_t mask, std::uint8_t bits) noexcept {
    runs.count = 0;
    for (std::uint32_t i = c_.tile_range.i0; i <= c_.tile_range.i1; ++i)
        for (std::uint32_t j = c_.tile_range.j0; j <= c_.tile_range.j1; ++j) {
            const std::uint32_t tile = i * s_.tile_cols + j;
            if ((c_.tile_bits[tile] & mask) != bits) continue;
            const Rect r = s_.tile_rect(tile);
            if (runs.count != 0 && runs.rects[runs.count - 1].i0 == r.i0 && runs.rects[runs.count - 1].j1 + 1 == r.j0)
                runs.rects[runs.count - 1].j1 = r.j1;
            else
                runs.rects[runs.count++] = r;
        }
}

void Resolver::save() noexcept {
    const Planes to = c_.before();
    const auto keep = [&](std::uint32_t k) {
        if (remembers() && (c_.marks[k] & kInside) != 0) return;  // project() exchanges it
        to.x[k] = s_.now.x[k];
        to.y[k] = s_.now.y[k];
        to.z[k] = s_.now.z[k];
    };
    each_run([&](Rect r) {
        // Quads at its end reach into the tiles beyond.
        r.i1 = std::min(r.i1 + 1, s_.tables.rows - 1);
        r.j1 = std::min(r.j1 + 1, s_.tables.cols - 1);
        if (!remembers()) return c_.rows_of->copy(StateImpl::fixed(s_.now), to, r, s_.tables.cols);
        for (std::uint32_t i = r.i0; i <= r.i1; ++i)
            for (std::uint32_t k = i * s_.tables.cols + r.j0; k <= i * s_.tables.cols + r.j1; ++k) keep(k);
    });
    for (std::uint32_t k = s_.tables.grid; k < s_.total(); ++k) keep(k);
}

Vec3 Resolver::projected(std::uint32_t k, Double3 from, const Probe& there) const noexcept {
    const double m = mobility_of(s_, k);
    if (m == 0 || there.distance == 0) return s_.point(k);
    // The plane's own rounding, as of ContactRows::project.
    return narrow(shape_.kind == ObstacleKind::Plane ? from - (there.distance * m) * shape_.normal
                                                     : from + m * (there.nearest - from));
}

void Resolver::project_sample(std::uint32_t k) noexcept {
    if ((c_.marks[k] & kInside) == 0) return;
    const Planes saved = c_.before();
    if (remembers()) {
        std::swap(s_.now.x[k], saved.x[k]);
        std::swap(s_.now.y[k], saved.y[k]);
        std::swap(s_.now.z[k], saved.z[k]);
        c_.queue[k] = c_.closed ? kNone : c_.source[k];
        return;
    }
    const Double3 p = widen(s_.point(k));
    const Vec3 to = projected(k, p, probe(shape_, p));
    c_.queue[k] = kNone;
    s_.now.x[k] = to.x;
    s_.now.y[k] = to.y;
    s_.now.z[k] = to.z;
}

void Resolver::project() noexcept {
    for (std::uint32_t e = 0; e < c_.tile_count; ++e) {
        if ((c_.tile_bits[c_.tiles[e]] & kTilePhi) == 0) continue;
        if (shape_.kind == ObstacleKind::Plane && s_.mobility.empty())
            c_.rows_of->project(plane_job(s_.tile_rect(c_.tiles[e])), nullptr);
        else
            each_sample(c_.tiles[e], [&](std::uint32_t k) { project_sample(k); });
    }
    if (c_.border)
        for (std::uint32_t k = s_.tables.grid; k < s_.total(); ++k) project_sample(k);
}

void Resolver::keep() noexcept {
    const Planes from = c_.before();
    const auto move = [&](float* base, const float* now, const float* old, std::size_t k) {
        base[k] = base[k] == old[k] ? now[k] : base[k] + (now[k] - old[k]);
    };
    const auto all = [&](std::uint32_t k) {
        move(s_.base.x, s_.now.x, from.x, k);
        move(s_.base.y, s_.now.y, from.y, k);
        move(s_.base.z, s_.now.z, from.z, k);
    };
    for (std::uint32_t e = 0; e < c_.tile_count; ++e) each_sample(c_.tiles[e], all);
    for (std::uint32_t k = s_.tables.grid; k < s_.total(); ++k) all(k);
}

void Resolver::touch() noexcept {
    RectList moved;
    collect(c_.near, kTileMoving, kTileMoving);
    for (const Rect& r : c_.near) moved.add(r);
    if (c_.border) {
        moved.add_border(s_.tables.grid);
        moved.add_border(s_.total() - 1);
    }
    s_.touch(moved, o_.mode == DeformMode::Plastic);
}

ContactReport Resolver::finish(ContactStatus status) noexcept {
    report_.status = status;
    const auto clear = [&](std::size_t k, std::size_t count) {
        std::fill_n(c_.marks.data() + k, count, std::uint8_t{0});
        std::fill_n(c_.weight.data() + k, count, 0.0f);
        std::fill_n(c_.square.data() + k, count, kUnmet);
    };
    const std::uint32_t cols = s_.tables.cols;
    for (std::uint32_t e = 0; e < c_.tile_count; ++e) {
        const Rect r = s_.tile_rect(c_.tiles[e]);
        for (std::uint32_t i = r.i0; i <= r.i1; ++i) {
            if (r.width() == 8)
                clear(std::size_t{i} * cols + r.j0, 8);  // a constant: stores in place of calls
            else
                clear(std::size_t{i} * cols + r.j0, r.width());
        }
        c_.tile_bits[c_.tiles[e]] = 0;
        // Nodes of the tiles after it may lie on the next row and column.
        if (!c_.spread) continue;
        const std::uint32_t i1 = std::min(r.i1 + 1, s_.tables.rows - 1), j1 = std::min(r.j1 + 1, cols - 1);
        for (std::uint32_t i = r.i0; i <= i1; ++i) c_.square[std::size_t{i} * cols + j1] = kUnmet;
        for (std::uint32_t j = r.j0; j <= j1; ++j) c_.square[std::size_t{i1} * cols + j] = kUnmet;
    }
    if (c_.border) clear(s_.tables.grid, s_.total() - s_.tables.grid);
    c_.tile_count = 0;
    c_.border = c_.spread = false;
    return report_;
}

namespace {
Result<void> check(const StateImpl& s, const ContactImpl& c, const ContactOptions& o) noexcept {
    if (c.rows != s.tables.rows || c.cols != s.tables.cols || c.total != s.tables.total || c.closed == s.open_surface)
        return Error{ErrorCode::BadArgument, kNoOffset, "the solver was made for another state"};
    if (!(o.max_depth >= 0) || !(o.max_total >= 0))
        return Error{ErrorCode::BadArgument, kNoOffset, "a limit of the contact is negative or not a number"};
    if (o.rings.size() > 16 || o.smoothing > 64)
        return Error{ErrorCode::BadArgument, kNoOffset, "more ring sizes or rounds of smoothing than allowed"};
    for (const RingSize& r : o.rings)
        if (!std::isfinite(r.total) || !(r.reach >= kMinStep && r.reach <= kMaxCoordinate) ||
            !(r.sigma >= kMinStep * kMinStep && r.sigma <= kMaxCoordinate * kMaxCoordinate))
            return Error{ErrorCode::BadArgument, kNoOffset, "a ring size is not a number or out of range"};
    if (o.bulge > Bulge::None || o.mode > DeformMode::Plastic)
        return Error{ErrorCode::Unsupported, kNoOffset, "the bulge or the mode is not supported"};
    return {};
}
}  // namespace
}  // namespace detail

Result<ContactReport> resolve_contact(State& state, const ContactSolver& solver, const Obstacle& obstacle,
                                      const ContactOptions& options) noexcept {
    detail::StateImpl& s = *state.impl();
    detail::ContactImpl& c = *solver.impl();
    if (auto r = detail::check(s, c, options); !r) return r.error();
    if (obstacle.surface == &state)
        return Error{ErrorCode::BadArgument, kNoOffset, "a shape cannot be its own obstacle"};
    auto shape = detail::make_shape(obstacle);
    if (!shape) return shape.error();
    shape.value().near = &c.near_tiles;
    c.near_tiles.listed = c.near_tiles.wanted = false;
    return detail::Resolver(s, c, shape.value(), options).run();
}

}  // namespace dgm
