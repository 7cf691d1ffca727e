// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/spatial/lazy_index.cpp
#include "geometry/spatial/lazy_index.h"

#include <tbb/task_arena.h>

namespace dgm::bake {

const ClosestPointIndex& LazyIndex::get() {
    const std::lock_guard lock(building_);
    // Isolated: a thread that waits for parts of the build must not begin other work that asks for the index, too.
    if (!index_) tbb::this_task_arena::isolate([this] { index_.emplace(mesh_.positions, mesh_.faces); });
    return *index_;
}

}  // namespace dgm::bake
