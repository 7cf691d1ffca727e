// SPDX-License-Identifier: MIT
// libdgm/src/contact_bulge.cpp
// The volume kept as in methods section 6.
//
// x' is the shape after projecting Phi, b_i = w_i n_i the bulge of Psi. The volume of x' + beta b is a cubic in beta;
// its root is found by Newton's method from the first-order answer. Samples that this would take beyond the obstacle
// are put back on it, and the volume that costs is fetched by secant steps on the volume measured. What rounding to
// float leaves is put on a few samples one after another, the volume being linear in each.
#include <algorithm>
#include <cmath>
#include <limits>

#include "contact_resolver.h"

namespace dgm::detail {
namespace {
constexpr double kPolished = 1e-5;  // of the removed volume: what a few samples can take without showing it
constexpr double kAimed = 1e-8;
constexpr std::uint32_t kMaxPasses = 10;
}  // namespace

void Resolver::weigh() noexcept {
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

double Resolver::ring_volume() const noexcept {
    double six = volume(c_.ring_runs, c_.ring_run_count);
    for (std::size_t k = 0; k + 2 < s_.faces.size(); k += 3)
        six += dot(at(s_.faces[k]), cross(at(s_.faces[k + 1]), at(s_.faces[k + 2])));
    return six;
}

double Resolver::volume(const Array<Rect>& runs, std::uint32_t count) const noexcept {
    double six = 0;
    for (std::uint32_t k = 0; k < count; ++k) {
        const QuadJob job = quad_job(runs[k]);
        if (!job.rect.empty()) six += c_.rows_of->volume(job);
    }
    return six;
}

void Resolver::cubic(double* c) const noexcept {
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

void Resolver::apply(double beta) noexcept {
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

void Resolver::bulge() noexcept {
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

void Resolver::finish_bulge(double best, double error) noexcept {
    if (report_.beta != static_cast<float>(best)) {
        apply(best);
        settle(best, error);
    }
    if (std::fabs(error) > kAimed * std::fabs(before_ - projected_)) polish(error);
}

void Resolver::settle(double beta, double error) noexcept {
    ++report_.passes;
    report_.beta = static_cast<float>(beta);
    report_.volume_error = error / (before_ - projected_);
}

void Resolver::polish(double error) noexcept {
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

}  // namespace dgm::detail
