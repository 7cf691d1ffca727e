// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/spatial/box_tree_test.cpp
// Crowds of tiny triangles, fans of needles: the right answer, after a look at few of them.
#include "geometry/spatial/box_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "geometry/spatial/closest_point.h"

namespace dgm::bake {
namespace {

using model::Face;
using model::Vec3d;

struct Sheet {
    std::vector<Vec3d> positions;
    std::vector<Face> faces;
};

/// A wavy sheet of 2 x 64 x 64 triangles, `size` wide, at (0.5, 0.5, 0.5), and one triangle that makes the box large.
Sheet crowd(double size) {
    constexpr std::uint32_t kSide = 65;
    Sheet out;
    for (std::uint32_t i = 0; i < kSide; ++i)
        for (std::uint32_t j = 0; j < kSide; ++j) {
            const double x = i / (kSide - 1.0), y = j / (kSide - 1.0);
            out.positions.push_back({0.5 + size * x, 0.5 + size * y, 0.5 + 0.1 * size * std::sin(6 * x)});
        }
    for (std::uint32_t i = 0; i + 1 < kSide; ++i)
        for (std::uint32_t j = 0; j + 1 < kSide; ++j) {
            const std::uint32_t a = i * kSide + j, b = a + kSide;
            out.faces.push_back({a, b, b + 1});
            out.faces.push_back({a, b + 1, a + 1});
        }
    const auto first = static_cast<std::uint32_t>(out.positions.size());
    out.positions.insert(out.positions.end(), {{-20, -20, -20}, {40, -20, -20}, {-20, 40, -20}});
    out.faces.push_back({first, first + 1, first + 2});
    return out;
}

/// The first `count` faces.
Triangles triangles_of(const Sheet& sheet, std::size_t count) {
    Triangles out(sheet.positions);
    for (std::uint32_t f = 0; f < count; ++f) {
        const auto [i, j, k] = sheet.faces[f];
        out.add(i, j, k, f);
    }
    return out;
}

/// Takes a triangle that is nearer, or as near with a lower face.
void take_nearer(const Triangle& triangle, std::uint32_t t, const Vec3d& p, Nearest& nearest) {
    Vec3d q;
    std::array<double, 3> b{};
    const double squared = triangle_distance(triangle, p, q, b);
    if (squared < nearest.squared || (squared == nearest.squared && triangle.face < nearest.face))
        nearest = {squared, triangle.face, t, q, b};
}

Nearest nearest_of_all(const Triangles& triangles, const Vec3d& p) {
    Nearest out;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) { take_nearer(triangles[t], t, p, out); }
    return out;
}

std::vector<Vec3d> far_points() {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> u(-0.5, 1.5);
    std::vector<Vec3d> out(200);
    for (Vec3d& p : out) p = {u(random), u(random), u(random)};
    return out;
}

TEST(BoxTree, FindsTheNearestOfACrowdAfterAFewLooks) {
    for (const double size : {1e-3, 1e-6, 1e-9, 1e-12, 0.0}) {
        const Sheet sheet = crowd(size);
        const Triangles triangles = triangles_of(sheet, sheet.faces.size() - 1);
        std::vector<std::uint32_t> members(triangles.size());
        std::iota(members.begin(), members.end(), 0U);
        const BoxTree tree(triangles, members, BoxTree::Of::kCrowd);
        std::size_t looks = 0;
        for (const Vec3d& p : far_points()) {
            Nearest nearest;
            const auto look = [&](std::uint32_t t) {
                ++looks;
                take_nearer(triangles[t], t, p, nearest);
            };
            tree.search(p, 2, nearest, look);
            const Nearest expected = nearest_of_all(triangles, p);
            ASSERT_EQ(nearest.face, expected.face) << size;
            ASSERT_EQ(nearest.squared, expected.squared) << size;
        }
        // Doubles resolve 1e-16 here, so a sheet of 1e-12 has ties that have to be looked at.
        EXPECT_LE(looks, far_points().size() * (size == 1e-12 ? 600 : 40)) << size;
    }
}

TEST(BoxTree, OfCoincidentTrianglesLooksAtTheLowestFaceAlone) {
    const Sheet sheet = crowd(0);
    const Triangles triangles = triangles_of(sheet, 1000);
    std::vector<std::uint32_t> members(triangles.size());
    std::iota(members.rbegin(), members.rend(), 0U);
    const BoxTree tree(triangles, members, BoxTree::Of::kCrowd);
    std::vector<std::uint32_t> looked;
    tree.search({0, 0, 0}, 1, Nearest{}, [&](std::uint32_t t) { looked.push_back(t); });
    EXPECT_EQ(looked, std::vector<std::uint32_t>{0});
}

/// A triangle with `count` corners in line on one side, split into needles that meet at its far corner, and turned out
/// of the planes of the axes.
Sheet fan(std::uint32_t count) {
    const Vec3d along{0.8, 0.36, 0.48}, up{-0.6, 0.48, 0.64};  // at right angles
    Sheet out;
    out.positions.push_back(along * 0.5 + up);
    for (std::uint32_t k = 0; k <= count; ++k) out.positions.push_back(along * (static_cast<double>(k) / count));
    for (std::uint32_t k = 0; k < count; ++k) out.faces.push_back({0, k + 1, k + 2});
    return out;
}

/// On the fan, beside it and over it.
std::vector<Vec3d> points_by(const Sheet& fan, double over) {
    std::mt19937_64 random(9);
    std::uniform_real_distribution<double> u(-0.2, 1.2);
    const Vec3d normal =
        normalized(cross(fan.positions[1] - fan.positions[0], fan.positions.back() - fan.positions[0]), {});
    std::vector<Vec3d> out(100);
    for (Vec3d& p : out) {
        const Vec3d foot = fan.positions[1] + (fan.positions.back() - fan.positions[1]) * u(random);
        p = fan.positions[0] + (foot - fan.positions[0]) * std::abs(u(random)) + normal * (over * u(random));
    }
    return out;
}

TEST(BoxTree, FindsTheNearestOfAFanOfNeedlesAfterAFewLooks) {
    const Sheet sheet = fan(50'000);
    const Triangles triangles = triangles_of(sheet, sheet.faces.size());
    std::vector<std::uint32_t> members(triangles.size());
    std::iota(members.begin(), members.end(), 0U);
    const BoxTree crowd(triangles, members, BoxTree::Of::kCrowd), needles(triangles, members, BoxTree::Of::kNeedles);
    std::size_t looks[2] = {0, 0};
    for (const Vec3d& p : points_by(sheet, 1e-4)) {
        Nearest found[2];
        for (const int k : {0, 1})
            (k == 0 ? crowd : needles).search(p, 2, found[k], [&](std::uint32_t t) {
                ++looks[k];
                take_nearer(triangles[t], t, p, found[k]);
            });
        ASSERT_EQ(found[1].face, found[0].face);
        ASSERT_EQ(found[1].squared, found[0].squared);
    }
    EXPECT_LE(looks[1],
              100 * 1000U);  // of 50,000 each; most are those of points by the far corner, where all needles are
    EXPECT_GE(looks[0], 20 * looks[1]) << "boxes alone would do, and this tests nothing";
}

TEST(ClosestPointIndex, AnswersOverFansOfNeedlesAsASearchOfAllFacesDoes) {
    const Sheet sheet = fan(40'000);
    const Triangles triangles = triangles_of(sheet, sheet.faces.size());
    const ClosestPointIndex index(sheet.positions, sheet.faces);
    EXPECT_EQ(index.pieces(), 1U) << "the needles have a hierarchy of their own";
    for (const double over : {0.0, 1e-5, 0.3})
        for (const Vec3d& p : points_by(sheet, over)) {
            const ClosestPoint found = index.query(p);
            double least = kInfinity;
            for (std::uint32_t f = 0; f < sheet.faces.size(); ++f) {
                Vec3d q;
                std::array<double, 3> b{};
                least = std::min(least, triangle_distance(triangles[f], p, q, b));
            }
            ASSERT_NEAR(found.distance, std::sqrt(least), 1e-9) << over;
        }
}

/// Rectangles of two triangles that meet at one edge, as the pages of a book at its spine.
Sheet book(std::uint32_t pages) {
    Sheet out;
    out.positions = {{0, 0, 0}, {0, 0, 1}};
    for (std::uint32_t k = 0; k < pages; ++k) {
        const double angle = 6.283185307179586 * k / pages;
        const auto v = static_cast<std::uint32_t>(out.positions.size());
        out.positions.push_back({std::cos(angle), std::sin(angle), 1});
        out.positions.push_back({std::cos(angle), std::sin(angle), 0});
        out.faces.push_back({0, 1, v});
        out.faces.push_back({0, v, v + 1});
    }
    return out;
}

/// On pages, away from the spine.
std::vector<Vec3d> points_by_pages(std::uint32_t pages) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> u(0, 1);
    std::vector<Vec3d> out(300);
    for (Vec3d& p : out) {
        const double angle = 6.283185307179586 * std::floor(u(random) * pages) / pages, radius = 0.1 + 0.85 * u(random);
        p = {radius * std::cos(angle), radius * std::sin(angle), u(random)};
    }
    return out;
}

TEST(BoxTree, FindsTheNearestOfManyPagesAfterAFewLooks) {
    constexpr std::uint32_t kPages = 4000;
    const Sheet sheet = book(kPages);
    const Triangles triangles = triangles_of(sheet, sheet.faces.size());
    const std::vector<std::uint32_t> members = crossing_facets(triangles, std::vector<char>(triangles.size()));
    EXPECT_GT(members.size(), triangles.size() * 9 / 10) << "but for pages along the axes, whose boxes are flat";
    const BoxTree boxes(triangles, members, BoxTree::Of::kCrowd), facets(triangles, members, BoxTree::Of::kFacets);
    std::size_t looks[2] = {0, 0};
    for (const Vec3d& p : points_by_pages(kPages)) {
        const Nearest expected = nearest_of_all(triangles, p);
        Nearest found[2];
        for (const int k : {0, 1}) {
            const auto look = [&](std::uint32_t t) {
                ++looks[k];
                take_nearer(triangles[t], t, p, found[k]);
            };
            look(expected.face);  // as a hint: the face of the point before it is near
            (k == 0 ? boxes : facets).search(p, 2, found[k], look);
        }
        ASSERT_EQ(found[1].face, found[0].face);
        ASSERT_EQ(found[1].squared, found[0].squared);
    }
    EXPECT_LE(looks[1], 300 * 100U) << "of 8,000 each";
    EXPECT_GE(looks[0], 10 * looks[1]) << "boxes alone would do, and this tests nothing";
}

TEST(BoxTree, LeavesOrdinarySurfacesToTheirBoxes) {
    Sheet sheet = crowd(1);
    const std::vector<char> none(2 * sheet.faces.size());
    EXPECT_TRUE(crossing_facets(triangles_of(sheet, sheet.faces.size()), none).empty());
    const Sheet pages = book(40);
    const auto first = static_cast<std::uint32_t>(sheet.positions.size());
    sheet.positions.insert(sheet.positions.end(), pages.positions.begin(), pages.positions.end());
    for (const Face& f : pages.faces) sheet.faces.push_back({first + f[0], first + f[1], first + f[2]});
    EXPECT_TRUE(crossing_facets(triangles_of(sheet, sheet.faces.size()), none).empty()) << "few cross";
}

TEST(ClosestPointIndex, AnswersOverPagesAsASearchOfAllFacesDoes) {
    const Sheet sheet = book(3000);
    const Triangles triangles = triangles_of(sheet, sheet.faces.size());
    const ClosestPointIndex index(sheet.positions, sheet.faces);
    EXPECT_LT(index.pieces(), 600U) << "most have a hierarchy of their own";
    std::uint32_t hint = ClosestPointIndex::kNoFace;
    std::vector<Vec3d> points = points_by_pages(3000);
    points.push_back({0, 0, 0.4});  // on the spine
    points.push_back({0, 0, 0});
    for (const Vec3d& p : points) {
        const ClosestPoint found = index.query(p, hint), again = index.query(p);
        hint = found.face;
        EXPECT_EQ(found.face, again.face) << "a hint never changes the result";
        double least = kInfinity;
        for (std::uint32_t f = 0; f < sheet.faces.size(); ++f) {
            Vec3d q;
            std::array<double, 3> b{};
            least = std::min(least, triangle_distance(triangles[f], p, q, b));
        }
        ASSERT_NEAR(found.distance, std::sqrt(least), 1e-12);
    }
}

/// Half a million needles side by side, as in the border strip of a comb's chart: sixteen pieces of each took 2 GB.
TEST(ClosestPointIndex, HoldsAsManyPiecesAsItCanAfford) {
    for (const std::uint32_t count : {1'000U, 600'000U}) {
        Sheet sheet;
        const double step = 1.0 / 1000;  // 600 rows, 1000 needles each
        for (std::uint32_t k = 0; k < count; ++k) {
            const double x = k % 1000 * step, y = k / 1000;
            const auto first = static_cast<std::uint32_t>(sheet.positions.size());
            sheet.positions.insert(sheet.positions.end(), {{x, y, 0}, {x + step, y, 0}, {x, y + 0.9, 0}});
            sheet.faces.push_back({first, first + 1, first + 2});
        }
        const ClosestPointIndex index(sheet.positions, sheet.faces);
        EXPECT_EQ(index.pieces(), count == 1'000 ? 16'000U : count);
        const ClosestPoint found = index.query({500.25 * step, 0.3, 0.5});
        EXPECT_EQ(found.face, 500U);
        EXPECT_NEAR(found.distance, 0.5, 1e-9 * count);
    }
}

/// The whole index, crowds and all, against every face in turn.
TEST(ClosestPointIndex, AnswersOverCrowdsAsASearchOfAllFacesDoes) {
    for (const double size : {1e-2, 1e-3, 1e-6, 0.0}) {
        const Sheet sheet = crowd(size);
        const ClosestPointIndex index(sheet.positions, sheet.faces);
        std::uint32_t hint = ClosestPointIndex::kNoFace;
        for (const Vec3d& p : far_points()) {
            const ClosestPoint found = index.query(p, hint), again = index.query(p);
            hint = found.face;
            EXPECT_EQ(found.face, again.face) << "a hint never changes the result";
            double least = kInfinity;
            for (const Face& f : sheet.faces) {
                Triangle t{};
                t.a = sheet.positions[f[0]];
                t.b = sheet.positions[f[1]];
                t.c = sheet.positions[f[2]];
                t.normal = cross(t.b - t.a, t.c - t.a);
                t.normal_squared = dot(t.normal, t.normal);
                Vec3d q;
                std::array<double, 3> b{};
                least = std::min(least, triangle_distance(t, p, q, b));
            }
            EXPECT_NEAR(found.distance, std::sqrt(least), 1e-12) << size;
        }
    }
}

}  // namespace
}  // namespace dgm::bake
