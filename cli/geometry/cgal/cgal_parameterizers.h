// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cgal/cgal_parameterizers.h
// Parameterization methods that CGAL computes.
#pragma once
#include <memory>
#include <string_view>

#include "geometry/cgal/factor_once.h"
#include "geometry/parameterize/parameterizer.h"

namespace dgm::bake {

/// | name        | border | method |
/// |-------------|--------|--------|
/// | `lscm`      | free   | least squares conformal maps [Levy et al. 2002], two vertices pinned |
/// | `arap`      | free   | as-rigid-as-possible, local/global [Liu et al. 2008], lambda = infinity |
/// | `tutte`     | fixed  | each interior vertex is the mean of its neighbours [Tutte 1963] |
/// | `mvc`       | fixed  | mean value coordinates [Floater 2003] |
/// | `authalic`  | fixed  | discrete authalic weights [Desbrun et al. 2002] |
/// | `conformal` | fixed  | cotangent weights [Eck et al. 1995] |
///
/// Fixed border: `border_uv` comes back to the bit, the interior is one linear solve. If a published weight is not
/// positive or not finite and the map has flips, it is solved again with the rows at fault replaced by mean value
/// weights (uniform ones where those fail too), and the map with fewer flips is returned. `authalic` is not CGAL's
/// iterative version: that one writes to standard output and to a file in the working folder (CGAL 5.5).
///
/// Free border: the centroid is at the origin, and an `lscm` map has the surface's area. CGAL's post-processing of
/// flips is off; a map with flips is replaced by a flip-free descent (slim.h) from a Tutte map: of the ARAP energy with
/// a barrier, or, for `lscm`, of the symmetric Dirichlet energy: a conformal map that flips in doubles has scales that
/// no grid can sample, and following them was worse in angles, too (mean 4.3 against 1.5 on the camel head). If no
/// flip-free start exists either, the map with flips is returned. Overlaps are for the caller: border_simple.h.
///
/// solve() checks the disk (one component, one border, genus 0, manifold, oriented, finite, all vertices used) and
/// throws model::Error kMapInvalid if it is none or if a solve fails, kInterrupted, or kWorkerMemory out of memory.
/// Deterministic; solve() may be called from several threads at once only without `statistics`.
///
/// @param statistics  if given, the linear solves made for `arap`'s iterations and for the fixed-border methods are
/// added
///                    to it (CGAL hides the only one of `lscm`); must outlive the result
/// @return nullptr for another name
[[nodiscard]] std::unique_ptr<Parameterizer> make_cgal_parameterizer(std::string_view method,
                                                                     SolveStatistics* statistics = nullptr);

}  // namespace dgm::bake
