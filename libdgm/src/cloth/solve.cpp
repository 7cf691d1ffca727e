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

struct Cycle {
    ClothImpl& c;
    float by_dt2;
    std::uint32_t levels;

    /// `count` steps of the smoother on sum, from 0 if `fresh`. begun: the first of them was done.
    void smooth(Level& l, std::uint32_t count, bool fresh, bool begun = false) const noexcept {
        const bool whole = is_whole(l);
        Chebyshev by(c);
        const auto sweep = [&](Sweep kind, bool keeps) {
            c.kernels->sweep({l.count, l.right, l.product, l.residual, l.way, l.sum, l.inverse, by.keep, by.step, kind,
                              keeps || !whole});
        };
        const auto multiply = [&](Product kind, const Field& from, bool keeps) {
            c.kernels->product({l.on,
                                kind,
                                by_dt2,
                                from,
                                {},
                                l.right,
                                l.residual,
                                l.sum,
                                keeps ? l.way : Field{},
                                l.inverse,
                                by.keep,
                                by.step,
                                l.own,
                                l.free,
                                nullptr});
        };
        if (fresh) {
            if (!begun) sweep(Sweep::Begin, count > 1);
        } else if (whole) {
            multiply(Product::Polish, l.sum, count > 1);
        } else {
            find_residual(l);
            sweep(Sweep::GoOn, true);
        }
        for (std::uint32_t k = 1; k < count; ++k) {
            by.go_on();
            if (whole) {
                multiply(Product::Smooth, l.way, k + 1 < count);
            } else {
                apply(c, l, l.way, l.product, by_dt2);
                sweep(Sweep::Next, true);
            }
        }
    }
    /// residual = right - matrix sum.
    void find_residual(Level& l) const noexcept {
        c.kernels->product({l.on,
                            Product::Residual,
                            by_dt2,
                            l.sum,
                            l.residual,
                            l.right,
                            {},
                            {},
                            {},
                            {},
                            0,
                            0,
                            l.own,
                            l.free,
                            nullptr});
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
        find_residual(l);
        for (float* p : l.residual.p)  // a class counts once
            for (std::size_t g = 0; g < l.groups.size(); g += l.groups[g] + 1)
                for (std::uint32_t k = 1; k <= l.groups[g]; ++k) p[l.groups[g + k]] /= static_cast<float>(l.groups[g]);
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

double evaluate(ClothImpl& c) noexcept {
    Level& l = c.fine();
    c.kernels->edges({{l.at[0], l.at[1], l.at[2]}, l.on});
    const double energy = c.kernels->force({l.on, c.gradient, {}, 0});
    return energy + bend_seams(l, {}, c.gradient, true);
}

double energy_ahead(const ClothImpl& c, double by) noexcept {
    const Level& l = c.fine();
    const double energy = c.kernels->force({l.on, {}, c.correction, static_cast<float>(by)});
    return energy + bend_seams(l, c.correction, {}, true, by);
}

void apply(const ClothImpl& c, const Level& l, const Field& from, const Field& to, float by_dt2) noexcept {
    c.kernels->product({l.on, Product::Whole, by_dt2, from, to, {}, {}, {}, {}, {}, 0, 0, nullptr, nullptr, nullptr});
    bend_seams(l, from, to, false);
    sum_classes(l, to);
}

double prepare(ClothImpl& c, float by_dt2, std::uint32_t levels) noexcept {
    if (c.held_anew) hold(c);
    c.held_anew = false;
    for (std::uint32_t k = 1; k < levels; ++k) {
        Level& l = c.level[k];
        const Sheet& fine = c.level[k - 1].on;
        c.kernels->thin({&fine, &l.on, l.even, l.row_of.data(), l.column_of.data(), k == 1 ? fine.s1 : fine.tension1,
                         k == 1 ? fine.s2 : fine.tension2});
        c.kernels->stiffen(l.on);
        take_contacts(c, k);
        add_clamps(l, c.options.fabric.density);
    }
    double whole = 0;
    for (std::uint32_t k = 0; k < levels; ++k) {  // from here on coarse levels have no edges any more
        Level& l = c.level[k];
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
    const Cycle cycle{c, by_dt2, levels};
    const auto inner = [&](const Field& a, const Field& b) { return kernels.inner(l.count, l.own, a, b); };
    double left = whole, before = 0;
    bool found = false;
    for (std::uint32_t done = 0; done < cycles && left > 0; ++done) {
        cycle.run(0, done == 0 && levels > 1);
        const bool first = done == 0, last = done + 1 == cycles;
        const Field& way = first && last ? l.sum : c.way;
        double slope = 0;
        if (!last || !first) {
            slope = inner(l.right, l.sum);
            const double keep = first ? 0 : std::max(0.0, (slope - inner(c.before, l.sum)) / before);
            kernels.add({l.count, 1, static_cast<float>(keep), l.sum, first ? l.sum : c.way, c.way, l.free});
        }
        double dots[4];  // of the way, its image and the right side
        if (last && is_whole(l)) {
            kernels.product(
                {l.on, Product::Curve, by_dt2, way, {}, l.right, {}, {}, {}, {}, 0, 0, l.own, l.free, dots});
        } else {
            apply(c, l, way, c.image, by_dt2);
            dots[0] = inner(way, c.image);
            dots[1] = inner(l.right, way);
        }
        if (!(dots[0] > 0) || !(dots[1] > 0)) break;
        const auto by = static_cast<float>(dots[1] / dots[0]);
        kernels.add({l.count, first ? 0.0f : 1.0f, by, first ? way : c.correction, way, c.correction, l.free});
        found = true;
        if (last) {
            if (!is_whole(l)) {
                dots[2] = inner(l.right, c.image);
                dots[3] = inner(c.image, c.image);
            }
            left = std::max(0.0, left - 2 * double{by} * dots[2] + double{by} * double{by} * dots[3]);
            break;
        }
        for (int d = 0; d < 3; ++d) std::copy(l.right.p[d], l.right.p[d] + l.count, c.before.p[d]);
        kernels.add({l.count, 1, -by, l.right, c.image, l.right, l.free});
        left = inner(l.right, l.right);
        before = slope;
    }
    if (!found)
        for (float* p : c.correction.p) std::fill(p, p + l.count, 0.0f);
    return whole > 0 ? std::sqrt(left / whole) : 0;
}

}  // namespace dgm::detail::cloth
