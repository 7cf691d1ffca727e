// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/grid_least_squares.h
// Values at texels or samples that, interpolated, come closest to values at scattered points.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace dgm::bake {

/// One scattered point: sum_k w[k] * x[unknown[k]] should be `value`, with weight `weight`.
template <std::size_t Channels>
struct GridRow {
    std::array<std::uint32_t, 4> unknown{};
    std::array<double, 4> w{};
    std::array<double, Channels> value{};
    double weight = 1;
};

/// The symmetric matrix sum_rows weight * w w^T, by unknown, which conjugate gradients multiply by in each step.
/// Several points a triangle share its entries, so it is a fraction of the rows' size.
class GridMatrix {
 public:
    template <std::size_t Channels>
    GridMatrix(std::span<const GridRow<Channels>> rows, std::size_t unknowns) : diagonal(unknowns, 0.0) {
        // Pairs (a, b), a < b, in a chain for each a; a lattice has three or four.
        constexpr std::uint32_t kEnd = 0xffffffff;
        struct Entry {
            std::uint32_t column, next;
            double value;
        };
        std::vector<std::uint32_t> head(unknowns, kEnd);
        std::vector<Entry> entries;
        entries.reserve(4 * unknowns);
        for (const GridRow<Channels>& row : rows)
            for (std::size_t k = 0; k < 4; ++k) {
                const double wk = row.weight * row.w[k];
                if (wk == 0) continue;
                diagonal[row.unknown[k]] += wk * row.w[k];
                for (std::size_t l = k + 1; l < 4; ++l) {
                    if (row.w[l] == 0) continue;
                    const auto [a, b] = std::minmax(row.unknown[k], row.unknown[l]);
                    if (a == b) {  // both ways
                        diagonal[a] += 2 * wk * row.w[l];
                        continue;
                    }
                    std::uint32_t e = head[a];
                    while (e != kEnd && entries[e].column != b) e = entries[e].next;
                    if (e == kEnd) {
                        e = static_cast<std::uint32_t>(entries.size());
                        entries.push_back({b, head[a], 0.0});
                        head[a] = e;
                    }
                    entries[e].value += wk * row.w[l];
                }
            }
        first.reserve(unknowns + 1);
        column.reserve(entries.size());
        value.reserve(entries.size());
        for (const std::uint32_t from : head) {
            first.push_back(static_cast<std::uint32_t>(column.size()));
            for (std::uint32_t e = from; e != kEnd; e = entries[e].next) {
                column.push_back(entries[e].column);
                value.push_back(entries[e].value);
            }
        }
        first.push_back(static_cast<std::uint32_t>(column.size()));
    }

    std::vector<double> diagonal;
    std::vector<std::uint32_t> first, column;  ///< above the diagonal: row u holds first[u] to first[u + 1]
    std::vector<double> value;
};

/// product = matrix * direction, with another diagonal.
template <std::size_t Channels>
void multiply(const GridMatrix& matrix, std::span<const double> diagonal,
              std::span<const std::array<double, Channels>> direction,
              std::span<std::array<double, Channels>> product) {
    for (std::size_t u = 0; u < product.size(); ++u)
        for (std::size_t c = 0; c < Channels; ++c) product[u][c] = diagonal[u] * direction[u][c];
    for (std::size_t u = 0; u < product.size(); ++u) {
        const std::array<double, Channels> own = direction[u];
        std::array<double, Channels> sum = product[u];
        for (std::uint32_t e = matrix.first[u]; e < matrix.first[u + 1]; ++e) {
            const std::uint32_t v = matrix.column[e];
            for (std::size_t c = 0; c < Channels; ++c) {
                sum[c] += matrix.value[e] * direction[v][c];
                product[v][c] += matrix.value[e] * own[c];
            }
        }
        product[u] = sum;
    }
}

/// Minimises  sum of the rows + damping * (own diagonal) * |x|^2  over each channel by conjugate gradients with Jacobi
/// preconditioning. Unknowns in no row stay 0. Sums run in a fixed order: the same bits every time.
template <std::size_t Channels>
[[nodiscard]] std::vector<std::array<double, Channels>> grid_least_squares(std::span<const GridRow<Channels>> rows,
                                                                           std::size_t unknowns, double damping,
                                                                           int iterations) {
    using Value = std::array<double, Channels>;
    const GridMatrix matrix(rows, unknowns);
    std::vector<double> damped(unknowns), inverse(unknowns);
    std::vector<Value> x(unknowns, Value{}), residual(unknowns, Value{}), direction(unknowns, Value{}),
        product(unknowns);
    for (const GridRow<Channels>& row : rows)
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t c = 0; c < Channels; ++c)
                residual[row.unknown[k]][c] += row.weight * row.w[k] * row.value[c];
    for (std::size_t u = 0; u < unknowns; ++u) {
        damped[u] = (1 + damping) * matrix.diagonal[u];
        inverse[u] = damped[u] > 0 ? 1 / damped[u] : 0;
    }
    Value rz{}, first{};
    const auto precondition = [&](const Value& beta) {
        for (std::size_t u = 0; u < unknowns; ++u)
            for (std::size_t c = 0; c < Channels; ++c)
                direction[u][c] = residual[u][c] * inverse[u] + beta[c] * direction[u][c];
    };
    const auto squared_residual = [&] {
        Value sum{};
        for (std::size_t u = 0; u < unknowns; ++u)
            for (std::size_t c = 0; c < Channels; ++c) sum[c] += residual[u][c] * residual[u][c] * inverse[u];
        return sum;
    };
    precondition({});
    rz = first = squared_residual();
    for (int it = 0; it < iterations; ++it) {
        bool open = false;
        for (std::size_t c = 0; c < Channels; ++c) open = open || rz[c] > 1e-8 * first[c];
        if (!open) break;
        multiply<Channels>(matrix, damped, direction, product);
        Value curvature{}, step{}, beta{};
        for (std::size_t u = 0; u < unknowns; ++u)
            for (std::size_t c = 0; c < Channels; ++c) curvature[c] += direction[u][c] * product[u][c];
        for (std::size_t c = 0; c < Channels; ++c) step[c] = curvature[c] > 0 ? rz[c] / curvature[c] : 0;
        for (std::size_t u = 0; u < unknowns; ++u)
            for (std::size_t c = 0; c < Channels; ++c) {
                x[u][c] += step[c] * direction[u][c];
                residual[u][c] -= step[c] * product[u][c];
            }
        const Value next = squared_residual();
        for (std::size_t c = 0; c < Channels; ++c) beta[c] = rz[c] > 0 ? next[c] / rz[c] : 0;
        rz = next;
        precondition(beta);
    }
    return x;
}

}  // namespace dgm::bake
