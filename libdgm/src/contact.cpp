// SPDX-License-Identifier: MIT
// libdgm/src/contact.cpp
// Paper section 6, with the volume kept as in methods section 6.
//
// Phi: samples beyond the obstacle. Psi: the ring around them. x' is the shape after projecting Phi, b_i = w_i n_i the
// bulge of Psi. The volume of x' + beta b is a cubic in beta; its root is found by Newton's method from the first-order
// answer. Samples that this would take beyond the obstacle are put back on it, and the volume that costs is fetched by
// secant steps on the volume measured. What rounding to float leaves is put on a few samples one after another, the
// volume being linear in each.
#include <dgm/contact.h>

#include <algorithm>
#include <cmath>

#include "contact_impl.h"

namespace dgm {
namespace detail {
namespace {

constexpr double kKept = 1e-6;      // of the removed volume: what volume_kept says
constexpr double kPolished = 1e-5;  // what a few samples can take without showing it
constexpr double kAimed = 1e-8;
constexpr std::uint32_t kMaxPasses = 10;

class Resolver {
 public:
    Resolver(StateImpl& s, ContactImpl& c, const Shape& shape, const ContactOptions& o) noexcept
        : s_(s), c_(c), shape_(shape), o_(o) {}

    ContactReport run() noexcept {
        refit(s_, s_.now_boxes);
        find_contact();
        if (report_.samples == 0) return finish(ContactStatus::Clear);
        if (report_.deepest > o_.max_depth || report_.total > o_.max_total) return finish(ContactStatus::Restored);
        size_ring();
        const bool bulging = c_.closed && o_.bulge != Bulge::None;
        if (bulging) update_normals(s_);
        if (bulging || (!c_.closed && o_.smoothing != 0)) grow_ring(s_, c_, shape_, report_.ring_reach);
        if (bulging) weigh();
        list_quads();
        save();
        if (c_.closed) {
            origin_ = widen(s_.point(s_.any_sample));
            before_ = volume();
        }
        project();
        if (c_.closed) {
            elsewhere_ = volume(c_.runs, c_.run_count);
            projected_ = elsewhere_ + ring_volume();
            report_.removed = (before_ - projected_) / 6;
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

 private:
    // --- Phi ---
    void find_contact() noexcept {
        const Pyramid& y = s_.now_boxes;
        const Box& root = y.boxes[y.start[y.levels - 1]];
        double largest = 0;
        for (int k = 0; k < 3; ++k)
            largest = std::max({largest, std::fabs(double{root.low[k]}), std::fabs(double{root.high[k]})});
        tolerance_ = 2e-7 * largest;
        std::uint32_t stack[4 * kMaxLevels], level_of[4 * kMaxLevels], depth = 0;
        stack[depth] = 0;
        level_of[depth++] = y.levels - 1;
        while (depth != 0) {
            const std::uint32_t node = stack[--depth], level = level_of[depth];
            if (!(box_distance(shape_, y.boxes[y.start[level] + node]) < -tolerance_)) continue;
            if (level == 0) {
                mark_tile(node);
                continue;
            }
            const std::uint32_t r = node / y.cols[level] * 2, c = node % y.cols[level] * 2;
            for (std::uint32_t i = r; i < std::min(r + 2, y.rows[level - 1]); ++i)
                for (std::uint32_t j = c; j < std::min(c + 2, y.cols[level - 1]); ++j) {
                    stack[depth] = i * y.cols[level - 1] + j;
                    level_of[depth++] = level - 1;
                }
        }
    }
    [[nodiscard]] PlaneJob plane_job(const Rect& r) noexcept {
        return {r,          s_.tables.cols, s_.now, {shape_.normal.x, shape_.normal.y, shape_.normal.z}, shape_.offset,
                tolerance_, c_.marks.data()};
    }
    [[nodiscard]] bool is_simple(std::uint32_t tile) const noexcept {
        return shape_.kind == ObstacleKind::Plane && s_.tables.mask == nullptr && s_.mobility.empty() &&
               (s_.tile_flags[tile] & kTileSpecial) == 0;
    }
    void mark_tile(std::uint32_t tile) noexcept {
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
        bool any = false;
        for (std::uint32_t i = r.i0; i <= r.i1; ++i)
            for (std::uint32_t k = i * s_.tables.cols + r.j0; k <= i * s_.tables.cols + r.j1; ++k)
                any = (s_.tables.on_surface(k) && mark_sample(k)) || any;
        for (std::uint32_t b = s_.tile_border_start[tile]; b < s_.tile_border_start[tile + 1]; ++b)
            if (mark_sample(s_.tile_border[b])) c_.border = any = true;
        if (any) c_.add_tile(tile, kTilePhi);
    }
    bool mark_sample(std::uint32_t k) noexcept {
        const double d = probe(shape_, widen(s_.point(k))).distance;
        if (!(d < -tolerance_)) return false;
        c_.marks[k] = kInside;
        if (s_.representative(k) != k) return true;
        const double m = mobility_of(s_, k);
        report_.sunk = report_.sunk || -d * (1 - m) > tolerance_;
        ++report_.samples;
        deepen(-d * m);
        total_ -= d * m;
        report_.total = static_cast<float>(total_);
        return true;
    }
    void deepen(double d) noexcept { report_.deepest = std::max(report_.deepest, static_cast<float>(d)); }

    // --- Psi ---
    void size_ring() noexcept {
        if (!o_.rings.empty()) {
            std::size_t k = 0;
            while (k + 1 < o_.rings.size() && report_.total > o_.rings[k].total) ++k;
            report_.ring_reach = o_.rings[k].reach;
            report_.ring_sigma = o_.rings[k].sigma;
            return;
        }
        double area = 0;
        for (std::uint32_t k = 0; k < c_.tile_count; ++k) {
            const QuadJob job = quad_job(s_.tile_rect(c_.tiles[k]));
            if (!job.rect.empty()) area += c_.rows_of->area(job, c_.marks.data());
        }
        const double reach = std::max(std::sqrt(area / 3.14159265358979), 2 * double{s_.mean_step});
        report_.ring_reach = static_cast<float>(reach);
        report_.ring_sigma = static_cast<float>(reach * reach / 4);
    }
    void weigh() noexcept {
        const float slope = report_.ring_reach * report_.ring_reach / report_.ring_sigma;
        WeightJob job{};
        job.cols = s_.tables.cols;
        job.square = c_.spread ? c_.weight.data() : c_.square.data();
        job.mobility = s_.mobility.empty() ? nullptr : s_.mobility.data();
        job.weight = c_.weight.data();
        job.factor = 1 / report_.ring_sigma;
        job.limit = std::min(report_.ring_reach * report_.ring_reach, 64 * report_.ring_sigma);
        job.slope = slope;
        // A kernel that is flat up to R has no compact form to speak of.
        job.end = o_.bulge == Bulge::Exact && slope > 0.25f ? std::exp(-slope) : 0.0f;
        for (std::uint32_t k = 0; k < c_.tile_count; ++k) {
            if ((c_.tile_bits[c_.tiles[k]] & kTilePsi) == 0) continue;
            job.rect = s_.tile_rect(c_.tiles[k]);
            report_.ring += c_.rows_of->weights(job);
        }
        if (!c_.border) return;
        job.rect = {0, 0, 0, 0};
        job.cols = 0;
        for (std::uint32_t k = s_.tables.grid; k < s_.total(); ++k) {
            job.square = c_.square.data() + k;
            job.weight = c_.weight.data() + k;
            const float m = mobility_of(s_, k);
            job.mobility = &m;
            report_.ring += c_.rows_of->weights(job);
        }
    }

    // --- volumes ---
    /// Tiles with touched quads, and runs of tiles side by side.
    void list_quads() noexcept {
        const std::uint32_t listed = c_.tile_count;
        for (std::uint32_t k = 0; k < listed; ++k) {
            const std::uint32_t tile = c_.tiles[k], ti = tile / s_.tile_cols, tj = tile % s_.tile_cols;
            const auto bit =
                static_cast<std::uint8_t>(kTileMoving | ((c_.tile_bits[tile] & kTilePsi) != 0 ? kTileBulging : 0));
            for (std::uint32_t i = ti == 0 ? 0 : ti - 1; i <= ti; ++i)
                for (std::uint32_t j = tj == 0 ? 0 : tj - 1; j <= tj; ++j) c_.add_tile(i * s_.tile_cols + j, bit);
        }
        std::uint32_t i0 = s_.tile_rows, i1 = 0, j0 = s_.tile_cols, j1 = 0;
        for (std::uint32_t k = 0; k < c_.tile_count; ++k) {
            const std::uint32_t ti = c_.tiles[k] / s_.tile_cols, tj = c_.tiles[k] % s_.tile_cols;
            i0 = std::min(i0, ti);
            i1 = std::max(i1, ti);
            j0 = std::min(j0, tj);
            j1 = std::max(j1, tj);
        }
        c_.run_count = c_.ring_run_count = 0;
        const auto add = [&](Array<Rect>& runs, std::uint32_t& count, std::uint32_t tile) {
            const Rect r = s_.tile_rect(tile);
            if (count != 0 && runs[count - 1].i0 == r.i0 && runs[count - 1].j1 + 1 == r.j0)
                runs[count - 1].j1 = r.j1;
            else
                runs[count++] = r;
        };
        for (std::uint32_t i = i0; i <= i1; ++i)
            for (std::uint32_t j = j0; j <= j1; ++j) {
                const std::uint32_t tile = i * s_.tile_cols + j;
                if (c_.tile_bits[tile] == 0) continue;
                if ((c_.tile_bits[tile] & kTileBulging) != 0)
                    add(c_.ring_runs, c_.ring_run_count, tile);
                else
                    add(c_.runs, c_.run_count, tile);
            }
    }
    [[nodiscard]] QuadJob quad_job(Rect r) const noexcept {
        r.i1 = std::min(r.i1, s_.tables.rows - 2);
        r.j1 = std::min(r.j1, s_.tables.cols - 2);
        return {r, s_.tables.cols, StateImpl::fixed(s_.now), c_.kind.data(), {origin_.x, origin_.y, origin_.z}};
    }
    /// Six times the volume that touched faces span with the origin.
    [[nodiscard]] double volume() const noexcept { return volume(c_.runs, c_.run_count) + ring_volume(); }
    /// Of quads with a corner in the ring, and of border faces.
    [[nodiscard]] double ring_volume() const noexcept {
        double six = volume(c_.ring_runs, c_.ring_run_count);
        for (std::size_t k = 0; k + 2 < s_.faces.size(); k += 3)
            six += dot(at(s_.faces[k]), cross(at(s_.faces[k + 1]), at(s_.faces[k + 2])));
        return six;
    }
    [[nodiscard]] double volume(const Array<Rect>& runs, std::uint32_t count) const noexcept {
        double six = 0;
        for (std::uint32_t k = 0; k < count; ++k) {
            const QuadJob job = quad_job(runs[k]);
            if (!job.rect.empty()) six += c_.rows_of->volume(job);
        }
        return six;
    }
    [[nodiscard]] Double3 at(std::uint32_t k) const noexcept { return widen(s_.point(k)) - origin_; }
    [[nodiscard]] Double3 arrow(std::uint32_t k) const noexcept {
        return double{c_.weight[k]} * widen(StateImpl::at(s_.normal, k));
    }
    void cubic(double* c) const noexcept {
        for (std::uint32_t k = 0; k < c_.ring_run_count; ++k) {
            const QuadJob job = quad_job(c_.ring_runs[k]);
            if (!job.rect.empty()) c_.rows_of->cubic(job, StateImpl::fixed(s_.normal), c_.weight.data(), c);
        }
        for (std::size_t k = 0; k + 2 < s_.faces.size(); k += 3) {
            const Double3 p = at(s_.faces[k]), q = at(s_.faces[k + 1]), r = at(s_.faces[k + 2]);
            const Double3 a = arrow(s_.faces[k]), b = arrow(s_.faces[k + 1]), d = arrow(s_.faces[k + 2]);
            c[0] += dot(a, cross(q, r)) + dot(p, cross(b, r) + cross(q, d));
            c[1] += dot(p, cross(b, d)) + dot(a, cross(b, r) + cross(q, d));
            c[2] += dot(a, cross(b, d));
        }
    }

    // --- moving ---
    template <class F>
    void each_run(F f) const noexcept {
        for (std::uint32_t k = 0; k < c_.run_count; ++k) f(c_.runs[k]);
        for (std::uint32_t k = 0; k < c_.ring_run_count; ++k) f(c_.ring_runs[k]);
    }
    void save() noexcept {
        const Planes to = c_.before();
        const auto copy = [&](std::size_t k, std::size_t count) {
            std::copy_n(s_.now.x + k, count, to.x + k);
            std::copy_n(s_.now.y + k, count, to.y + k);
            std::copy_n(s_.now.z + k, count, to.z + k);
        };
        each_run([&](const Rect& r) {
            for (std::uint32_t i = r.i0; i <= r.i1; ++i) copy(std::size_t{i} * s_.tables.cols + r.j0, r.width());
        });
        copy(s_.tables.grid, s_.total() - s_.tables.grid);
    }
    void put(std::uint32_t k, Double3 p) noexcept {
        const Vec3 v = narrow(p);
        s_.now.x[k] = v.x;
        s_.now.y[k] = v.y;
        s_.now.z[k] = v.z;
    }
    void project_sample(std::uint32_t k) noexcept {
        if ((c_.marks[k] & kInside) == 0) return;
        const Double3 p = widen(s_.point(k));
        const Probe there = probe(shape_, p);
        const double m = mobility_of(s_, k);
        if (m == 0 || there.distance == 0) return;
        // The plane's own rounding, as of ContactRows::project.
        put(k, shape_.kind == ObstacleKind::Plane ? p - (there.distance * m) * shape_.normal
                                                  : p + m * (there.nearest - p));
    }
    template <class F>
    void each_sample(std::uint32_t tile, F f) const noexcept {
        const Rect r = s_.tile_rect(tile);
        for (std::uint32_t i = r.i0; i <= r.i1; ++i)
            for (std::uint32_t k = i * s_.tables.cols + r.j0; k <= i * s_.tables.cols + r.j1; ++k) f(k);
    }
    void project() noexcept {
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

    /// now = clamp(before + beta w n).
    void apply(double beta) noexcept {
        const bool clamp = o_.bulge == Bulge::Exact;
        BulgeJob job{};
        job.cols = s_.tables.cols;
        job.from = StateImpl::fixed(c_.before());
        job.normal = StateImpl::fixed(s_.normal);
        job.to = s_.now;
        job.weight = c_.weight.data();
        job.beta = static_cast<float>(beta);
        job.clamp = clamp && shape_.kind == ObstacleKind::Plane;
        job.n[0] = static_cast<float>(shape_.normal.x);
        job.n[1] = static_cast<float>(shape_.normal.y);
        job.n[2] = static_cast<float>(shape_.normal.z);
        job.d = static_cast<float>(shape_.offset);
        const auto put_back = [&](std::uint32_t k) {
            if (!(c_.weight[k] > 0)) return;
            const Probe there = probe(shape_, widen(s_.point(k)));
            if (there.distance < 0) put(k, there.nearest);
        };
        for (std::uint32_t e = 0; e < c_.ring_run_count; ++e) {
            job.rect = c_.ring_runs[e];
            c_.rows_of->bulge(job);
        }
        if (c_.border && s_.total() > s_.tables.grid) {
            job.rect = {0, 0, s_.tables.grid, s_.total() - 1};
            job.cols = 0;
            c_.rows_of->bulge(job);
        }
        if (!clamp || shape_.kind == ObstacleKind::Plane) return;
        for (std::uint32_t e = 0; e < c_.tile_count; ++e) {
            if ((c_.tile_bits[c_.tiles[e]] & kTilePsi) == 0) continue;
            Box box{{1e38f, 1e38f, 1e38f}, {-1e38f, -1e38f, -1e38f}};
            s_.rows_of->bounds(StateImpl::fixed(s_.now), s_.tile_rect(c_.tiles[e]), s_.tables.cols, box.low, box.high);
            if (box_distance(shape_, box) < 0) each_sample(c_.tiles[e], put_back);
        }
        if (c_.border)
            for (std::uint32_t k = s_.tables.grid; k < s_.total(); ++k) put_back(k);
    }

    void bulge() noexcept {
        double c[3] = {0, 0, 0};
        cubic(c);
        const double removed = before_ - projected_;
        // What is in no quad of the ring does not change any more.
        const auto gained = [&] { return ring_volume() + elsewhere_ - before_; };
        const auto value = [&](double b) { return ((c[2] * b + c[1]) * b + c[0]) * b - removed; };
        const auto slope = [&](double b) { return (3 * c[2] * b + 2 * c[1]) * b + c[0]; };
        const double first = removed / c[0];
        if (!std::isfinite(first) || removed == 0) return;
        report_.first_order_error = value(first) / removed;
        report_.paper_error = value(total_) / removed;
        if (o_.bulge == Bulge::Paper) {
            apply(total_);
            settle(total_, gained());
            return;
        }
        double beta = first;
        for (int k = 0; k < 12; ++k) {
            const double next = beta - value(beta) / slope(beta);
            if (!std::isfinite(next)) break;
            const bool done = std::fabs(next - beta) <= 1e-15 * std::fabs(next);
            beta = next;
            if (done) break;
        }
        // A ring too small for what it has to take may have no root near by: then the gradient's answer, and its error.
        if (!(beta * first > 0) || std::fabs(beta) > 4 * std::fabs(first)) beta = first;
        // The volume grows with |beta|, but with kinks where samples come to rest on the obstacle: secant steps, kept
        // between the largest height known to be too low and the lowest known to be too high.
        const double sign = removed * first > 0 ? 1 : -1;  // of the error where |beta| is too high, times that of beta
        double low = 0, high = std::numeric_limits<double>::infinity();
        double last = 0, last_error = -removed, older = 0, older_error = 0, best = 0, best_error = -removed;
        double aim = kPolished;
        while (true) {
            apply(beta);
            const double error = gained();
            settle(beta, error);
            const bool better = std::fabs(error) < std::fabs(best_error);
            if (better) {
                best = beta;
                best_error = error;
            }
            if (std::fabs(best_error) <= aim * std::fabs(removed) || report_.passes == kMaxPasses) {
                finish_bulge(best, best_error);
                if (std::fabs(report_.volume_error) <= 0.1 * kKept || report_.passes >= kMaxPasses) return;
                aim *= 1e-2;  // too few samples to take the rest: nearer first
            }
            (sign * error * first > 0 ? high : low) = std::fabs(beta);
            // Inverse quadratic interpolation where there are three points, else the secant.
            double next = std::fabs(beta - error * (beta - last) / (error - last_error));
            if (report_.passes > 1) {
                const double a = older_error, b = last_error, d = error;
                const double guess = older * b * d / ((a - b) * (a - d)) + last * a * d / ((b - a) * (b - d)) +
                                     beta * a * b / ((d - a) * (d - b));
                if (std::fabs(guess) > low && std::fabs(guess) < high) next = std::fabs(guess);
            }
            if (!(next > low && next < high)) next = std::isinf(high) ? 2 * low : 0.5 * (low + high);
            if (next > 64 * std::fabs(first) || next == std::fabs(beta)) return finish_bulge(best, best_error);
            older = last;
            older_error = last_error;
            last = beta;
            last_error = error;
            beta = std::copysign(next, first);
        }
    }
    void finish_bulge(double best, double error) noexcept {
        if (report_.beta != static_cast<float>(best)) {
            apply(best);
            settle(best, error);
        }
        if (std::fabs(error) > kAimed * std::fabs(before_ - projected_)) polish(error);
    }
    void settle(double beta, double error) noexcept {
        ++report_.passes;
        report_.beta = static_cast<float>(beta);
        report_.volume_error = error / (before_ - projected_);
    }

    /// Puts a small remaining error on a few samples that are free to move, one after another.
    void polish(double error) noexcept {
        if (std::fabs(error) > 1e-3 * std::fabs(before_ - projected_)) return;
        constexpr std::uint32_t kSamples = 32;
        std::uint32_t chosen[kSamples], count = 0;
        const std::uint32_t cols = s_.tables.cols;
        for (std::uint32_t e = 0; e < c_.tile_count && count < kSamples; ++e) {
            if ((c_.tile_bits[c_.tiles[e]] & kTilePsi) == 0) continue;
            std::uint32_t best = kNone;
            each_sample(c_.tiles[e], [&](std::uint32_t k) {
                if (c_.weight[k] > 0.25f && (s_.ring[k] & kRingIrregular) == 0 &&
                    (best == kNone || c_.weight[k] < c_.weight[best]))
                    best = k;
            });
            if (best != kNone && probe(shape_, widen(s_.point(best))).distance > 1e-3 * double{s_.mean_step})
                chosen[count++] = best;
        }
        double left = error / 6;
        for (std::uint32_t e = 0; e < count; ++e) {
            const std::uint32_t k = chosen[e];
            // Gradient of the volume: a sixth of the ring's area vectors.
            Double3 g;
            const Double3 o = widen(s_.point(k));
            for (const std::uint32_t a : {k, k - 1, k - cols, k - cols - 1}) {
                const std::uint32_t qi = a / cols, qj = a % cols;
                for (const auto& f : quad_triangles(qi, qj, cols, s_.tables.diagonal(qi, qj)))
                    if (f[0] == k || f[1] == k || f[2] == k)
                        g = g + cross(widen(s_.point(f[1])) - widen(s_.point(f[0])),
                                      widen(s_.point(f[2])) - widen(s_.point(f[0])));
            }
            g = (1.0 / 6) * g;
            const Double3 n = widen(StateImpl::at(s_.normal, k));
            const double rate = dot(g, n);
            if (!(rate != 0)) continue;
            const double step = -left / (count - e) / rate;
            if (!(std::fabs(step) < 0.01 * double{s_.mean_step})) continue;
            put(k, o + step * n);
            left += dot(g, widen(s_.point(k)) - o);
        }
        report_.volume_error = (ring_volume() + elsewhere_ - before_) / (before_ - projected_);
    }

    // --- afterwards ---
    /// Plastic: the permanent shape moves as the present one did.
    void keep() noexcept {
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
    void touch() noexcept {
        RectList moved;
        each_run([&](const Rect& r) { moved.add(r); });
        if (c_.border) {
            moved.add_border(s_.tables.grid);
            moved.add_border(s_.total() - 1);
        }
        s_.touch(moved, o_.mode == DeformMode::Plastic);
    }
    ContactReport finish(ContactStatus status) noexcept {
        report_.status = status;
        const auto clear = [&](std::size_t k, std::size_t count) {
            std::fill_n(c_.marks.data() + k, count, std::uint8_t{0});
            std::fill_n(c_.weight.data() + k, count, 0.0f);
            std::fill_n(c_.square.data() + k, count, std::numeric_limits<float>::infinity());
        };
        for (std::uint32_t e = 0; e < c_.tile_count; ++e) {
            Rect r = s_.tile_rect(c_.tiles[e]);
            // Nodes of the tiles after it may lie on the next row and column.
            r.i1 = std::min(r.i1 + 1, s_.tables.rows - 1);
            r.j1 = std::min(r.j1 + 1, s_.tables.cols - 1);
            for (std::uint32_t i = r.i0; i <= r.i1; ++i) clear(std::size_t{i} * s_.tables.cols + r.j0, r.width());
            c_.tile_bits[c_.tiles[e]] = 0;
        }
        if (c_.border) clear(s_.tables.grid, s_.total() - s_.tables.grid);
        c_.tile_count = 0;
        c_.border = false;
        return report_;
    }

    StateImpl& s_;
    ContactImpl& c_;
    const Shape& shape_;
    const ContactOptions& o_;
    ContactReport report_;
    double tolerance_ = 0, total_ = 0;
    Double3 origin_;
    double before_ = 0, projected_ = 0;
    double elsewhere_ = 0;  ///< six times the projected volume of touched quads that have no corner in the ring
};

Result<void> check(const StateImpl& s, const ContactImpl& c, const ContactOptions& o) noexcept {
    if (c.rows != s.tables.rows || c.cols != s.tables.cols || c.total != s.tables.total || c.closed == s.open_surface)
        return Error{ErrorCode::BadArgument, kNoOffset, "the solver was made for another state"};
    if (!(o.max_depth >= 0) || !(o.max_total >= 0))
        return Error{ErrorCode::BadArgument, kNoOffset, "a limit of the contact is negative or not a number"};
    if (o.rings.size() > 16 || o.smoothing > 64)
        return Error{ErrorCode::BadArgument, kNoOffset, "more ring sizes or rounds of smoothing than allowed"};
    for (const RingSize& r : o.rings)
        if (!std::isfinite(r.total) || !std::isfinite(r.reach) || !(r.reach > 0) || !std::isfinite(r.sigma) ||
            !(r.sigma > 0))
            return Error{ErrorCode::BadArgument, kNoOffset, "a ring size is not a positive number"};
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
    return detail::Resolver(s, c, shape.value(), options).run();
}

}  // namespace dgm
