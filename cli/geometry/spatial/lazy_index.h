// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/spatial/lazy_index.h
// One index of a mesh for all who ask for it.
#pragma once
#include <memory>
#include <mutex>
#include <optional>

#include "geometry/spatial/closest_point.h"
#include "model/tri_mesh.h"

namespace dgm::bake {

/// The index of a mesh: built when it is first asked for, which takes a microsecond a face and 140 bytes, and kept
/// until it is dropped. Charts of one component are measured against it a dozen times.
class LazyIndex {
 public:
    /// `mesh` must outlive the object, and stay as it is.
    explicit LazyIndex(const model::TriMesh& mesh) : mesh_(mesh) {}

    /// May be called from any number of threads. @throws as ClosestPointIndex
    [[nodiscard]] const ClosestPointIndex& get();
    /// Nobody may be using it. It is built again when it is asked for.
    void drop() { index_.reset(); }

 private:
    const model::TriMesh& mesh_;
    std::mutex building_;
    std::optional<ClosestPointIndex> index_;
};

/// For those who build an index of their own where they are given none.
[[nodiscard]] inline const ClosestPointIndex* index_of(const std::shared_ptr<LazyIndex>& lazy) {
    return lazy ? &lazy->get() : nullptr;
}

}  // namespace dgm::bake
