// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/grid_least_squares.h
// Values at texels or samples that, interpolated, come closest to values at scattered points.
#pragma once
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

/// Minimises  sum of the rows + damping * (own diagonal) * |x|^2  over each channel by conjugate gradients with Jacobi
/// preconditioning, matrix-free. Unknowns in no row stay 0. Sums run in row order: the same bits every time.
template <std::size_t Channels>
[[nodiscard]] std::vector<std::array<double, Channels>> grid_least_squares(std::span<const GridRow<Channels>> rows,
                                                                           std::size_t unknowns, double damping,
                                                                           int iterations) {
    using Value = std::array<double, Channels>;
    std::vector<double> diagonal(unknowns, 0.0), lambda(unknowns, 0.0);
    std::vector<Value> x(unknowns, Value{}), residual(unknowns, Value{}), direction(unknowns, Value{}),
        product(unknowns);
    for (const GridRow<Channels>& row : rows)
        for (std::size_t k = 0; k < 4; ++k) {
            diagonal[row.unknown[k]] += row.weight * row.w[k] * row.w[k];
            for (std::size_t c = 0; c < Channels; ++c)
                residual[row.unknown[k]][c] += row.weight * row.w[k] * row.value[c];
        }
    for (std::size_t u = 0; u < unknowns; ++u) {
        lambda[u] = damping * diagonal[u];
        diagonal[u] = diagonal[u] > 0 ? 1 / (diagonal[u] + lambda[u]) : 0;  // from here on the preconditioner
    }
    Value rz{}, first{};
    const auto precondition = [&](const Value& beta) {
        for (std::size_t u = 0; u < unknowns; ++u)
            for (std::size_t c = 0; c < Channels; ++c)
                direction[u][c] = residual[u][c] * diagonal[u] + beta[c] * direction[u][c];
    };
    const auto squared_residual = [&] {
        Value sum{};
        for (std::size_t u = 0; u < unknowns; ++u)
            for (std::size_t c = 0; c < Channels; ++c) sum[c] += residual[u][c] * residual[u][c] * diagonal[u];
        return sum;
    };
    precondition({});
    rz = first = squared_residual();
    for (int it = 0; it < iterations; ++it) {
        bool open = false;
        for (std::size_t c = 0; c < Channels; ++c) open = open || rz[c] > 1e-8 * first[c];
        if (!open) break;
        for (std::size_t u = 0; u < unknowns; ++u)
            for (std::size_t c = 0; c < Channels; ++c) product[u][c] = lambda[u] * direction[u][c];
        for (const GridRow<Channels>& row : rows) {
            Value moved{};
            for (std::size_t k = 0; k < 4; ++k)
                for (std::size_t c = 0; c < Channels; ++c) moved[c] += row.w[k] * direction[row.unknown[k]][c];
            for (std::size_t k = 0; k < 4; ++k)
                for (std::size_t c = 0; c < Channels; ++c)
                    product[row.unknown[k]][c] += row.weight * row.w[k] * moved[c];
        }
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
