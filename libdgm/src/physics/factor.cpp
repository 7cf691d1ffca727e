// SPDX-License-Identifier: MIT
// libdgm/src/physics/factor.cpp
// Makes and applies block factors of the second derivatives at rest. What runs once a body is cold: built small.
//
// [George, Liu 1981] Computer solution of large sparse positive definite systems: elimination graph, least degree.
#include "physics/factor.h"

#include <algorithm>
#include <cmath>

#include "physics/factor_matrix.h"

namespace dgm::detail::physics {
namespace {

constexpr std::uint32_t kSide = 4;  ///< samples
constexpr std::size_t kColumns = kTileRows / kSquare;
constexpr float kDropped = 5e-4f;  ///< length of a square's rows below which it is dropped; those of L have 1
constexpr float kPivot = 1e-7f;    ///< least pivot: below it, rounding has eaten the matrix

/// Numbers unknowns by tiles of 4 x 4 samples. @return number of tiles
[[gnu::cold]] std::uint32_t number_tiles(const Level& l, Array<std::uint32_t>& tile) noexcept {
    const std::uint32_t down = (l.rows + kSide - 1) / kSide, across = (l.cols + kSide - 1) / kSide;
    for (std::uint32_t d = 0; d < l.dofs; ++d) {
        const std::uint32_t i = l.sample_of[d] / l.cols, j = l.sample_of[d] % l.cols;
        tile[d] = i * down / l.rows * across + j * across / l.cols;
    }
    return down * across;
}

/// Eliminates tiles in the order of least degree. `linked` becomes the pattern of the factor; `order` the tile by its
/// turn, `turn` its inverse.
[[gnu::cold]] void eliminate(std::uint32_t n, Array<std::uint8_t>& linked, Array<std::uint32_t>& degree,
                             Array<std::uint32_t>& order, Array<std::uint32_t>& turn) noexcept {
    const auto at = [&](std::uint32_t a, std::uint32_t b) -> std::uint8_t& { return linked[std::size_t{a} * n + b]; };
    const auto measure = [&](std::uint32_t t) {
        degree[t] = 0;
        for (std::uint32_t q = 0; q < n; ++q) degree[t] += turn[q] == n ? at(t, q) : 0u;
    };
    for (std::uint32_t t = 0; t < n; ++t) turn[t] = n;
    for (std::uint32_t t = 0; t < n; ++t) measure(t);
    for (std::uint32_t k = 0; k < n; ++k) {
        std::uint32_t best = n;
        for (std::uint32_t t = 0; t < n; ++t)
            if (turn[t] == n && (best == n || degree[t] < degree[best])) best = t;
        order[k] = best;
        turn[best] = k;
        for (std::uint32_t a = 0; a < n; ++a) {
            if (turn[a] != n || at(best, a) == 0) continue;
            for (std::uint32_t b = 0; b < n; ++b)
                if (turn[b] == n && at(best, b) != 0) at(a, b) = 1;
            measure(a);
        }
    }
}

/// Slots of unknowns and the pattern.
[[gnu::cold]] bool make_pattern(Making& m, std::uint64_t& bytes) noexcept {
    const Level& l = m.p.fine();
    const Allocator& a = m.p.allocator;
    Array<std::uint8_t> linked;
    Array<std::uint32_t> order, turn, filled;  // filled: degrees, then unknowns of a tile
    Factor& to = m.to;
    if (!m.tile.allocate(a, l.dofs)) return false;
    const std::uint32_t n = number_tiles(l, m.tile);
    if (!linked.allocate(a, std::uint64_t{n} * n) || !order.allocate(a, n) || !turn.allocate(a, n) ||
        !filled.allocate(a, n) || !to.slot.allocate(a, l.dofs) || !to.start.allocate(a, std::uint64_t{n} + 1))
        return false;
    each_ring(l, [&](std::uint32_t, const std::uint32_t* ring, std::uint32_t count) {
        for (std::uint32_t x = 0; x < count; ++x)
            for (std::uint32_t y = 0; y < count; ++y) linked[std::size_t{m.tile[ring[x]]} * n + m.tile[ring[y]]] = 1;
    });
    eliminate(n, linked, filled, order, turn);
    std::fill(filled.begin(), filled.end(), 0u);
    std::uint64_t entries = 0;
    for (std::uint32_t j = 0; j < n; ++j) {
        for (std::uint32_t i = j + 1; i < n; ++i) entries += linked[std::size_t{order[j]} * n + order[i]];
        to.start[j + 1] = static_cast<std::uint32_t>(entries);
    }
    // Diagonal tiles, as floats and the triangles of their inverses in 16 bits; those below as floats and in 16 bits
    // with the number and unit of their squares.
    bytes += std::uint64_t{n} * (kTileEntries * sizeof(float) + kOwnSquares * (2 * kSquare * kSquare + 4)) +
             entries * (6 * kTileEntries + 80) + std::uint64_t{n} * n;
    if (bytes > m.p.options.max_bytes) return false;
    if (!to.row.allocate(a, entries) || !m.below.allocate(a, entries * kTileEntries) ||
        !m.diagonal.allocate(a, n * std::uint64_t{kTileEntries}) ||
        !to.own.allocate(a, n * std::uint64_t{kOwnSquares * kSquare * kSquare}) ||
        !to.own_unit.allocate(a, n * std::uint64_t{kOwnSquares}) ||
        !to.scale.allocate(a, n * std::uint64_t{kTileRows}) || !to.work.allocate(a, n * std::uint64_t{kTileRows}))
        return false;
    std::size_t at = 0;
    for (std::uint32_t j = 0; j < n; ++j)
        for (std::uint32_t i = j + 1; i < n; ++i)
            if (linked[std::size_t{order[j]} * n + order[i]] != 0) to.row[at++] = i;
    for (std::uint32_t d = 0; d < l.dofs; ++d) {
        const std::uint32_t t = turn[m.tile[d]];
        to.slot[d] = static_cast<std::uint32_t>(t * kTileRows + 3 * filled[t]++);
    }
    to.tiles = n;
    return true;
}

/// The inverse of the Cholesky factor of a symmetric tile, and minus it for subtract_product(); a is overwritten.
/// @return false: a is not positive definite.
bool invert_root(float* a, float* to, float* minus) noexcept {
    const auto at = [](std::size_t r, std::size_t c) { return c * kTileRows + r; };
    for (std::size_t k = 0; k < kTileRows; ++k) {
        if (!(a[at(k, k)] > kPivot)) return false;
        const float root = std::sqrt(a[at(k, k)]), by = 1 / root;
        a[at(k, k)] = root;
        for (std::size_t r = k + 1; r < kTileRows; ++r) a[at(r, k)] *= by;
        for (std::size_t c = k + 1; c < kTileRows; ++c)
            for (std::size_t r = c; r < kTileRows; ++r) a[at(r, c)] -= a[at(r, k)] * a[at(c, k)];
    }
    std::fill_n(to, kTileEntries, 0.0f);
    for (std::size_t c = 0; c < kTileRows; ++c) {
        float* y = to + at(0, c);
        y[c] = 1;
        for (std::size_t k = c; k < kTileRows; ++k) {
            y[k] /= a[at(k, k)];
            for (std::size_t r = k + 1; r < kTileRows; ++r) y[r] -= a[at(r, k)] * y[k];
        }
    }
    for (std::size_t k = 0; k < kTileEntries; ++k) minus[k] = -to[k];
    return true;
}

/// Whether a row of a square is longer than what is dropped.
bool is_kept(const float* m) noexcept {
    for (std::size_t r = 0; r < kSquare; ++r) {
        float sum = 0;
        for (std::size_t c = 0; c < kSquare; ++c) sum += m[c * kTileRows + r] * m[c * kTileRows + r];
        if (sum > kDropped * kDropped) return true;
    }
    return false;
}
template <class F>
void each_square(F f) noexcept {
    for (std::size_t c = 0; c < kColumns; ++c)
        for (std::size_t r = 0; r < kColumns; ++r) f(c, r, c * kSquare * kTileRows + r * kSquare);
}

/// A square in 16 bits, column-major. @return their unit
float pack_square(const float* from, std::int16_t* to) noexcept {
    const auto at = [from](std::size_t k) { return from[k / kSquare * kTileRows + k % kSquare]; };
    float most = 0;
    for (std::size_t k = 0; k < kSquare * kSquare; ++k) most = std::max(most, std::fabs(at(k)));
    const float unit = most / 32767;
    for (std::size_t k = 0; k < kSquare * kSquare; ++k)
        to[k] = unit > 0 ? static_cast<std::int16_t>(std::floor(at(k) / unit + 0.5f)) : std::int16_t{0};
    return unit;
}

enum class Made : std::uint8_t { Whole, Indefinite, NoMemory };
/// Eliminates tile after tile: `below` becomes the factor. `kept` gets a bit for each square that will be kept.
[[gnu::cold]] Made eliminate_values(Making& m, Array<std::uint16_t>& kept) noexcept {
    Factor& to = m.to;
    std::uint32_t most = 1;
    for (std::size_t j = 0; j < to.tiles; ++j) most = std::max(most, to.start[j + 1] - to.start[j]);
    Array<float> column;  // and before it the inverse of the tile, and minus it
    if (!column.allocate(m.p.allocator, (std::uint64_t{most} + 2) * kTileEntries)) return Made::NoMemory;
    float *inverse = column.data(), *minus = inverse + kTileEntries, *first = minus + kTileEntries;
    const auto multiply = m.p.solver.kernels->subtract_product;
    for (std::uint32_t j = 0; j < to.tiles; ++j) {
        const std::uint32_t begin = to.start[j], end = to.start[j + 1];
        if (!invert_root(m.diagonal.data() + j * kTileEntries, inverse, minus)) return Made::Indefinite;
        std::fill_n(first, (end - begin) * kTileEntries, 0.0f);
        for (std::uint32_t e = begin; e < end; ++e) {
            float *l = first + (e - begin) * kTileEntries, *a = m.below.data() + e * kTileEntries;
            multiply(l, a, minus);
            std::copy_n(l, kTileEntries, a);
            kept[e] = 0;
            each_square([&](std::size_t c, std::size_t r, std::size_t at) {
                if (is_kept(l + at)) kept[e] = static_cast<std::uint16_t>(kept[e] | 1u << (c * kColumns + r));
            });
        }
        for (std::uint32_t e = begin; e < end; ++e)
            for (std::uint32_t f = begin; f <= e; ++f) {
                float* target = f == e ? m.diagonal.data() + to.row[e] * kTileEntries
                                       : m.below.data() + m.find(to.row[e], to.row[f]) * kTileEntries;
                multiply(target, first + (e - begin) * kTileEntries, first + (f - begin) * kTileEntries);
            }
        for (std::size_t r = 0, e = j * kOwnSquares; r < kColumns; ++r)
            for (std::size_t c = 0; c <= r; ++c, ++e)
                to.own_unit[e] =
                    pack_square(inverse + c * kSquare * kTileRows + r * kSquare, to.own.data() + e * kSquare * kSquare);
    }
    return Made::Whole;
}

/// Kept squares in 16 bits, by columns of squares.
[[gnu::cold]] bool pack(Making& m, const Array<std::uint16_t>& kept) noexcept {
    Factor& to = m.to;
    std::uint64_t count = 0;
    for (const unsigned bits : kept)
        for (unsigned b = bits; b != 0; b &= b - 1) ++count;
    Array<std::uint32_t> start, row;
    const Allocator& a = m.p.allocator;
    if (!to.value.allocate(a, count * kSquare * kSquare) || !to.unit.allocate(a, count) || !row.allocate(a, count) ||
        !start.allocate(a, kColumns * std::uint64_t{to.tiles} + 1))
        return false;
    std::uint32_t at = 0;
    for (std::uint32_t j = 0; j < to.tiles * kColumns; ++j) {
        for (std::uint32_t e = to.start[j / kColumns]; e < to.start[j / kColumns + 1]; ++e)
            each_square([&](std::size_t c, std::size_t r, std::size_t place) {
                if (c != j % kColumns || (kept[e] >> (c * kColumns + r) & 1) == 0) return;
                const float* from = m.below.data() + e * kTileEntries + place;
                to.unit[at] = pack_square(from, to.value.data() + at * kSquare * kSquare);
                row[at++] = static_cast<std::uint32_t>(to.row[e] * kColumns + r);
            });
        start[j + 1] = at;
    }
    to.start = std::move(start);
    to.row = std::move(row);
    return true;
}
}  // namespace

[[gnu::cold]] Result<void> make_factor(const PhysicsImpl& p, std::uint64_t bytes, Factor& to) noexcept {
    // Rounding may eat the least eigenvalues: the diagonal grows until it does not.
    for (float more = 1e-6f; more < 1; more *= 8) {
        Making m{p, {}, {}, {}, {}};
        Array<std::uint16_t> kept;
        std::uint64_t needed = bytes;
        if (!make_pattern(m, needed)) return needed > p.options.max_bytes ? over_max_bytes() : kNoMemory;
        if (!kept.allocate(p.allocator, m.to.row.size()) || !add_matrix(m, 1 + more)) return kNoMemory;
        const Made made = eliminate_values(m, kept);
        if (made == Made::Indefinite) continue;
        if (made == Made::NoMemory || !pack(m, kept)) return kNoMemory;
        m.to.dt = p.options.dt;
        to = std::move(m.to);
        return {};
    }
    return Error{ErrorCode::BadArgument, kNoOffset, "the matrix of material and map is not positive definite"};
}

void fit_turn(PhysicsImpl& p) noexcept {
    const Level& l = p.fine();
    double sum[9] = {}, mean[3] = {}, rest_mean[3] = {}, mass = 0;
    // Places, and area vectors for what is flat.
    for (std::uint32_t d = 0; d < l.dofs; ++d) {
        const std::uint32_t s = l.sample_of[d];
        const double m = p.mass[s];
        mass += m;
        for (std::size_t a = 0; a < 3; ++a) {
            const double x = double{p.rest.p[a][s]} + double{p.moved.p[a][s]};
            mean[a] += m * x;
            rest_mean[a] += m * double{p.rest.p[a][s]};
            for (std::size_t b = 0; b < 3; ++b) sum[3 * a + b] += m * x * double{p.rest.p[b][s]};
        }
        for (std::size_t a = 0; a < 3; ++a)
            for (std::size_t b = 0; b < 3; ++b)
                sum[3 * a + b] += m * double{p.area.p[a][s]} * double{p.rest_normal.p[b][s]};
    }
    double size = 0;
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b < 3; ++b) {
            sum[3 * a + b] -= mean[a] * rest_mean[b] / mass;
            size = std::max(size, std::fabs(sum[3 * a + b]));
        }
    // Nearest rotation by Newton's iteration for the polar factor [Higham 1986].
    for (double& v : sum) v /= size;
    for (int k = 0; k < 20; ++k) {
        const auto& q = sum;
        const double minor[9] = {q[4] * q[8] - q[5] * q[7], q[5] * q[6] - q[3] * q[8], q[3] * q[7] - q[4] * q[6],
                                 q[2] * q[7] - q[1] * q[8], q[0] * q[8] - q[2] * q[6], q[1] * q[6] - q[0] * q[7],
                                 q[1] * q[5] - q[2] * q[4], q[2] * q[3] - q[0] * q[5], q[0] * q[4] - q[1] * q[3]};
        const double det = q[0] * minor[0] + q[1] * minor[1] + q[2] * minor[2];
        if (!(det > 1e-12)) return;
        double change = 0;
        for (std::size_t e = 0; e < 9; ++e) {
            const double next = 0.5 * (sum[e] + minor[e] / det);
            change = std::max(change, std::fabs(next - sum[e]));
            sum[e] = next;
        }
        if (change > 1e-9) continue;
        std::copy_n(sum, 9, p.factor.turn);
        return;
    }
}

void apply_inverse(PhysicsImpl& p, const Field& to, const Field& from) noexcept {
    Factor& f = p.factor;
    const Level& l = p.fine();
    float q[9];
    for (std::size_t k = 0; k < 9; ++k) q[k] = static_cast<float>(f.turn[k]);
    for (std::uint32_t d = 0; d < l.dofs; ++d) {
        const std::uint32_t s = l.sample_of[d];
        const float x = from.p[0][s], y = from.p[1][s], z = from.p[2][s];
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t at = f.slot[d] + c;
            f.work[at] = f.scale[at] * (q[c] * x + q[3 + c] * y + q[6 + c] * z);
        }
    }
    p.solver.kernels->solve({f.tiles, f.start.data(), f.row.data(), f.value.data(), f.unit.data(), f.own.data(),
                             f.own_unit.data(), f.work.data()});
    for (std::uint32_t d = 0; d < l.dofs; ++d) {
        const std::uint32_t s = l.sample_of[d];
        float v[3];
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t at = f.slot[d] + c;
            v[c] = p.free[s] * f.scale[at] * f.work[at];
        }
        for (std::size_t a = 0; a < 3; ++a) to.p[a][s] = q[3 * a] * v[0] + q[3 * a + 1] * v[1] + q[3 * a + 2] * v[2];
    }
    share_copies(l, to);
}

}  // namespace dgm::detail::physics
