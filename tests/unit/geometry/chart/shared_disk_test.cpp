// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/chart/shared_disk_test.cpp
#include "geometry/chart/shared_disk.h"

#include <gtest/gtest.h>

#include <utility>

#include "geometry/cut/cut_graph.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

SharedDisk disk_of_a_sheet() {
    return CutGraph(test::grid_sheet(3, 3, 1, 1)).open();
}

TEST(SharedDisk, IsEmptyAtFirst) {
    const SharedDisk disk;
    EXPECT_TRUE(disk->mesh.faces.empty());
}

TEST(SharedDisk, CopiesAreOneDisk) {
    const SharedDisk disk = disk_of_a_sheet(), copy = disk;
    EXPECT_EQ(&*disk, &*copy);
    EXPECT_FALSE(copy->mesh.faces.empty());
}

TEST(SharedDisk, AChangeIsSeenByItsOwnerAlone) {
    const SharedDisk disk = disk_of_a_sheet();
    SharedDisk copy = disk;
    const Vec3d before = disk->mesh.positions[0];
    copy.own().mesh.positions[0] = before + Vec3d{1, 2, 3};
    EXPECT_EQ(disk->mesh.positions[0], before);
    EXPECT_EQ(copy->mesh.positions[0], (before + Vec3d{1, 2, 3}));
    const Disk* const own = &*copy;
    EXPECT_EQ(&copy.own(), own);  // nobody shares it: it is not copied again
}

TEST(SharedDisk, ThatWasMovedFromIsStillADisk) {
    SharedDisk disk = disk_of_a_sheet();
    const SharedDisk other = std::move(disk);
    EXPECT_EQ(&*disk, &*other);  // NOLINT(bugprone-use-after-move): a move is a copy
}

TEST(SharedDisk, CopiesShareTheIndexUntilOneIsChanged) {
    const SharedDisk disk = disk_of_a_sheet();
    SharedDisk copy = disk;
    EXPECT_EQ(&disk.index(), &copy.index());
    const Vec3d over = disk->mesh.positions[0] + Vec3d{0, 0, 2};
    EXPECT_DOUBLE_EQ(copy.index().query(over).distance, 2);
    for (Vec3d& p : copy.own().mesh.positions) p.z += 1;
    EXPECT_DOUBLE_EQ(copy.index().query(over).distance, 1);
    EXPECT_DOUBLE_EQ(disk.index().query(over).distance, 2);
    for (Vec3d& p : copy.own().mesh.positions) p.z += 0.5;  // nobody shares it, but it has an index
    EXPECT_DOUBLE_EQ(copy.index().query(over).distance, 0.5);
}

TEST(SharedDisk, AnIndexThatWasDroppedIsBuiltAgain) {
    const SharedDisk disk = disk_of_a_sheet();
    const double before = disk.index().query({0, 0, 1}).distance;
    disk.drop_index();
    EXPECT_EQ(disk.index().query({0, 0, 1}).distance, before);
}

}  // namespace
}  // namespace dgm::bake
