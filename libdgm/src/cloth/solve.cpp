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

namespace dgm::detail::cloth {
namespace {

constexpr std::uint32_t kSweeps[] = {1, 2, 4}, kSweepsAtTheEnd = 24;  // by level, the last of them below
constexpr float kBand = 16;  ///< highest eigenvalue over the lowest one that a level is to damp

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

/// What bends across seams, in the diagonal blocks.
void add_seams(const Level& l) noexcept {
    for (const SeamStencil& s : l.seams)
        for (int d = 0; d < 3; ++d)
            for (const auto& weight : s.weight) {
                float middle = 0;
                for (int w = 0; w < 4; ++w) {
                    l.inverse.p[d][s.spot[w + 1]] += s.bending * weight[w] * weight[w];
                    middle += weight[w];
                }
                l.inverse.p[d][s.spot[0]] += s.bending * middle * middle;
            }
}

void sum_blocks(const Level& l, const Blocks& of) noexcept {
    for (std::size_t g = 0; g < l.groups.size(); g += l.groups[g] + 1)
        for (float* p : of.p) {
            float sum = 0;
            for (std::uint32_t k = 1; k <= l.groups[g]; ++k) sum += p[l.groups[g + k]];
            for (std::uint32_t k = 1; k <= l.groups[g]; ++k) p[l.groups[g + k]] = sum;
        }
}

/// to = transpose of the interpolation.
void restrict_to(const ClothImpl& c, std::uint32_t at, const Field& from, const Field& to, const float* free,
                 int planes = 3) noexcept {
    const Level &fine = c.level[at], &coarse = c.level[at + 1];
    c.kernels->restrict_to({&fine.on, &coarse.on, coarse.even, coarse.from_rows.data(), coarse.from_columns.data(),
                            from, to, free, planes});
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

/// Contacts of a level as those of the next one: normals by stiffness; where they differ, all directions are held.
void take_contacts(const ClothImpl& c, std::uint32_t level) noexcept {
    const Level &fine = c.level[level - 1], &l = c.level[level];
    const bool any = std::any_of(fine.touched.begin(), fine.touched.end(), [](std::uint8_t t) { return t != 0; });
    const Sheet &f = fine.on, &on = l.on;
    std::fill(on.touched, on.touched + l.rows, std::uint8_t{0});
    std::fill(on.press, on.press + l.count, 0.0f);
    std::fill(on.drag, on.drag + l.count, 0.0f);
    if (!any) return;
    // `product` and `way` of the fine level are free now.
    for (int d = 0; d < 3; ++d)
        for (std::size_t k = 0; k < fine.count; ++k) fine.product.p[d][k] = f.press[k] * f.normal.p[d][k];
    restrict_to(c, level - 1, fine.product, on.normal, nullptr);
    restrict_to(c, level - 1, {{f.press, f.drag}}, {{on.press, on.drag}}, nullptr, 2);
    for (std::uint32_t i = 0; i < l.rows; ++i)
        for (std::uint32_t j = 0; j < l.cols; ++j) {
            const auto k = static_cast<Spot>(i * on.pitch + j);
            const Double3 sum = at(on.normal, k);
            const double length = std::sqrt(dot(sum, sum)), whole = std::max(double{on.press[k]}, length);
            on.drag[k] = std::max(on.drag[k], 0.0f);
            if (!(whole > 0)) continue;
            l.on.touched[i] = 1;
            put(on.normal, k, length > 0 ? (1 / length) * sum : Double3{});
            const double lost = std::max(0.0, whole - length) + double{on.drag[k]};
            on.drag[k] = static_cast<float>(lost);
            on.press[k] = static_cast<float>(length + lost);
        }
}

/// The four ways from a sample to its neighbours.
constexpr int kWays[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};

/// Which held samples are clamped: held together with a neighbour of the finest level, so that they do not turn either.
void find_clamps(ClothImpl& c, std::uint32_t at) noexcept {
    Level& l = c.level[at];
    for (std::uint32_t i = 0; i < l.rows; ++i)
        for (std::uint32_t j = 0; j < l.cols; ++j) {
            std::uint8_t& bits = l.clamped[i * l.cols + j];
            bits = 0;
            if (l.free[i * l.on.pitch + j] != 0) continue;
            for (int w = 0; w < 4; ++w) {
                const std::uint32_t r = i + static_cast<std::uint32_t>(kWays[w][0]),
                                    s = j + static_cast<std::uint32_t>(kWays[w][1]);
                if (r < l.rows && s < l.cols && l.free[r * l.on.pitch + s] == 0)
                    bits |= static_cast<std::uint8_t>(1 << w);
            }
            if (at > 0) bits |= c.level[at - 1].clamped[l.row_of[i] * c.level[at - 1].cols + l.column_of[j]];
        }
}
/// What is held, on all levels.
void hold(ClothImpl& c) noexcept {
    for (std::uint32_t k = 0; k < c.levels; ++k) {
        Level& l = c.level[k];
        for (std::uint32_t i = 0; k > 0 && i < l.rows; ++i)
            for (std::uint32_t j = 0; j < l.cols; ++j) {
                const Level& fine = c.level[k - 1];
                l.free[i * l.on.pitch + j] = fine.free[l.row_of[i] * fine.on.pitch + l.column_of[j]];
            }
        find_clamps(c, k);
    }
}
/// Beside a clamped sample a coarse level bends as if it were mirrored there.
void add_clamps(Level& l, float density) noexcept {
    const Sheet& on = l.on;
    for (std::uint32_t i = 0; i < l.rows; ++i)
        for (std::uint32_t j = 0; j < l.cols; ++j) {
            const std::uint8_t bits = l.clamped[i * l.cols + j];
            for (int w = 0; bits != 0 && w < 4; ++w) {
                const std::uint32_t r = i + static_cast<std::uint32_t>(kWays[w][0]),
                                    s = j + static_cast<std::uint32_t>(kWays[w][1]);
                if ((bits >> w & 1) == 0 || r >= l.rows || s >= l.cols) continue;
                const auto to = static_cast<Spot>(r * on.pitch + s);
                const std::uint32_t q = std::min({i, r, l.rows - 2}), p = std::min({j, s, l.cols - 2});
                const auto quad = static_cast<Spot>(q * on.pitch + p);
                const float by = w < 2 ? on.q11[quad] : on.q22[quad];
                const float mass = on.mass[i * on.pitch + j] / density;
                const float add = 4 * on.plate * mass * ((by * by) * (by * by));
                on.press[to] += add;
                on.drag[to] += add;
                on.touched[r] = 1;
            }
        }
}

/// No sample has copies, and nothing bends across seams: rows can be used as they come.
bool is_whole(const Level& l) noexcept {
    return l.groups.empty() && l.seams.empty();
}

/// Steps of the smoother, one after the other: way = keep way + step inverse residual.
struct Chebyshev {
    float middle, half, rho, keep = 0, step;
    explicit Chebyshev(const ClothImpl& c) noexcept {
        const float high = c.highest, low = high / kBand;
        middle = 0.5f * (high + low);
        half = 0.5f * (high - low);
        rho = half / middle;
        step = 1 / middle;
    }
    void go_on() noexcept {
        const float next = 1 / (2 * middle / half - rho);
        keep = rho * next;
        step = 2 * next / half;
        rho = next;
    }
};

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
        return {l.on, kind, by_dt2, from, {}, l.right, l.residual, l.sum, {}, l.inverse, 0, 0, l.own, l.free, nullptr};
    }
    /// `count` steps of the smoother on sum, from 0 if `fresh`, and then the residual. begun: the first of them was done.
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
        sum_classes(l, l.residual);
    }

    /// sum = about the inverse of the matrix times `right`. begun: sum is what the smoother begins with.
    void run(std::uint32_t at, bool begun = false) const noexcept {
        Level& l = c.level[at];
        if (at + 1 == levels) return smooth(l, kSweepsAtTheEnd, true);
        const std::uint32_t sweeps = kSweeps[std::min(at, 2U)];
        smooth(l, sweeps, true, begun);
        Level& next = c.level[at + 1];
        restrict_to(c, at, l.residual, next.right, next.free);
        sum_classes(next, next.right);
        run(at + 1);
        c.kernels->interpolate_to(
            {&l.on, &next.on, next.even, next.to_row.data(), next.to_column.data(), next.sum, l.sum, l.free, 3});
        even_out(l, l.sum);
        smooth(l, sweeps, false);
    }
};
}  // namespace

void sum_classes(const Level& l, const Field& f) noexcept {
    for (std::size_t g = 0; g < l.groups.size(); g += l.groups[g] + 1)
        for (float* p : f.p) {
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
    sum_classes(l, to);
}

double prepare(ClothImpl& c, float by_dt2, std::uint32_t levels) noexcept {
    if (c.held_anew) hold(c);
    c.held_anew = false;
    for (std::uint32_t k = 1; k < levels; ++k) {
        const Level &l = c.level[k], &before = c.level[k - 1];
        const Sheet& fine = before.on;
        ThinJob thin{&fine, &l.on, {}, l.even, l.row_of.data(), l.column_of.data(), fine.tension1, fine.tension2};
        if (k == 1) {
            for (int d = 0; d < 3; ++d) thin.at[d] = before.at[d];
            thin.tension1 = fine.s1;
            thin.tension2 = fine.s2;
        }
        c.kernels->thin(thin);
    }
    double whole = 0;
    for (std::uint32_t k = 0; k < levels; ++k) {
        Level& l = c.level[k];
        if (k > 0) {
            c.kernels->stiffen(l.on);
            take_contacts(c, k);
            add_clamps(l, c.options.fabric.density);
        }
        InvertJob invert{l.count, l.inverse, l.free, l.own, {}, {}, {}, 0};
        if (k == 0) {
            invert.gradient = c.gradient;
            invert.right = l.right;
            invert.sum = l.sum;
            invert.step = Chebyshev(c).step;
        }
        double square = c.kernels->diagonal({l.on, by_dt2, is_whole(l), invert});
        if (!is_whole(l)) {
            add_seams(l);
            sum_blocks(l, l.inverse);
            square = c.kernels->invert(invert);
        }
        if (k == 0) whole = square;
    }
    return whole;
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
        double slope = 0;
        if (!once) {
            slope = inner(l.right, l.sum);
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
