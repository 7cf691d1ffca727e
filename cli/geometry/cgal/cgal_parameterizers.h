// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cgal/cgal_parameterizers.h
// Parameterization methods that CGAL computes.
#pragma once
#include <memory>
#include <string_view>

#include "geometry/parameterize/parameterizer.h"
#include "geometry/solve/factor_once.h"

namespace dgm::bake {

/// | name        | border | method |
/// |-------------|--------|--------|
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
/// solve() expects a disk (check_disk()) and throws model::Error kMapInvalid if it is none or if a solve fails,
/// kInterrupted, or kWorkerMemory out of memory. Deterministic; solve() may be called from several threads at once only
/// without `statistics`. Free borders: free_methods.h.
///
/// @param statistics  if given, the linear solves made are added to it; must outlive the result
/// @return nullptr for another name
[[nodiscard]] std::unique_ptr<Parameterizer> make_cgal_parameterizer(std::string_view method,
                                                                     SolveStatistics* statistics = nullptr);

}  // namespace dgm::bake
