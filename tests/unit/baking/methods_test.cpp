// SPDX-License-Identifier: GPL-3.0-or-later
#include "baking/methods.h"

#include <gtest/gtest.h>

#include <memory>

#include "geometry/cgal/cgal_parameterizers.h"
#include "geometry/parameterize/free_methods.h"

namespace dgm::bake {
namespace {

TEST(Methods, EveryWordNamesItsRow) {
    for (const MethodRow& row : kMethods) {
        EXPECT_EQ(method_of(row.name), row.value);
        EXPECT_EQ(name_of(row.value), row.name);
        EXPECT_EQ(&row_of(row.value), &row);
    }
    EXPECT_EQ(method_of("lcsm"), std::nullopt);
    EXPECT_EQ(method_of(""), std::nullopt);
}

TEST(Methods, TheGeometryKnowsEachMethodInTheDomainThatTheTableNames) {
    for (const MethodRow& row : kMethods) {
        const bool free = row.cut == MethodCut::kShortest;
        EXPECT_EQ(make_free_parameterizer(row.name) != nullptr, free) << row.name;
        const bool fixed = row.cut == MethodCut::kSearched && row.value != Method::kStretch;
        EXPECT_EQ(make_cgal_parameterizer(row.name) != nullptr, fixed) << row.name;
        EXPECT_EQ(is_free(row.value), free || row.needs_uvs) << row.name;
    }
}

}  // namespace
}  // namespace dgm::bake
