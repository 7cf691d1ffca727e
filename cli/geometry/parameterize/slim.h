// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/slim.h
// Flip-free descent of a distortion energy, and a flip-free map to start it from.
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "geometry/parameterize/parameterizer.h"
#include "geometry/parameterize/rest_shapes.h"

namespace dgm::bake {

/// Energies are sums over faces of A' (g(s1) + g(s2)), s1 >= s2 > 0 the singular values of the map from the surface to
/// the plane and A' the share of the face in the surface area.
enum class FlipFreeEnergy {
    kSymmetricDirichlet,  ///< g(s) = (s^2 + s^-2) / 2; least (2 in all) where isometric
    kArap,                ///< g(s) = (s - 1)^2 + barrier (1/s - 1)^2; least (0) where isometric
    kStretch,  ///< g(s) = s^-stretch_power + stretch_epsilon s^2: twice the squared L2 stretch of [Sander 2001] for
               ///  power 2, and a term against needles of oversampling
};

struct SlimOptions {
    FlipFreeEnergy energy = FlipFreeEnergy::kSymmetricDirichlet;
    bool border_fixed = false;     ///< border vertices keep their start to the bit
    std::size_t iterations = 30;   ///< at most so many Newton steps
    double tolerance = 1e-5;       ///< stop when a step lowers the energy by less than this share of it ...
    std::size_t patience = 1;      ///< ... so many times in a row
    double barrier = 0.01;         ///< kArap only, 0 < barrier <= 16 (g stays convex)
    double stretch_epsilon = 0.3;  ///< kStretch only, >= 0
    double stretch_power = 2;      ///< kStretch only, > 0; small powers let crowded faces grow side by side
    /// One per face, in place of the shapes of the surface; not scaled. Their areas are the weights of the faces.
    std::span<const RestShape> rest = {};
};

struct SlimReport {
    double start_energy = 0, energy = 0;  ///< after the best global scale of a free border; final
    std::size_t iterations = 0;           ///< Newton steps taken
    std::size_t factorizations = 0;       ///< numeric; the symbolic one is done once
};

/// Moves the vertices of a flip-free map to lower `options.energy`; never turns a face over, never raises the energy.
///
/// Projected Newton: the 4x4 Hessian of each face by its analytic eigensystem [Smith, De Goes, Kim 2019], negative
/// eigenvalues cut to 0; steps end before 0.9 of the first collapse of a face [Smith, Schaefer 2015], go beyond the
/// Newton step while that pays, then Armijo backtracking. Faces that would end a step early are held back. Rest shapes
/// are scaled so that both areas agree (fixed border), or the start is scaled once to its best size (free border).
/// Slivers count as at least 1e-6 as high as long, so that one of them cannot stall the rest.
///
/// @param start  one point per vertex, every face counter-clockwise by the exact predicate
/// @return  one point per vertex; flip-free; `start` itself if nothing lower was found
/// @throws model::Error kMapInvalid if `start` has another size, is not finite or not flip-free; kInterrupted
/// Deterministic, single-threaded. Cost: about one sparse Cholesky factorization of 2V unknowns an iteration.
[[nodiscard]] std::vector<Vec2d> descend_flip_free(const DiskView& disk, std::vector<Vec2d> start,
                                                   const SlimOptions& options, const model::Progress& progress,
                                                   SlimReport* report = nullptr);

/// The energy descend_flip_free lowers at `uv`, without the global scaling; +infinity where a face has no positive
/// area. If `gradient` is given it is filled with dE/du, dE/dv per vertex (border vertices too).
[[nodiscard]] double flip_free_energy(const DiskView& disk, std::span<const Vec2d> uv, const SlimOptions& options,
                                      std::vector<Vec2d>* gradient = nullptr);

enum class FlipFreeStart {
    kFirstValid,  ///< uniform weights if doubles hold the result, else as below
    kSpread,  ///< weights along a tree from the innermost vertex outwards that turn the exponential crowding of long
              ///  fingers and ribbons into a power law; uglier where nothing is crowded
};

/// A map without flips to start from: border on `disk.border_uv` if there is one, else on the unit circle by arc length
/// (no edge shorter than a tenth of its equal share). Tutte's theorem holds for all weights tried, in exact arithmetic;
/// its result in doubles is checked exactly.
///
/// @return nothing if no try is flip-free
/// @throws model::Error kInterrupted
[[nodiscard]] std::optional<std::vector<Vec2d>> flip_free_start(const DiskView& disk, const model::Progress& progress,
                                                                FlipFreeStart kind = FlipFreeStart::kFirstValid);

/// Number of faces that are not counter-clockwise by the exact predicate, faces with a non-finite corner among them.
[[nodiscard]] std::size_t count_not_positive(std::span<const Face> faces, std::span<const Vec2d> uv);

}  // namespace dgm::bake
