// SPDX-License-Identifier: MIT
// libdgm/src/physics/multigrid.cpp
// V-cycles over the strides of a map.
//
// The matrix of a step, mass + membrane + bending, is c0 M + c1 L + c2 L M^-1 L with one Laplacian L. A smoother of
// single samples sees the last term's couplings along the short sides of quads, which grow with the fourth power of
// their ratio, so it is not smoothed as it stands: (L + a M) M^-1 (L + b M) c2 is the same matrix or near it, and each
// factor is of second order, with 3 x 3 stencils. The inverse of the product is a V-cycle, the masses, and a V-cycle.
// With a != b that would not be symmetric; B M B + (b - a) B M A M B is, for A and B near the inverses of the factors.
//
// Smoother: Chebyshev polynomials of D^-1 A, the same number of steps before and after the coarse correction, so that
// the cycle is symmetric. A polynomial needs no order of the samples: it gives the same bits whatever the number of
// lanes, and seam copies stay equal.
//
// [Adams, Brezina, Hu, Tuminaro 2003] Parallel multigrid smoothing: polynomial versus Gauss-Seidel.
// [Saad 2003] Iterative methods for sparse linear systems, algorithm 12.1: the recurrence.
#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/level.h"

namespace dgm::detail::physics {
namespace {

constexpr int kSteps[] = {4, 6, 8, 12, 16};  ///< of the smoother, before and after: see choose_steps()
constexpr double kEnough = 0.5;              ///< share of an error that a cycle may leave
constexpr double kMargin = 1.1;              ///< power iterations end below the largest eigenvalue

/// Steps of the Chebyshev recurrence: the first one's factor, then (keep, step) of the others.
struct Chebyshev {
    double theta, delta, sigma, rho;
    Chebyshev(double largest, int count) noexcept {
        // Errors between `low` and `high` shrink to a seventh, whatever the count.
        const double high = kMargin * largest, low = 1.6 * high / (count * count);
        theta = (high + low) / 2;
        delta = (high - low) / 2;
        sigma = theta / delta;
        rho = 1 / sigma;
    }
    std::pair<float, float> next() noexcept {
        const double fresh = 1 / (2 * sigma - rho), keep = fresh * rho;
        rho = fresh;
        return {static_cast<float>(keep), static_cast<float>(2 * fresh / delta)};
    }
};

struct Step {
    float keep = 0, step = 0, carry = 0;
};
/// r -= (A + extra) way on a level; next = keep way + step D^-1 r and x += next + carry way unless `next` is empty.
///
/// The residual of a class stands at its first sample, as does its `extra`; its other copies hold 0. Each copy has a
/// part of the class's row.
void sweep_level(const Multigrid& m, const Level& l, int which, const Field& way, const Field& next, Step by) noexcept {
    const float *extra = l.extra[which], *inverse = l.inverse[which];
    const bool both = next.p[0] != nullptr;
    // What the loop over all samples will overwrite.
    float *now = const_cast<float*>(l.rim_now.data()), *x_now = const_cast<float*>(l.late_now.data());
    const std::size_t late = l.late.size(), rim = l.rim.size();
    for (std::size_t p = 0; p < 3; ++p) {
        for (std::size_t k = 0; k < rim; ++k) {
            const std::uint32_t s = l.sample_of[l.rim[k]];
            float sum = 0;
            for (std::uint32_t e = l.rim_rows.start[k]; e < l.rim_rows.start[k + 1]; ++e)
                sum += l.rim_value[e] * way.p[p][l.rim_rows.col[e]];
            now[p * rim + k] = l.r.p[p][s] - (sum + extra[s] * way.p[p][s]);
        }
        if (!both) continue;
        for (std::size_t k = 0; k < late; ++k) x_now[p * late + k] = l.x.p[p][l.late[k]];
    }
    m.kernels->sweep({l.count(), static_cast<std::ptrdiff_t>(l.cols), l.stencil.data(), extra, inverse, way, l.r, next,
                      l.x, by.keep, by.step, by.carry});
    for (std::size_t p = 0; p < 3; ++p) {
        float* r = l.r.p[p];
        for (std::size_t k = 0; k < l.copies.size(); k += 2) {
            r[l.copies[k + 1]] += r[l.copies[k]];
            r[l.copies[k]] = 0;
        }
        for (std::size_t k = 0; k < rim; ++k) r[l.sample_of[l.rim[k]]] = now[p * rim + k];
        if (!both) continue;
        float *to = next.p[p], *x = l.x.p[p];
        for (std::size_t k = 0; k < late; ++k) {
            const std::uint32_t s = l.late[k];
            to[s] = by.keep * way.p[p][s] + (by.step * inverse[s]) * r[s];
            x[s] = x_now[p * late + k] + (to[s] + by.carry * way.p[p][s]);
        }
        for (std::size_t k = 0; k < l.copies.size(); k += 2) {
            to[l.copies[k]] = to[l.copies[k + 1]];
            x[l.copies[k]] = x[l.copies[k + 1]];
        }
    }
}
/// The other steps of a smoother whose first one is in `way`. @return where the last one is
const Field& smooth_on(const Multigrid& m, const Level& l, int which, Chebyshev& steps, const Field* way,
                       const Field* next) noexcept {
    for (int k = 1; k < m.steps; ++k) {
        const auto [keep, step] = steps.next();
        sweep_level(m, l, which, *way, *next, {keep, step, 0});
        std::swap(way, next);
    }
    return *way;
}
/// x = smoothing from 0, with the residual brought up to date.
void smooth_before(const Multigrid& m, const Level& l, int which) noexcept {
    Chebyshev steps(l.largest, m.steps);
    m.kernels->weigh(l.count(), l.d0, static_cast<float>(1 / steps.theta), l.inverse[which], l.r);
    share_copies(l, l.d0);
    for (int c = 0; c < 3; ++c) std::copy(l.d0.p[c], l.d0.p[c] + l.count(), l.x.p[c]);
    sweep_level(m, l, which, smooth_on(m, l, which, steps, &l.d0, &l.d1), {}, {});
}
/// x += the correction in l.d0, and smoothing after it.
void smooth_after(const Multigrid& m, const Level& l, int which) noexcept {
    Chebyshev steps(l.largest, m.steps);
    sweep_level(m, l, which, l.d0, l.d1, {0, static_cast<float>(1 / steps.theta), 1});
    smooth_on(m, l, which, steps, &l.d1, &l.d0);
}

/// Residual of the coarser level: weights 1/4, 1/2, 1 of the 3 x 3 around each sample; lists where those are others.
void restrict_residual(const Level& f, const Level& c) noexcept {
    if (f.odd_down.size() != c.dofs)
        for (int a = 0; a < 3; ++a)
            for (std::uint32_t i = 1; i + 1 < c.rows; ++i) {
                const float *mid = f.r.p[a] + std::size_t{2 * i} * f.cols, *up = mid - f.cols, *down = mid + f.cols;
                float* __restrict to = c.r.p[a] + std::size_t{i} * c.cols;
                for (std::uint32_t j = 1; j + 1 < c.cols; ++j) {
                    const std::uint32_t k = 2 * j;
                    const float left = 0.5f * (up[k - 1] + down[k - 1]) + mid[k - 1],
                                here = 0.5f * (up[k] + down[k]) + mid[k],
                                right = 0.5f * (up[k + 1] + down[k + 1]) + mid[k + 1];
                    to[j] = 0.5f * (left + right) + here;
                }
            }
    for (const std::uint32_t p : f.odd_down) {
        float sum[3] = {};
        for (std::uint32_t e = f.down.start[p]; e < f.down.start[p + 1]; ++e) {
            const std::uint32_t s = f.sample_of[f.down.col[e]];
            for (int a = 0; a < 3; ++a) sum[a] += f.down_weight[e] * f.r.p[a][s];
        }
        for (int a = 0; a < 3; ++a) c.r.p[a][c.sample_of[p]] = sum[a];
    }
}

/// f.d0 = the coarser level's x.
void interpolate(const Level& f, const Level& c) noexcept {
    const Field& to = f.d0;
    if (f.odd_up.size() != f.dofs)
        for (int a = 0; a < 3; ++a)
            for (std::uint32_t i = 1; i + 1 < f.rows; ++i) {
                const float *low = c.x.p[a] + std::size_t{i / 2} * c.cols, *high = low + i % 2 * c.cols;
                float* __restrict row = to.p[a] + std::size_t{i} * f.cols;
                float before = 0.5f * (low[0] + high[0]);
                for (std::uint32_t j = 0; 2 * j + 1 < f.cols; ++j) {
                    const float next = 0.5f * (low[j + 1] + high[j + 1]);
                    row[2 * j] = before;
                    row[2 * j + 1] = 0.5f * (before + next);
                    before = next;
                }
            }
    for (const std::uint32_t d : f.odd_up) {
        float sum[3] = {};
        for (std::uint32_t e = f.up.start[d]; e < f.up.start[d + 1]; ++e) {
            const std::uint32_t s = c.sample_of[f.up.col[e]];
            for (int a = 0; a < 3; ++a) sum[a] += f.up_weight[e] * c.x.p[a][s];
        }
        for (int a = 0; a < 3; ++a) to.p[a][f.sample_of[d]] = sum[a];
    }
    share_copies(f, to);
}

/// Cholesky factorisation of the coarsest matrix. @return false if it is not positive definite.
bool factorize(Multigrid& m, int which) noexcept {
    const Level& l = m.level[m.levels - 1];
    const std::uint32_t n = l.dofs;
    double* a = m.factor[which];
    std::fill(a, a + std::size_t{n} * n, 0.0);
    for (std::uint32_t d = 0; d < n; ++d) {
        for (std::uint32_t e = l.matrix.start[d]; e < l.matrix.start[d + 1]; ++e)
            a[d * n + l.matrix.col[e]] = l.value[e];
        a[d * n + d] += double{l.extra[which][l.sample_of[d]]};
    }
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = 0; j <= i; ++j) {
            double sum = a[i * n + j];
            for (std::uint32_t k = 0; k < j; ++k) sum -= a[i * n + k] * a[j * n + k];
            if (i != j)
                a[i * n + j] = sum / a[j * n + j];
            else if (sum > 0)
                a[i * n + i] = std::sqrt(sum);
            else
                return false;
        }
    return true;
}

void solve_directly(const Multigrid& m, Level& l, int which) noexcept {
    const std::uint32_t n = l.dofs;
    const double* a = m.factor[which];
    double y[kDirect];
    for (int c = 0; c < 3; ++c) {
        for (std::uint32_t i = 0; i < n; ++i) {
            double sum = l.r.p[c][l.sample_of[i]];
            for (std::uint32_t k = 0; k < i; ++k) sum -= a[i * n + k] * y[k];
            y[i] = sum / a[i * n + i];
        }
        for (std::uint32_t i = n; i-- > 0;) {
            double sum = y[i];
            for (std::uint32_t k = i + 1; k < n; ++k) sum -= a[k * n + i] * y[k];
            y[i] = sum / a[i * n + i];
            l.x.p[c][l.sample_of[i]] = static_cast<float>(y[i]);
        }
    }
    share_copies(l, l.x);
}

/// x of a level from its residual, by one V-cycle.
void run_level(Multigrid& m, std::uint32_t k, int which) noexcept {
    Level& l = m.level[k];
    if (k + 1 == m.levels) return solve_directly(m, l, which);
    for (float* r : l.r.p)
        for (std::size_t c = 0; c < l.copies.size(); c += 2) r[l.copies[c]] = 0;
    smooth_before(m, l, which);
    restrict_residual(l, m.level[k + 1]);
    run_level(m, k + 1, which);
    interpolate(l, m.level[k + 1]);
    smooth_after(m, l, which);
}

/// Rayleigh quotient of three vectors after some powers of D^-1 A.
double largest_of(const Multigrid& m, Level& l) noexcept {
    std::uint32_t random = 12345;
    for (int a = 0; a < 3; ++a)
        for (std::uint32_t d = 0; d < l.dofs; ++d) {
            random = random * 1664525u + 1013904223u;
            l.d0.p[a][l.sample_of[d]] = static_cast<float>(random >> 8) * 0x1p-23f - 1.0f;
        }
    share_copies(l, l.d0);
    double found = 0;
    for (int k = 0; k < 20; ++k) {
        for (float* p : l.r.p) std::fill(p, p + l.count(), 0.0f);
        sweep_level(m, l, 0, l.d0, {}, {});
        double above[3] = {}, below[3] = {};
        for (int a = 0; a < 3; ++a)
            for (std::uint32_t d = 0; d < l.dofs; ++d) {
                const std::uint32_t s = l.sample_of[d];
                const double w = l.d0.p[a][s];
                above[a] -= w * double{l.r.p[a][s]};
                below[a] += w * w * double{l.diagonal[s]};
            }
        for (int a = 0; a < 3; ++a) {
            if (!(below[a] > 0)) continue;
            const double quotient = above[a] / below[a];
            found = std::max(found, quotient);
            const auto scale = static_cast<float>(-1 / std::max(quotient, 1e-3));
            for (std::size_t s = 0; s < l.count(); ++s) l.d0.p[a][s] = scale * l.inverse[0][s] * l.r.p[a][s];
        }
        share_copies(l, l.d0);
    }
    return found > 0 ? found : 1;
}

/// Share of an error that a cycle leaves, at the worst of what a few cycles from a random one have not removed.
double left_by_cycle(Multigrid& m) noexcept {
    constexpr int kCycles = 12;
    Level& l = m.level[0];
    std::uint32_t random = 12345;
    for (float* e : l.kept.p)
        for (std::uint32_t d = 0; d < l.dofs; ++d) {
            random = random * 1664525u + 1013904223u;
            e[l.sample_of[d]] = static_cast<float>(random >> 8) * 0x1p-23f - 1.0f;
        }
    double before = 0, left = 0;
    for (int k = 0; k < kCycles; ++k) {
        share_copies(l, l.kept);
        for (float* r : l.r.p) std::fill(r, r + l.count(), 0.0f);
        sweep_level(m, l, 0, l.kept, {}, {});
        run_level(m, 0, 0);
        m.kernels->add(l.count(), l.kept, 1, l.x);
        const double now = m.kernels->inner(l.count(), l.diagonal, l.kept, l.kept);
        left = before > 0 ? std::sqrt(now / before) : 0;
        before = now;
    }
    return left;
}

/// Where quads are long or sheared, errors that single samples do not see are smooth along the strong couplings alone:
/// a polynomial of higher degree reaches them.
void choose_steps(Multigrid& m) noexcept {
    for (const int steps : kSteps) {
        m.steps = steps;
        if (left_by_cycle(m) <= kEnough) return;
    }
}
}  // namespace

void share_copies(const Level& l, const Field& f) noexcept {
    for (std::size_t k = 0; k < l.copies.size(); k += 2)
        for (float* p : f.p) p[l.copies[k]] = p[l.copies[k + 1]];
}

void take_extra(Multigrid& m) noexcept {
    const int factors = m.factors == Factors::Two ? 2 : 1;
    m.sound = true;
    for (int which = 0; which < factors; ++which) {
        for (std::uint32_t k = 0; k < m.levels; ++k) {
            Level& l = m.level[k];
            float* extra = l.extra[which];
            if (k == 0) {
                if (which == 1)
                    for (std::uint32_t s = 0; s < l.grid; ++s)
                        extra[s] = l.extra[0][s] + static_cast<float>(m.apart) * m.mass[s];
            } else {
                // Row sums of P^T diag(extra) P bound it from above: a coarse sample near a held one hardly moves.
                const Level& f = m.level[k - 1];
                for (std::uint32_t p = 0; p < l.dofs; ++p) {
                    float sum = 0;
                    for (std::uint32_t e = f.down.start[p]; e < f.down.start[p + 1]; ++e)
                        sum += f.down_weight[e] * f.extra[which][f.sample_of[f.down.col[e]]];
                    extra[l.sample_of[p]] = sum;
                }
            }
            for (std::size_t c = 0; c < l.copies.size(); c += 2) extra[l.copies[c]] = 0;  // see sweep_level()
            for (std::uint32_t s = 0; s < l.grid; ++s) {
                const float d = l.diagonal[s] + extra[s];
                l.inverse[which][s] = d > 0 ? 1 / d : 0;
            }
        }
        m.sound = factorize(m, which) && m.sound;
    }
}

void bound_eigenvalues(Multigrid& m) noexcept {
    // With `extra` the eigenvalues of (D + extra)^-1 (A + extra) lie between those of D^-1 A and 1.
    for (std::uint32_t k = 0; k + 1 < m.levels; ++k) m.level[k].largest = std::max(1.0, largest_of(m, m.level[k]));
    if (m.sound) choose_steps(m);
}

void run_cycle(Multigrid& m) noexcept {
    Level& l = m.level[0];
    const auto solve = [&](int which) { run_level(m, 0, which); };
    if (m.factors == Factors::One) return solve(0);
    const int outer = m.factors == Factors::Two ? 1 : 0;
    const auto weigh = [&](const Field& to, double factor) {
        m.kernels->weigh(l.count(), to, static_cast<float>(factor), m.mass, l.x);
    };
    const double by = 1 / m.scale;
    solve(outer);
    if (outer == 1) {
        weigh(l.kept, by);
        weigh(l.r, 1);
        solve(0);
        weigh(l.r, by * m.apart);
        m.kernels->add(l.count(), l.r, 1, l.kept);
    } else {
        weigh(l.r, by);
    }
    solve(outer);
}

}  // namespace dgm::detail::physics
