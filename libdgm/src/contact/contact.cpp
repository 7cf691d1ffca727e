// SPDX-License-Identifier: MIT
// libdgm/src/contact/contact.cpp
// Paper section 6: samples beyond the obstacle are found, measured and projected, or all is left as it was.
#include <dgm/contact.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "contact/contact_impl.h"
#include "contact/contact_resolver.h"

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

MarkJob Resolver::mark_job(const Rect& r) noexcept {
    MarkJob job{};
    job.rect = r;
    job.cols = s_.tables.cols;
    job.at = StateImpl::fixed(s_.now);
    job.tolerance = tolerance_;
    job.skip = c_.in_class.data();
    job.marks = c_.marks.data();
    job.to = c_.before();
    const auto put = [](double* to, Double3 v) {
        to[0] = v.x;
        to[1] = v.y;
        to[2] = v.z;
    };
    if (shape_.kind == ObstacleKind::Plane) {
        job.kind = Beyond::kPlane;
        put(job.a, shape_.normal);
        job.d = shape_.offset;
        return job;
    }
    job.kind = Beyond::kRound;
    put(job.a, shape_.point);
    job.d = shape_.radius;
    if (shape_.kind == ObstacleKind::Capsule) put(job.along, shape_.end - shape_.point);
    const double square = job.along[0] * job.along[0] + job.along[1] * job.along[1] + job.along[2] * job.along[2];
    job.square = square > 0 ? square : 1;
    return job;
}

void Resolver::mark_tile(std::uint32_t tile) noexcept {
    const Rect r = c_.rects[tile];
    bool any = false;
    if (is_simple()) {
        MarkSums sums;
        sums.deepest = report_.deepest;
        c_.rows_of->mark(mark_job(r), sums);
        if (sums.count != 0) {
            any = true;
            report_.samples += sums.count;
            deepen(sums.deepest);
            total_ += sums.total;
            report_.total = static_cast<float>(total_);
        }
        if ((s_.tile_flags[tile] & kTileSpecial) != 0)
            each_sample(tile, [&](std::uint32_t k) {
                if (c_.in_class[k] != 0) any = mark_sample(k) || any;
            });
        if (any) c_.add_tile(tile, kTilePhi);
        return;
    }
    bool sunk = false;
    look_into(shape_, s_.now_boxes.boxes[tile]);
    const bool plain = searches() && s_.tables.mask == nullptr && (s_.tile_flags[tile] & kTileSpecial) == 0;
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
        any = mark_sample(s_.tile_border[b]) || any;
    if (any) c_.add_tile(tile, kTilePhi);
}

// Copies of a class take the verdict and the target of the representative, which alone is tested.
bool Resolver::mark_sample(std::uint32_t k) noexcept {
    if (s_.representative(k) != k) return (c_.marks[k] & kInside) != 0;
    const Double3 p = widen(s_.point(k));
    if (around_.clearance(shape_, p) > 0) return false;
    const Probe there = probe(shape_, p);
    const double d = there.distance;
    around_.note(p, d);
    if (!(d < -tolerance_)) return false;
    const Vec3 to = projected(k, p, there);
    const auto mark = [&](std::uint32_t copy) {
        c_.marks[copy] = kInside;
        c_.border = c_.border || copy >= s_.tables.grid;
        const Planes saved = c_.before();
        saved.x[copy] = to.x;
        saved.y[copy] = to.y;
        saved.z[copy] = to.z;
        if (!c_.closed) c_.source[copy] = there.facet;  // the walk of an open surface's ring leaves it
    };
    const std::uint32_t id = s_.class_id(k);
    if (id == kNone) {
        mark(k);
    } else {
        for (const std::uint32_t copy : s_.members(id)) {
            mark(copy);
            c_.add_tile(s_.tile_of(copy), kTilePhi);
        }
    }
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
        const QuadJob job = quad_job(c_.rects[c_.tiles[k]]);
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
            const Rect r = c_.rects[tile];
            if (runs.count != 0 && runs.rects[runs.count - 1].i0 == r.i0 && runs.rects[runs.count - 1].j1 + 1 == r.j0)
                runs.rects[runs.count - 1].j1 = r.j1;
            else
                runs.rects[runs.count++] = r;
        }
}

Vec3 Resolver::projected(std::uint32_t k, Double3 from, const Probe& there) const noexcept {
    const double m = mobility_of(s_, k);
    if (m == 0 || there.distance == 0) return s_.point(k);
    // The plane's own rounding, as of ContactRows::project.
    return narrow(shape_.kind == ObstacleKind::Plane ? from - (there.distance * m) * shape_.normal
                                                     : from + m * (there.nearest - from));
}

void Resolver::project() noexcept {
    const Planes saved = c_.before();
    const auto exchange = [&](const Rect& r) {
        c_.rows_of->exchange(c_.marks.data(), s_.now, saved, r, s_.tables.cols);
    };
    const auto is_listed = [&](std::uint32_t ti, std::uint32_t tj) {
        return ti < s_.tile_rows && tj < s_.tile_cols && c_.tile_bits[ti * s_.tile_cols + tj] != 0;
    };
    each_run([&](Rect r) {
        exchange(r);
        // Quads at its end reach into the tiles beyond, which may not be listed: nothing moves there.
        const std::uint32_t ti = StateImpl::owner(r.i0, s_.tile_rows), end = StateImpl::owner(r.j1, s_.tile_cols) + 1;
        const bool right = r.j1 + 1 < s_.tables.cols, down = r.i1 + 1 < s_.tables.rows;
        if (right && !is_listed(ti, end)) exchange({r.i0, r.i1, r.j1 + 1, r.j1 + 1});
        if (!down) return;
        for (std::uint32_t tj = StateImpl::owner(r.j0, s_.tile_cols); tj < end; ++tj) {
            const Rect tile = c_.rects[ti * s_.tile_cols + tj];
            if (!is_listed(ti + 1, tj)) exchange({r.i1 + 1, r.i1 + 1, tile.j0, tile.j1});
        }
        if (right && !is_listed(ti + 1, end)) exchange({r.i1 + 1, r.i1 + 1, r.j1 + 1, r.j1 + 1});
    });
    if (s_.total() > s_.tables.grid)
        c_.rows_of->exchange(c_.marks.data(), s_.now, saved, {0, 0, s_.tables.grid, s_.total() - 1}, 0);
}

void Resolver::keep() noexcept {
    const Planes from = c_.before();
    // A sample that did not move keeps its bits: a copy of it may be in a tile that is not listed. The sign of a zero
    // is a bit, too, and a move below the precision of float may have changed it.
    const auto bits = [](float v) { return __builtin_bit_cast(std::uint32_t, v); };
    const auto move = [&](float* base, const float* now, const float* old, std::size_t k) {
        if (bits(base[k]) == bits(old[k]))
            base[k] = now[k];
        else if (now[k] != old[k])
            base[k] += now[k] - old[k];
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
    const std::uint32_t cols = s_.tables.cols;
    const auto clear = [](auto& values, std::size_t k, std::size_t count, auto value) {
        if (count == 8)
            std::fill_n(values.data() + k, 8, value);  // a constant: stores in place of calls
        else
            std::fill_n(values.data() + k, count, value);
    };
    for (std::uint32_t e = 0; e < c_.tile_count; ++e) {
        const std::uint32_t tile = c_.tiles[e];
        const Rect r = c_.rects[tile];
        const std::uint8_t bits = std::exchange(c_.tile_bits[tile], std::uint8_t{0});
        const bool phi = (bits & kTilePhi) != 0, psi = (bits & kTilePsi) != 0;
        if (!phi && !psi) continue;
        // Nodes are every fourth sample, and copies of such.
        const bool nodes = c_.spread && !heights_ && (s_.tile_flags[tile] & kTileSpecial) == 0;
        for (std::uint32_t i = r.i0; i <= r.i1; ++i) {
            const std::size_t k = std::size_t{i} * cols + r.j0;
            clear(c_.marks, k, r.width(), std::uint8_t{0});
            if (psi || !c_.closed) clear(c_.weight, k, r.width(), 0.0f);
            if ((psi || !c_.closed) && !(nodes && i % 4 != 0 && i + 1 != s_.tables.rows))
                clear(c_.square, k, r.width(), kUnmet);
        }
    }
    if (c_.border) {
        const std::size_t border = s_.total() - s_.tables.grid;
        clear(c_.marks, s_.tables.grid, border, std::uint8_t{0});
        clear(c_.weight, s_.tables.grid, border, 0.0f);
        clear(c_.square, s_.tables.grid, border, kUnmet);
    }
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
