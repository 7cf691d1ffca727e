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

constexpr std::uint32_t kSweeps = 1, kCoarseSweeps = 4, kSweepsAtTheEnd = 24;
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

void sum_blocks(const Level& l, const Blocks& of) noexcept {
    for (std::size_t g = 0; g < l.groups.size(); g += l.groups[g] + 1)
        for (float* p : of.p) {
            float sum = 0;
            for (std::uint32_t k = 1; k <= l.groups[g]; ++k) sum += p[l.groups[g + k]];
            for (std::uint32_t k = 1; k <= l.groups[g]; ++k) p[l.groups[g + k]] = sum;
        }
}

/// line = weighted sum of rows.
void sum_rows(const Taps& t, const float* from, std::ptrdiff_t pitch, float* line) noexcept {
    for (std::uint32_t k = 0; k < t.count; ++k) {
        const float *row = from + static_cast<std::ptrdiff_t>(t.at[k]) * pitch, by = t.weight[k];
        if (k == 0)
            for (std::ptrdiff_t j = 0; j < pitch; ++j) line[j] = by * row[j];
        else
            for (std::ptrdiff_t j = 0; j < pitch; ++j) line[j] += by * row[j];
    }
}
float sum_taps(const Taps& t, const float* line) noexcept {
    float sum = 0;
    for (std::uint32_t k = 0; k < t.count; ++k) sum += t.weight[k] * line[t.at[k]];
    return sum;
}

/// to = transpose of the interpolation, of one plane.
void restrict_plane(const Level& fine, const Level& coarse, const float* from, float* to) noexcept {
    float* line = fine.on.scratch + kBlock;
    for (std::uint32_t i = 0; i < coarse.rows; ++i) {
        sum_rows(coarse.from_rows[i], from, fine.on.pitch, line);
        float* out = to + i * coarse.on.pitch;
        for (std::uint32_t j = 0; j < coarse.cols; ++j) out[j] = sum_taps(coarse.from_columns[j], line);
    }
}

/// to += interpolation of a coarse plane, but where samples are held.
void interpolate_plane(const Level& fine, const Level& coarse, const float* from, float* to) noexcept {
    float* line = fine.on.scratch + kBlock;
    for (std::uint32_t i = 0; i < fine.rows; ++i) {
        sum_rows(coarse.to_row[i], from, coarse.on.pitch, line);
        float* out = to + i * fine.on.pitch;
        const float* free = fine.free + i * fine.on.pitch;
        for (std::uint32_t j = 0; j < fine.cols; ++j) out[j] += free[j] * sum_taps(coarse.to_column[j], line);
    }
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

/// Mean over the fine quads in a coarse one.
void average_quads(const Level& fine, const Level& coarse, const float* from, float* to) noexcept {
    for (std::uint32_t i = 0; i + 1 < coarse.rows; ++i) {
        const std::ptrdiff_t n = fine.on.pitch;
        const float* first = from + coarse.row_of[i] * n;
        const float* second = coarse.row_of[i + 1] - coarse.row_of[i] == 2 ? first + n : first;
        float* out = to + i * coarse.on.pitch;
        for (std::uint32_t j = 0; j + 1 < coarse.cols; ++j) {
            const std::uint32_t a = coarse.column_of[j], b = coarse.column_of[j + 1] - 1;
            out[j] = 0.25f * ((first[a] + first[b]) + (second[a] + second[b]));
        }
    }
}

/// Contacts of a level as those of the next one: normals by stiffness; where they differ, all directions are held.
void take_contacts(const Level& fine, const Level& l) noexcept {
    const bool any = std::any_of(fine.touched.begin(), fine.touched.end(), [](std::uint8_t t) { return t != 0; });
    const Sheet &f = fine.on, &on = l.on;
    std::fill(on.touched, on.touched + l.rows, std::uint8_t{0});
    std::fill(on.press, on.press + l.count, 0.0f);
    std::fill(on.drag, on.drag + l.count, 0.0f);
    if (!any) return;
    // `product` and `way` of the fine level are free now.
    for (int c = 0; c < 3; ++c) {
        for (std::size_t k = 0; k < fine.count; ++k) fine.product.p[c][k] = f.press[k] * f.normal.p[c][k];
        restrict_plane(fine, l, fine.product.p[c], on.normal.p[c]);
    }
    restrict_plane(fine, l, f.press, on.press);
    restrict_plane(fine, l, f.drag, on.drag);
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

struct Cycle {
    ClothImpl& c;
    float by_dt2;
    std::uint32_t levels;

    /// `count` steps of the smoother on sum, from `residual` on. `fresh`: sum is 0 so far.
    void smooth(Level& l, std::uint32_t count, bool fresh) const noexcept {
        const float high = c.highest, low = high / kBand, middle = 0.5f * (high + low), half = 0.5f * (high - low);
        float rho = half / middle;
        SweepJob job{
            l.count, l.product, l.residual, l.way, l.sum, l.inverse, 0, 1 / middle, fresh ? Sweep::Begin : Sweep::GoOn};
        c.kernels->sweep(job);
        for (std::uint32_t k = 1; k < count; ++k) {
            const float next = 1 / (2 * middle / half - rho);
            job.keep = rho * next;
            job.step = 2 * next / half;
            rho = next;
            job.kind = Sweep::Next;
            apply(c, l, l.way, l.product, by_dt2);
            c.kernels->sweep(job);
        }
    }
    /// residual = right - matrix sum.
    void find_residual(Level& l) const noexcept {
        c.kernels->product({l.on, l.sum, l.residual, by_dt2, l.right, l.own, l.free});
        if (!l.seams.empty()) {
            for (float* p : l.product.p) std::fill(p, p + l.count, 0.0f);
            bend_seams(l, l.sum, l.product, false);
            c.kernels->add({l.count, 1, -1, l.residual, l.product, l.residual, l.free});
        }
        sum_classes(l, l.residual);
    }

    /// sum = about the inverse of the matrix times `right`.
    void run(std::uint32_t at) const noexcept {
        Level& l = c.level[at];
        for (int d = 0; d < 3; ++d) std::copy(l.right.p[d], l.right.p[d] + l.count, l.residual.p[d]);
        if (at + 1 == levels) return smooth(l, kSweepsAtTheEnd, true);
        const std::uint32_t sweeps = at == 0 ? kSweeps : kCoarseSweeps;
        smooth(l, sweeps, true);
        Level& next = c.level[at + 1];
        find_residual(l);
        for (float* p : l.residual.p)  // a class counts once
            for (std::size_t g = 0; g < l.groups.size(); g += l.groups[g] + 1)
                for (std::uint32_t k = 1; k <= l.groups[g]; ++k) p[l.groups[g + k]] /= static_cast<float>(l.groups[g]);
        for (int d = 0; d < 3; ++d) restrict_plane(l, next, l.residual.p[d], next.right.p[d]);
        sum_classes(next, next.right);
        for (float* p : next.right.p)
            for (std::size_t k = 0; k < next.count; ++k) p[k] *= next.free[k];
        run(at + 1);
        for (int d = 0; d < 3; ++d) interpolate_plane(l, next, next.sum.p[d], l.sum.p[d]);
        even_out(l, l.sum);
        find_residual(l);
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
    c.kernels->product({l.on, from, to, by_dt2, {}, nullptr, nullptr});
    bend_seams(l, from, to, false);
    sum_classes(l, to);
}

void prepare(ClothImpl& c, float by_dt2, std::uint32_t levels) noexcept {
    for (std::uint32_t k = 0; k < levels; ++k) {
        Level& l = c.level[k];
        if (k > 0) {
            const Level& fine = c.level[k - 1];
            for (std::uint32_t i = 0; i < l.rows; ++i)
                for (std::uint32_t j = 0; j < l.cols; ++j) {
                    const auto to = static_cast<Spot>(i * l.on.pitch + j);
                    const auto from = static_cast<Spot>(l.row_of[i] * fine.on.pitch + l.column_of[j]);
                    for (int d = 0; d < 3; ++d) l.at[d][to] = fine.at[d][from];
                    l.free[to] = fine.free[from];
                }
            c.kernels->edges({{l.at[0], l.at[1], l.at[2]}, l.on});
            average_quads(fine, l, k == 1 ? fine.on.s1 : fine.on.tension1, l.on.tension1);
            average_quads(fine, l, k == 1 ? fine.on.s2 : fine.on.tension2, l.on.tension2);
            average_quads(fine, l, fine.on.square1, l.on.square1);
            average_quads(fine, l, fine.on.square2, l.on.square2);
            c.kernels->stiffen(l.on);
            take_contacts(fine, l);
        }
        find_clamps(c, k);
        if (k > 0) add_clamps(l, c.options.fabric.density);
        c.kernels->diagonal({l.on, l.inverse, by_dt2});
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
        sum_blocks(l, l.inverse);
        c.kernels->invert({l.count, l.inverse, l.free});
    }
}

double solve(ClothImpl& c, float by_dt2, std::uint32_t levels, std::uint32_t cycles) noexcept {
    Level& l = c.fine();
    const Kernels& kernels = *c.kernels;
    const Cycle cycle{c, by_dt2, levels};
    const auto inner = [&](const Field& a, const Field& b) { return kernels.inner(l.count, l.own, a, b); };
    kernels.add({l.count, -1, 0, c.gradient, c.gradient, l.right, l.free});
    const double whole = inner(l.right, l.right);
    double left = whole, before = 0;
    std::uint32_t done = 0;
    bool found = false;
    for (; done < cycles && left > 0; ++done) {
        cycle.run(0);
        const double slope = inner(l.right, l.sum);
        const double keep = done == 0 ? 0 : std::max(0.0, (slope - inner(c.before, l.sum)) / before);
        const Field& last = done == 0 ? l.sum : c.way;
        kernels.add({l.count, 1, static_cast<float>(keep), l.sum, last, c.way, l.free});
        apply(c, l, c.way, c.image, by_dt2);
        const double curve = inner(c.way, c.image), first = done == 0 ? slope : inner(l.right, c.way);
        if (!(curve > 0) || !(first > 0)) break;
        const auto by = static_cast<float>(first / curve);
        kernels.add(
            {l.count, done == 0 ? 0.0f : 1.0f, by, done == 0 ? c.way : c.correction, c.way, c.correction, l.free});
        found = true;
        if (done + 1 == cycles) {
            left = std::max(0.0, left - 2 * double{by} * inner(l.right, c.image) +
                                     double{by} * double{by} * inner(c.image, c.image));
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
