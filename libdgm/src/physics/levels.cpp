// SPDX-License-Identifier: MIT
// libdgm/src/physics/levels.cpp
// Builds the strides of a map as levels of a multigrid solver.
//
// Level k + 1 has every second row and column of level k, and its last ones. A sample between two others is
// interpolated as their mean, a class as the mean over its copies: that makes coarse functions continuous across seams
// wherever the nodes of the seam lie. Coarse matrices are P^T A P. So a coarse class couples with the 3 x 3 around its
// samples, but for nodes of seams at odd samples; those rows are kept as lists.
#include <algorithm>

#include "physics/level.h"

namespace dgm::detail::physics {
namespace {

/// Coarse place of a fine row, or of the two around it.
struct Between {
    std::uint32_t low, high;
    float weight;  ///< of each: 1 where low == high
};
std::uint32_t coarse_size(std::uint32_t fine) noexcept {
    return fine <= 5 ? fine : (fine - 1 + 1) / 2 + 1;
}
/// The last fine row is the last coarse one, whether their number is even or not.
Between between(std::uint32_t k, std::uint32_t fine, std::uint32_t coarse) noexcept {
    if (coarse == fine) return {k, k, 1};
    if (k + 1 == fine) return {coarse - 1, coarse - 1, 1};
    if (k % 2 == 0) return {k / 2, k / 2, 1};
    return {k / 2, k / 2 + 1, 0.5f};
}
std::uint32_t fine_of(std::uint32_t k, std::uint32_t fine, std::uint32_t coarse) noexcept {
    return coarse == fine ? k : std::min(2 * k, fine - 1);
}

bool make_coarse_samples(const Level& f, Level& c, const Allocator& a) noexcept {
    c.rows = coarse_size(f.rows);
    c.cols = coarse_size(f.cols);
    c.grid = c.rows * c.cols;
    Array<std::uint32_t> coarse_of;  // by fine unknown
    if (!c.dof_of.allocate(a, c.grid) || !coarse_of.allocate(a, f.dofs, ~0u)) return false;
    for (std::uint32_t i = 0; i < c.rows; ++i)
        for (std::uint32_t j = 0; j < c.cols; ++j) {
            const std::uint32_t d =
                f.dof_of[std::size_t{fine_of(i, f.rows, c.rows)} * f.cols + fine_of(j, f.cols, c.cols)];
            if (coarse_of[d] == ~0u) coarse_of[d] = c.dofs++;
            c.dof_of[std::size_t{i} * c.cols + j] = coarse_of[d];
        }
    return list_unknowns(c, a);
}

/// Lists the rows of a transposed pattern with its weights.
bool transpose(const Rows& from, const Array<float>& weight, std::uint32_t cols, Rows& to, Array<float>& to_weight,
               const Allocator& a) noexcept {
    const std::uint32_t entries = from.start[from.count()];  // lists may be longer
    if (!to.start.allocate(a, std::uint64_t{cols} + 2) || !to.col.allocate(a, entries) ||
        !to_weight.allocate(a, entries))
        return false;
    for (std::uint32_t e = 0; e < entries; ++e) ++to.start[from.col[e] + 2];
    for (std::size_t k = 2; k < to.start.size(); ++k) to.start[k] += to.start[k - 1];
    for (std::uint32_t r = 0; r < from.count(); ++r)
        for (std::uint32_t e = from.start[r]; e < from.start[r + 1]; ++e) {
            const std::uint32_t at = to.start[from.col[e] + 1]++;
            to.col[at] = r;
            to_weight[at] = weight[e];
        }
    return true;  // one entry of start more than rows: see Level::down
}

/// Interpolation of each fine unknown: the mean over its copies. Samples of a class need not be side by side, so they
/// are listed first.
bool make_interpolation(Level& f, const Level& c, const Allocator& a) noexcept {
    Array<std::uint32_t> first, next;  // samples of an unknown as a chain
    if (!first.allocate(a, f.dofs, ~0u) || !next.allocate(a, f.grid, ~0u)) return false;
    for (std::uint32_t s = f.grid; s-- > 0;) {
        next[s] = first[f.dof_of[s]];
        first[f.dof_of[s]] = s;
    }
    if (!f.up.start.allocate(a, std::uint64_t{f.dofs} + 1) || !f.up.col.allocate(a, 4 * std::uint64_t{f.grid}) ||
        !f.up_weight.allocate(a, 4 * std::uint64_t{f.grid}))
        return false;
    std::uint32_t at = 0;
    for (std::uint32_t d = 0; d < f.dofs; ++d) {
        const std::uint32_t begin = at;
        std::uint32_t copies = 0;
        for (std::uint32_t s = first[d]; s != ~0u; s = next[s]) ++copies;
        for (std::uint32_t s = first[d]; s != ~0u; s = next[s]) {
            const Between i = between(s / f.cols, f.rows, c.rows), j = between(s % f.cols, f.cols, c.cols);
            for (std::uint32_t ci = i.low; ci <= i.high; ++ci)
                for (std::uint32_t cj = j.low; cj <= j.high; ++cj) {
                    const std::uint32_t to = c.dof_of[std::size_t{ci} * c.cols + cj];
                    const float w = i.weight * j.weight / static_cast<float>(copies);
                    std::uint32_t e = begin;
                    while (e < at && f.up.col[e] != to) ++e;
                    if (e == at) {
                        f.up.col[at] = to;
                        f.up_weight[at++] = 0;
                    }
                    f.up_weight[e] += w;
                }
        }
        f.up.start[d + 1] = at;
    }
    Rows down;
    if (!transpose(f.up, f.up_weight, c.dofs, down, f.down_weight, a)) return false;
    f.down = std::move(down);
    return true;
}

/// f(coarse column, weight) of every product that adds to a coarse row.
template <class F>
void each_product(const Level& f, std::uint32_t coarse_row, F add) noexcept {
    for (std::uint32_t t = f.down.start[coarse_row]; t < f.down.start[coarse_row + 1]; ++t) {
        const std::uint32_t row = f.down.col[t];
        for (std::uint32_t e = f.matrix.start[row]; e < f.matrix.start[row + 1]; ++e) {
            const std::uint32_t k = f.matrix.col[e];
            for (std::uint32_t u = f.up.start[k]; u < f.up.start[k + 1]; ++u)
                add(f.up.col[u], double{f.down_weight[t]} * double{f.up_weight[u]}, e);
        }
    }
}

/// Whether an unknown of the finer level is interpolated between samples as the loops do.
bool is_between(const Level& f, const Level& c, std::uint32_t d) noexcept {
    const std::uint32_t s = f.sample_of[d], i = s / f.cols, j = s % f.cols;
    if (c.rows == f.rows || c.cols == f.cols) return false;
    if (i < 1 || j < 1 || i + 1 >= f.rows || j + 1 >= f.cols) return false;
    const std::uint32_t here = (i / 2) * c.cols + j / 2, count = (1 + i % 2) * (1 + j % 2);
    if (f.up.start[d + 1] - f.up.start[d] != count) return false;
    for (std::uint32_t di = 0; di <= i % 2; ++di)
        for (std::uint32_t dj = 0; dj <= j % 2; ++dj) {
            const std::uint32_t to = c.dof_of[here + di * c.cols + dj];
            std::uint32_t e = f.up.start[d];
            while (e < f.up.start[d + 1] && f.up.col[e] != to) ++e;
            if (e == f.up.start[d + 1] || f.up_weight[e] * static_cast<float>(count) != 1) return false;
        }
    return true;
}
/// Whether an unknown of the coarser level gathers from the 3 x 3 around its sample as the loops do.
bool is_gathered(const Level& f, const Level& c, std::uint32_t p) noexcept {
    const std::uint32_t s = c.sample_of[p], i = s / c.cols, j = s % c.cols;
    if (c.rows == f.rows || c.cols == f.cols) return false;
    if (i < 1 || j < 1 || i + 1 >= c.rows || j + 1 >= c.cols || f.down.start[p + 1] - f.down.start[p] != kNear)
        return false;
    for (std::uint32_t e = f.down.start[p]; e < f.down.start[p + 1]; ++e) {
        const std::uint32_t from = f.sample_of[f.down.col[e]], di = from / f.cols + 1 - 2 * i,
                            dj = from % f.cols + 1 - 2 * j;
        if (di > 2 || dj > 2) return false;
        if (f.down_weight[e] != (di == 1 ? 1.0f : 0.5f) * (dj == 1 ? 1.0f : 0.5f)) return false;
    }
    return true;
}
/// Lists the unknowns that loops over samples do not interpolate.
template <class F>
bool list_odd(std::uint32_t dofs, F is_odd, Array<std::uint32_t>& to, const Allocator& a) noexcept {
    std::uint64_t count = 0;
    for (std::uint32_t d = 0; d < dofs; ++d) count += is_odd(d) ? 1 : 0;
    if (!to.allocate(a, count)) return false;
    std::size_t at = 0;
    for (std::uint32_t d = 0; d < dofs; ++d)
        if (is_odd(d)) to[at++] = d;
    return true;
}
bool list_odds(Level& f, const Level& c, const Allocator& a) noexcept {
    return list_odd(
               f.dofs, [&](std::uint32_t d) { return !is_between(f, c, d); }, f.odd_up, a) &&
           list_odd(
               c.dofs, [&](std::uint32_t p) { return !is_gathered(f, c, p); }, f.odd_down, a);
}

bool make_pattern(const Level& f, Level& c, const Allocator& a) noexcept {
    Array<std::uint32_t> seen;
    if (!c.matrix.start.allocate(a, std::uint64_t{c.dofs} + 1) || !seen.allocate(a, c.dofs, ~0u)) return false;
    std::uint64_t count = 0;
    for (std::uint32_t p = 0; p < c.dofs; ++p)
        each_product(f, p, [&](std::uint32_t q, double, std::uint32_t) {
            if (seen[q] == p) return;
            seen[q] = p;
            ++count;
        });
    if (!c.matrix.col.allocate(a, count)) return false;
    for (std::uint32_t& s : seen) s = ~0u;
    std::uint32_t at = 0;
    for (std::uint32_t p = 0; p < c.dofs; ++p) {
        const std::uint32_t begin = at;
        each_product(f, p, [&](std::uint32_t q, double, std::uint32_t) {
            if (seen[q] == p) return;
            seen[q] = p;
            c.matrix.col[at++] = q;
        });
        std::sort(c.matrix.col.begin() + begin, c.matrix.col.begin() + at);
        c.matrix.start[p + 1] = at;
    }
    return true;
}

/// Samples of each unknown as chains.
struct Chains {
    Array<std::uint32_t> first, next;
    [[nodiscard]] bool make(const Level& l, const Allocator& a) noexcept {
        if (!first.allocate(a, l.dofs, ~0u) || !next.allocate(a, l.grid, ~0u)) return false;
        for (std::uint32_t s = l.grid; s-- > 0;) {
            next[s] = first[l.dof_of[s]];
            first[l.dof_of[s]] = s;
        }
        return true;
    }
};

/// Place in `stencil` at which some copy of unknown d has unknown q in the 3 x 3 around it, or ~0u.
std::uint32_t place_of(const Level& l, const Chains& chains, std::uint32_t d, std::uint32_t q) noexcept {
    for (std::uint32_t s = chains.first[d]; s != ~0u; s = chains.next[s]) {
        const std::uint32_t i = s / l.cols, j = s % l.cols;
        for (std::uint32_t k = 0; k < kNear; ++k) {
            const std::uint32_t r = i + k / 3 - 1, c = j + k % 3 - 1;
            if (r < l.rows && c < l.cols && l.dof_of[r * l.cols + c] == q)
                return static_cast<std::uint32_t>(blocked(s, k, kNear));
        }
    }
    return ~0u;
}

bool make_rim(Level& l, const Allocator& a) noexcept {
    Chains chains;
    if (!chains.make(l, a) || !l.place.allocate(a, l.matrix.col.size())) return false;
    std::uint64_t rim = 0, entries = 0, late = 0;
    for (std::uint32_t d = 0; d < l.dofs; ++d) {
        bool fits = true;
        for (std::uint32_t e = l.matrix.start[d]; e < l.matrix.start[d + 1]; ++e) {
            l.place[e] = place_of(l, chains, d, l.matrix.col[e]);
            fits = fits && l.place[e] != ~0u;
        }
        if (!fits) {
            ++rim;
            entries += l.matrix.start[d + 1] - l.matrix.start[d];
            l.place[l.matrix.start[d]] = ~0u;
        }
        late += !fits || chains.next[chains.first[d]] != ~0u ? 1 : 0;
    }
    if (!l.rim.allocate(a, rim) || !l.rim_rows.start.allocate(a, rim + 1) || !l.rim_rows.col.allocate(a, entries) ||
        !l.rim_value.allocate(a, entries) || !l.rim_now.allocate(a, 3 * rim) || !l.late.allocate(a, late) ||
        !l.late_now.allocate(a, 3 * late))
        return false;
    std::uint32_t at = 0, place = 0, last = 0;
    for (std::uint32_t d = 0; d < l.dofs; ++d) {
        const bool fits = l.place[l.matrix.start[d]] != ~0u;
        if (!fits || chains.next[chains.first[d]] != ~0u) l.late[last++] = l.sample_of[d];
        if (fits) continue;
        l.rim[place] = d;
        for (std::uint32_t e = l.matrix.start[d]; e < l.matrix.start[d + 1]; ++e)
            l.rim_rows.col[at++] = l.sample_of[l.matrix.col[e]];
        l.rim_rows.start[++place] = at;
    }
    return true;
}

bool make_fields(Level& l, const Allocator& a) noexcept {
    if (!l.planes.allocate(a, 21 * std::uint64_t{plane_size(l.rows, l.cols)}) ||
        !l.stencil.allocate(a, kNear * std::uint64_t{l.count()}) || !l.value.allocate(a, l.matrix.col.size()))
        return false;
    PlaneCutter cut(l.planes, l.rows, l.cols);
    l.x = cut.field();
    l.r = cut.field();
    l.d0 = cut.field();
    l.d1 = cut.field();
    l.kept = cut.field();
    l.diagonal = cut.plane();
    l.own = cut.plane();
    for (float*& e : l.extra) e = cut.plane();
    for (float*& i : l.inverse) i = cut.plane();
    for (std::uint32_t d = 0; d < l.dofs; ++d) l.own[l.sample_of[d]] = 1;
    return true;
}

void take_stencil(Level& l) noexcept {
    std::uint32_t place = 0, at = 0;
    for (std::uint32_t d = 0; d < l.dofs; ++d) {
        const bool rim = place < l.rim.size() && l.rim[place] == d;
        const std::uint32_t s = l.sample_of[d];
        if (rim) ++place;
        for (std::uint32_t e = l.matrix.start[d]; e < l.matrix.start[d + 1]; ++e) {
            const auto v = static_cast<float>(l.value[e]);
            if (l.matrix.col[e] == d) l.diagonal[s] = v;
            if (rim)
                l.rim_value[at++] = v;
            else
                l.stencil[l.place[e]] = v;
        }
    }
    for (std::size_t k = 0; k < l.copies.size(); k += 2) l.diagonal[l.copies[k]] = l.diagonal[l.copies[k + 1]];
}
}  // namespace

bool list_unknowns(Level& l, const Allocator& a) noexcept {
    if (!l.sample_of.allocate(a, l.dofs, ~0u)) return false;
    std::uint64_t copies = 0;
    for (std::uint32_t s = 0; s < l.grid; ++s) {
        std::uint32_t& first = l.sample_of[l.dof_of[s]];
        if (first == ~0u)
            first = s;
        else
            ++copies;
    }
    if (!l.copies.allocate(a, 2 * copies)) return false;
    std::size_t at = 0;
    for (std::uint32_t s = 0; s < l.grid; ++s) {
        const std::uint32_t first = l.sample_of[l.dof_of[s]];
        if (first == s) continue;
        l.copies[at++] = s;
        l.copies[at++] = first;
    }
    return true;
}

bool build_levels(Multigrid& m, const Allocator& a) noexcept {
    for (m.levels = 1; m.levels < kMostLevels; ++m.levels) {
        Level& f = m.level[m.levels - 1];
        if (f.rows <= 5 && f.cols <= 5) break;
        Level& c = m.level[m.levels];
        if (!make_coarse_samples(f, c, a) || !make_interpolation(f, c, a) || !list_odds(f, c, a) ||
            !make_pattern(f, c, a))
            return false;
    }
    for (std::uint32_t k = 0; k < m.levels; ++k)
        if (!make_rim(m.level[k], a) || !make_fields(m.level[k], a)) return false;
    return true;
}

void take_values(Multigrid& m) noexcept {
    for (std::uint32_t k = 0; k + 1 < m.levels; ++k) {
        const Level& f = m.level[k];
        Level& c = m.level[k + 1];
        for (std::uint32_t p = 0; p < c.dofs; ++p) {
            const std::uint32_t begin = c.matrix.start[p], end = c.matrix.start[p + 1];
            for (std::uint32_t e = begin; e < end; ++e) c.value[e] = 0;
            each_product(f, p, [&](std::uint32_t q, double w, std::uint32_t e) {
                const std::uint32_t* at = std::lower_bound(c.matrix.col.begin() + begin, c.matrix.col.begin() + end, q);
                c.value[static_cast<std::size_t>(at - c.matrix.col.begin())] += w * f.value[e];
            });
        }
    }
    for (std::uint32_t k = 0; k < m.levels; ++k) take_stencil(m.level[k]);
    take_extra(m);
    bound_eigenvalues(m);
}

}  // namespace dgm::detail::physics
