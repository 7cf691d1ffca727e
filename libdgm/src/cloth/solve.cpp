// SPDX-License-Identifier: MIT
// libdgm/src/cloth/solve.cpp
// Solves for the way of a substep: conjugate gradients, with a V-cycle over the map's strides as preconditioner.
//
// The matrix is that of the present shape: along threads it resists, across them only by tension, bending and mass. A
// coarse level has the same quads over every second sample. Level k + 1 hands its solution down by bilinear
// interpolation, and gets residuals by its transpose; samples of a seam share one unknown on all levels. The smoother
// is a Chebyshev polynomial [Adams et al. 2003] of the 3 x 3 blocks' inverse times the matrix.
#include <algorithm>
#include <cmath>

#include "cloth/cloth_impl.h"
#include "cloth/smoother.h"

namespace dgm::detail::cloth {
namespace {

constexpr std::uint32_t kSweeps[] = {1, 2, 4}, kSweepsAtTheEnd = 24;  // by level, the last of them below
static_assert(kSweeps[0] == 1);                                       // prepare() does the first one

constexpr float kHighestOfAll = 12;  ///< from which on the bound of eigenvalues is not raised any more

/// Adds what bends across seams: matrix times `from`, or with `slope` that of the shape `by` times `from` further.
/// @return energy
double bend_seams(const Level& l, const Field& from, const Field& to, bool slope, double by = 0) noexcept {
    const auto place = [&](int c, Spot k) { return l.at[c][k] + (by != 0 ? by * double{from.p[c][k]} : 0); };
    double energy = 0;
    for (const SeamStencil& s : l.seams) {
        Double3 normal;
        if (slope && (s.curved[0] != 0 || s.curved[1] != 0)) {
            const auto at = [&](int k) {
                return Double3{place(0, s.spot[k]), place(1, s.spot[k]), place(2, s.spot[k])};
            };
            normal = cross(at(1) - at(2), at(3) - at(4));
            const double length = std::sqrt(dot(normal, normal));
            normal = (length > 0 ? 1 / length : 0) * normal;
        }
        const double n[3] = {normal.x, normal.y, normal.z};
        for (int line = 0; line < 2; ++line)
            for (int c = 0; c < 3; ++c) {
                double sum = slope ? -double{s.curved[line]} * n[c] : 0;
                for (int k = 0; k < 4; ++k) {
                    const double way = slope ? place(c, s.spot[k + 1]) - place(c, s.spot[0])
                                             : double{from.p[c][s.spot[k + 1]]} - double{from.p[c][s.spot[0]]};
                    sum += double{s.weight[line][k]} * way;
                }
                energy += 0.5 * double{s.bending} * sum * sum;
                if (to.p[0] == nullptr) continue;
                const float moment = s.bending * static_cast<float>(sum);
                for (int k = 0; k < 4; ++k) {
                    to.p[c][s.spot[k + 1]] += s.weight[line][k] * moment;
                    to.p[c][s.spot[0]] -= s.weight[line][k] * moment;
                }
            }
    }
    return energy;
}

/// Copies get the mean over their class.
void even_out(const Level& l, const Field& f) noexcept {
    for (std::size_t g = 0; g < l.groups.size(); g += l.groups[g] + 1)
        for (float* p : f.p) {
            float sum = 0;
            for (std::uint32_t k = 1; k <= l.groups[g]; ++k) sum += p[l.groups[g + k]];
            sum = sum / static_cast<float>(l.groups[g]);
            for (std::uint32_t k = 1; k <= l.groups[g]; ++k) p[l.groups[g + k]] = sum;
        }
}

/// Products of one level, done together as far as there is room.
struct Wave {
    const ClothImpl& c;
    const Level& l;
    std::uint32_t count = 0;
    ProductJob jobs[kMostProducts];
    void add(const ProductJob& job) noexcept {
        if (count == kMostProducts) go();
        jobs[count] = job;
        const auto row = static_cast<std::size_t>(l.on.pitch) + 2 * kBlock;
        jobs[count].on.scratch += count * kScratchRows * row;
        ++count;
    }
    void go() noexcept {
        if (count > 0) c.kernels->products(jobs, count);
        count = 0;
    }
};

struct Cycle {
    ClothImpl& c;
    float by_dt2;
    std::uint32_t levels;
    double* dots = nullptr;  ///< of the finest level's solution, if all its rows can be used as they come

    [[nodiscard]] ProductJob job(const Level& l, Product kind, const Field& from) const noexcept {
        return {l.on,
                kind,
                by_dt2,
                from,
                {},
                l.right,
                l.residual,
                l.sum,
                {},
                l.inverse,
                0,
                0,
                is_whole(l) ? nullptr : l.own,
                l.free,
                nullptr};
    }
    /// `count` steps of the smoother on sum, from 0 if `fresh`, and then the residual. begun: the first one was done.
    void smooth_whole(const Level& l, std::uint32_t count, bool fresh, bool begun) const noexcept {
        Chebyshev by(c);
        Wave wave{c, l, 0, {}};
        const auto add = [&](Product kind, const Field& from, bool keeps) {
            ProductJob next = job(l, kind, from);
            if (keeps) next.way = l.way;
            next.keep = by.keep;
            next.step = by.step;
            wave.add(next);
        };
        if (!fresh)
            add(Product::Polish, l.sum, count > 1);
        else if (!begun)
            c.kernels->sweep(
                {l.count, l.right, {}, l.residual, l.way, l.sum, l.inverse, 0, by.step, Sweep::Begin, count > 1});
        for (std::uint32_t k = 1; k < count; ++k) {
            by.go_on();
            add(Product::Smooth, l.way, k + 1 < count);
        }
        if (fresh && count < kSweepsAtTheEnd) {
            wave.add(job(l, Product::Residual, l.sum));
            wave.jobs[wave.count - 1].to = l.residual;
        } else if (dots != nullptr && &l == &c.fine()) {
            wave.add(job(l, Product::Curve, l.sum));
            wave.jobs[wave.count - 1].dots = dots;
        }
        wave.go();
    }
    /// The same where samples have copies.
    void smooth_sewn(Level& l, std::uint32_t count, bool fresh, bool begun) const noexcept {
        Chebyshev by(c);
        const auto sweep = [&](Sweep kind) {
            c.kernels->sweep(
                {l.count, l.right, l.product, l.residual, l.way, l.sum, l.inverse, by.keep, by.step, kind, true});
        };
        if (!fresh) {
            find_residual(l);
            sweep(Sweep::GoOn);
        } else if (!begun) {
            sweep(Sweep::Begin);
        }
        for (std::uint32_t k = 1; k < count; ++k) {
            by.go_on();
            apply(c, l, l.way, l.product, by_dt2);
            sweep(Sweep::Next);
        }
        if (!fresh || count == kSweepsAtTheEnd) return;
        find_residual(l);
        for (float* p : l.residual.p)  // a class counts once
            for (std::size_t g = 0; g < l.groups.size(); g += l.groups[g] + 1)
                for (std::uint32_t k = 1; k <= l.groups[g]; ++k) p[l.groups[g + k]] /= static_cast<float>(l.groups[g]);
    }
    void smooth(Level& l, std::uint32_t count, bool fresh, bool begun = false) const noexcept {
        is_whole(l) ? smooth_whole(l, count, fresh, begun) : smooth_sewn(l, count, fresh, begun);
    }
    /// residual = right - matrix sum.
    void find_residual(Level& l) const noexcept {
        ProductJob product = job(l, Product::Residual, l.sum);
        product.to = l.residual;
        c.kernels->products(&product, 1);
        if (!l.seams.empty()) {
            for (float* p : l.product.p) std::fill(p, p + l.count, 0.0f);
            bend_seams(l, l.sum, l.product, false);
            c.kernels->add({l.count, 1, -1, l.residual, l.product, l.residual, l.free});
        }
        sum_classes(l, l.residual.p);
    }

    /// sum = about the inverse of the matrix times `right`. begun: sum is what the smoother begins with.
    void run(std::uint32_t at, bool begun = false) const noexcept {
        Level& l = c.level[at];
        if (at + 1 == levels) return smooth(l, kSweepsAtTheEnd, true);
        const std::uint32_t sweeps = kSweeps[std::min(at, 2U)];
        smooth(l, sweeps, true, begun);
        Level& next = c.level[at + 1];
        restrict_to(c, at, l.residual, next.right, next.free);
        sum_classes(next, next.right.p);
        run(at + 1);
        c.kernels->interpolate_to(
            {&l.on, &next.on, next.even, next.to_row.data(), next.to_column.data(), next.sum, l.sum, l.free, 3});
        even_out(l, l.sum);
        smooth(l, sweeps, false);
    }
};
}  // namespace

void sum_classes(const Level& l, std::span<float* const> rows) noexcept {
    for (std::size_t g = 0; g < l.groups.size(); g += l.groups[g] + 1)
        for (float* const p : rows) {
            float sum = 0;
            for (std::uint32_t k = 1; k <= l.groups[g]; ++k) sum += p[l.groups[g + k]];
            for (std::uint32_t k = 1; k <= l.groups[g]; ++k) p[l.groups[g + k]] = sum;
        }
}

double evaluate(ClothImpl& c, float by_dt2, double* inertia) noexcept {
    Level& l = c.fine();
    double unused = 0;
    const double energy = c.kernels->force({l.on,
                                            {l.at[0], l.at[1], l.at[2]},
                                            c.gradient,
                                            c.inertial,
                                            {},
                                            by_dt2,
                                            0,
                                            inertia != nullptr ? inertia : &unused});
    return energy + bend_seams(l, {}, c.gradient, true);
}

double energy_ahead(const ClothImpl& c, double by, double& inertia) noexcept {
    const Level& l = c.fine();
    const double length = by * c.led;
    const double energy =
        c.kernels->force({l.on, {l.at[0], l.at[1], l.at[2]}, {}, c.inertial, c.lead, 0, length, &inertia});
    return energy + bend_seams(l, c.lead, {}, true, length);
}

void apply(const ClothImpl& c, const Level& l, const Field& from, const Field& to, float by_dt2) noexcept {
    const ProductJob job{l.on, Product::Whole, by_dt2, from, to, {}, {}, {}, {}, {}, 0, 0, nullptr, nullptr, nullptr};
    c.kernels->products(&job, 1);
    bend_seams(l, from, to, false);
    sum_classes(l, to.p);
}

/// Where a cycle leads uphill, eigenvalues are beyond the smoother's bound, and it lets grow what it should damp. So it
/// is on narrow strips; a higher bound holds from then on. @return false: it is as high as it gets
bool raise_bound(ClothImpl& c) noexcept {
    if (c.highest >= kHighestOfAll) return false;
    c.highest *= 1.5f;
    return true;
}

double solve(ClothImpl& c, float by_dt2, std::uint32_t levels, std::uint32_t cycles) noexcept {
    const double whole = prepare(c, by_dt2, levels);
    Level& l = c.fine();
    const Kernels& kernels = *c.kernels;
    double dots[4];  // of the way: with its image, with the right side; of the image: with the right side, with itself
    const bool once = cycles == 1 && is_whole(l);
    const Cycle cycle{c, by_dt2, levels, once ? dots : nullptr};
    const auto inner = [&](const Field& a, const Field& b) { return kernels.inner(l.count, l.own, a, b); };
    double left = whole, before = 0;
    c.lead = l.sum;
    c.led = 0;
    for (std::uint32_t done = 0; done < cycles && left > 0; ++done) {
        cycle.run(0, done == 0);
        double slope = once ? 0 : inner(l.right, l.sum);
        while (!((once ? dots[1] : slope) > 0) && raise_bound(c)) {
            cycle.run(0);
            if (!once) slope = inner(l.right, l.sum);
        }
        if (!once) {
            const double keep = done == 0 ? 0 : std::max(0.0, (slope - inner(c.before, l.sum)) / before);
            kernels.add({l.count, 1, static_cast<float>(keep), l.sum, done == 0 ? l.sum : c.way, c.way, l.free});
            apply(c, l, c.way, c.image, by_dt2);
            dots[0] = inner(c.way, c.image);
            dots[1] = inner(l.right, c.way);
        }
        if (!(dots[0] > 0) || !(dots[1] > 0)) break;
        const double by = dots[1] / dots[0];
        if (once) {
            c.led = by;
        } else {
            const auto length = static_cast<float>(by);
            kernels.add({l.count, done == 0 ? 0.0f : 1.0f, length, done == 0 ? c.way : c.correction, c.way,
                         c.correction, l.free});
            c.lead = c.correction;
            c.led = 1;
        }
        if (done + 1 == cycles) {
            if (!once) {
                dots[2] = inner(l.right, c.image);
                dots[3] = inner(c.image, c.image);
            }
            left = std::max(0.0, left - 2 * by * dots[2] + by * by * dots[3]);
            break;
        }
        for (int d = 0; d < 3; ++d) std::copy(l.right.p[d], l.right.p[d] + l.count, c.before.p[d]);
        kernels.add({l.count, 1, -static_cast<float>(by), l.right, c.image, l.right, l.free});
        left = inner(l.right, l.right);
        before = slope;
    }
    return whole > 0 ? std::sqrt(left / whole) : 0;
}

}  // namespace dgm::detail::cloth
