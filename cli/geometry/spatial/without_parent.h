// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/spatial/without_parent.h
// Builds of Embree's hierarchies apart from the tasks around them.
#pragma once
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>
#include <tbb/task_group.h>

namespace dgm::bake {

/// Calls work(), which must not throw, in a group of tasks that has no parent and never ends. A scene of Embree keeps a
/// group as long as it lives, whose parent is the one that it was built in. Where that has ended, an exception that
/// leaves any other group lets TBB look at it, and crash.
template <class Work>
void without_parent(const Work& work) {
    static auto& root = *new tbb::task_group_context(tbb::task_group_context::isolated);  // scenes may outlive statics
    tbb::parallel_for(
        0, 1, [&](int) { work(); }, tbb::simple_partitioner(), root);
}

}  // namespace dgm::bake
