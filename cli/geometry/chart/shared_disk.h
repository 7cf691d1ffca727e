// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/chart/shared_disk.h
// A disk that several charts have in common.
#pragma once
#include <memory>
#include <utility>

#include "geometry/cut/disk.h"
#include "geometry/spatial/lazy_index.h"

namespace dgm::bake {

/// Copies of the object share the disk until one changes it: that of a dense source takes as much room as the source
/// itself, and charts that compete lie on the same one. With it they share the index of its faces.
class SharedDisk {
 public:
    SharedDisk() : held_(std::make_shared<Held>(Disk{})) {}
    SharedDisk(Disk disk)  // NOLINT(google-explicit-constructor): a disk is one that nobody else has
        : held_(std::make_shared<Held>(std::move(disk))) {}
    SharedDisk(const SharedDisk&) = default;
    SharedDisk& operator=(const SharedDisk&) = default;
    ~SharedDisk() = default;

    [[nodiscard]] const Disk& operator*() const { return held_->disk; }
    const Disk* operator->() const { return &held_->disk; }
    /// To be changed; a copy first if another object shares it.
    [[nodiscard]] Disk& own() {
        if (held_.use_count() > 1)
            held_ = std::make_shared<Held>(Disk(held_->disk));
        else
            held_->index.drop();
        return held_->disk;
    }

    /// Of the disk's faces. May be called from any number of threads; holds until the disk is changed or the index
    /// dropped.
    [[nodiscard]] const ClosestPointIndex& index() const { return held_->index.get(); }
    /// Gives its room back, for all who share the disk. Nobody may be using it.
    void drop_index() const { held_->index.drop(); }

 private:
    struct Held {
        explicit Held(Disk of) : disk(std::move(of)) {}

        Disk disk;
        LazyIndex index{disk.mesh};
    };
    std::shared_ptr<Held> held_;  // never null, so copies only: a move would leave one without
};

}  // namespace dgm::bake
