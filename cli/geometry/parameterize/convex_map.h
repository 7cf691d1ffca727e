// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/convex_map.h
// Bijective maps onto a convex border by symmetric positive weights [Tutte 1963], [Floater 1997], and the fast descent
// of stretch by reweighting them [Yoshizawa, Belyaev, Seidel 2004].
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "geometry/parameterize/parameterizer.h"

namespace dgm::bake {

/// Solves  sum_j w_ij (x_j - x_i) = 0  at interior vertices for fixed border values, again and again with new weights:
/// the sparsity pattern is analysed once.
class ConvexMapSolver {
 public:
    ConvexMapSolver(std::size_t vertex_count, std::span<const Face> faces, std::span<const std::uint32_t> border);
    ~ConvexMapSolver();
    ConvexMapSolver(ConvexMapSolver&&) noexcept;

    /// Undirected edges as (lower, higher) vertex, in the order `weights` has.
    [[nodiscard]] std::span<const std::pair<std::uint32_t, std::uint32_t>> edges() const;
    /// @param weights  one positive finite number per edge
    /// @param border_uv  one point per entry of `border`; kept to the bit
    /// @throws model::Error kMapInvalid if the factorization breaks down
    [[nodiscard]] std::vector<Vec2d> solve(std::span<const double> weights, std::span<const Vec2d> border_uv);

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Cotangent weights (both sides' mean), clamped from below to 1 % and from above to 100 x so that they are positive
/// and obtuse or sliver-shaped faces keep the system sound. One per edge of `edges`.
[[nodiscard]] std::vector<double> positive_cotangent_weights(
    std::span<const Vec3d> positions, std::span<const Face> faces,
    std::span<const std::pair<std::uint32_t, std::uint32_t>> edges);

/// Sum over faces of A' * (squared L2 stretch), per face; infinity where the map area is not positive.
[[nodiscard]] double stretch_energy(std::span<const Vec3d> positions, std::span<const Face> faces,
                                    std::span<const Vec2d> uv);

/// L2 stretch of a whole map onto a figure of area 1 [Sander 2001]: 1 where it is a similarity, and more everywhere
/// else.
[[nodiscard]] double l2_stretch(std::span<const Vec3d> positions, std::span<const Face> faces,
                                std::span<const Vec2d> uv);

struct ReweightOptions {
    int iterations = 12;
    double exponent = 1.0;  ///< weight is divided by (stretch_i * stretch_j)^exponent
};

/// [Yoshizawa 2004] in symmetric form: dividing row i's weights by the stretch at j equals, up to a factor of the row,
/// w_ij / (stretch_i stretch_j), so one symmetric factorization serves. Returns the iterate with the least stretch.
[[nodiscard]] std::vector<Vec2d> reweighted_stretch_map(const DiskView& disk, const ReweightOptions& options,
                                                        const model::Progress& progress);

}  // namespace dgm::bake
