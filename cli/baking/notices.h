// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/notices.h
// Notices for an artist about a mesh before the long part of its bake begins.
#pragma once
#include <vector>

#include "baking/stages.h"

namespace dgm::bake {

/// The warnings so far, what was done as the file asks, the repairs that hint at a fault of the model (not those that
/// every export needs), and whether the surface has open borders. One fact each, "warning: ..." or "note: ...".
[[nodiscard]] std::vector<Notice> notices(const Repaired& source);

}  // namespace dgm::bake
