// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut/shared_disk.h
// A disk that several charts have in common.
#pragma once
#include <memory>
#include <utility>

#include "geometry/cut/disk.h"

namespace dgm::bake {

/// Copies of the object share the disk until one changes it: that of a dense source takes as much room as the source
/// itself, and charts that compete lie on the same one.
class SharedDisk {
 public:
    SharedDisk() : disk_(std::make_shared<Disk>()) {}
    SharedDisk(Disk disk)  // NOLINT(google-explicit-constructor): a disk is one that nobody else has
        : disk_(std::make_shared<Disk>(std::move(disk))) {}
    SharedDisk(const SharedDisk&) = default;
    SharedDisk& operator=(const SharedDisk&) = default;
    ~SharedDisk() = default;

    [[nodiscard]] const Disk& operator*() const { return *disk_; }
    const Disk* operator->() const { return disk_.get(); }
    /// To be changed; a copy first if another object shares it.
    [[nodiscard]] Disk& own() {
        if (disk_.use_count() > 1) disk_ = std::make_shared<Disk>(*disk_);
        return *disk_;
    }

 private:
    std::shared_ptr<Disk> disk_;  // never null, so copies only: a move would leave one without
};

}  // namespace dgm::bake
