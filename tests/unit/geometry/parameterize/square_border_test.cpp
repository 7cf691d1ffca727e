// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/parameterize/square_border_test.cpp
// Interval counts by hand, and what a laid border promises on every kind of cut.
#include "geometry/parameterize/square_border.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <tuple>

#include "geometry/cut/cut_graph.h"
#include "geometry/repair/repair.h"
#include "model/codes.h"
#include "support/disk_checks.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

using Counts = std::vector<std::uint32_t>;

BorderPath real_path(double length, bool loop = false) {
    BorderPath path;
    path.length = length;
    path.is_loop = loop;
    return path;
}
BorderPath mated(double length, std::uint32_t mate, bool loop = false) {
    BorderPath path = real_path(length, loop);
    path.mate = mate;
    return path;
}

TEST(AllocateIntervals, SharesOfTheLength) {
    EXPECT_EQ(allocate_intervals({real_path(1), real_path(1), real_path(1), real_path(1)}, 16), (Counts{4, 4, 4, 4}));
    EXPECT_EQ(allocate_intervals({real_path(3), real_path(2), real_path(1)}, 12), (Counts{6, 4, 2}));
    EXPECT_EQ(allocate_intervals({real_path(5, true)}, 10), (Counts{10}));
}

TEST(AllocateIntervals, LargestRemainder) {
    EXPECT_EQ(allocate_intervals({real_path(2.6), real_path(3.3), real_path(4.1)}, 10), (Counts{3, 3, 4}));
    EXPECT_EQ(allocate_intervals({real_path(2.4), real_path(3.5), real_path(4.1)}, 10), (Counts{2, 4, 4}));
    EXPECT_EQ(allocate_intervals({real_path(2.3), real_path(3.3), real_path(4.4)}, 10), (Counts{2, 3, 5}));
    EXPECT_EQ(allocate_intervals({real_path(2.7), real_path(3.6), real_path(3.7)}, 10), (Counts{3, 3, 4}));
}

TEST(AllocateIntervals, MatesGetTheSame) {
    EXPECT_EQ(allocate_intervals({mated(2, 2), real_path(6), mated(2, 0)}, 20), (Counts{4, 12, 4}));
    // 2 * 2.4 + 5.2 of 10: one interval is left when all are rounded down, too little for a pair.
    EXPECT_EQ(allocate_intervals({mated(2.4, 2), real_path(5.2), mated(2.4, 0)}, 10), (Counts{2, 6, 2}));
    // 2 * 2.9 + 4.2: two are left, and the pair lacks most.
    EXPECT_EQ(allocate_intervals({mated(2.9, 2), real_path(4.2), mated(2.9, 0)}, 10), (Counts{3, 4, 3}));
    EXPECT_EQ(allocate_intervals({mated(1, 1), mated(1, 0)}, 30), (Counts{15, 15}));
}

TEST(AllocateIntervals, ShortPathsGetTheirLeast) {
    EXPECT_EQ(allocate_intervals({real_path(0.01), real_path(10)}, 20), (Counts{2, 18}));
    EXPECT_EQ(allocate_intervals({real_path(0.01, true), real_path(10)}, 20), (Counts{3, 17}));
    EXPECT_EQ(allocate_intervals({mated(0, 2), real_path(10), mated(0, 0)}, 20), (Counts{2, 16, 2}));
    EXPECT_EQ(allocate_intervals({real_path(0), real_path(0), real_path(0), real_path(0)}, 12), (Counts{3, 3, 3, 3}));
    // Where two each do not fit, one each must do.
    const std::vector<BorderPath> many(10, real_path(1));
    const Counts tight = allocate_intervals(many, 12);
    EXPECT_EQ(std::accumulate(tight.begin(), tight.end(), 0u), 12u);
    EXPECT_EQ(*std::min_element(tight.begin(), tight.end()), 1u);
    EXPECT_EQ(*std::max_element(tight.begin(), tight.end()), 2u);
}

TEST(AllocateIntervals, PathsBetweenTheSamePointsKeepApart) {
    std::vector<BorderPath> many(10, real_path(1));
    many[3].parallel = many[7].parallel = true;
    const Counts tight = allocate_intervals(many, 12);
    EXPECT_EQ(tight, (Counts{1, 1, 1, 2, 1, 1, 1, 2, 1, 1})) << "one each would be the same edge";
}

TEST(AllocateIntervals, TooSmallAGridIsRefused) {
    const auto code = [](const std::vector<BorderPath>& paths, std::uint32_t total) {
        try {
            (void)allocate_intervals(paths, total);
        } catch (const model::Error& e) { return e.code().number; }
        return 0;
    };
    const int refused = model::codes::kGridTooSmall.number;
    EXPECT_EQ(code(std::vector<BorderPath>(13, real_path(1)), 12), refused);
    EXPECT_EQ(code(std::vector<BorderPath>(12, real_path(1)), 12), 0);
    EXPECT_EQ(code({real_path(1, true), real_path(1, true), real_path(1, true)}, 8), refused);
    EXPECT_EQ(code({mated(1, 1), mated(1, 0)}, 7), refused) << "pairs cannot share an odd number";
}

TEST(AllocateIntervals, RandomPathsKeepTheRules) {
    std::mt19937 random(17);
    std::uniform_real_distribution<double> u(0, 1);
    for (int round = 0; round < 300; ++round) {
        std::vector<BorderPath> paths;
        const auto pairs = static_cast<std::uint32_t>(random() % 6),
                   reals = static_cast<std::uint32_t>(1 + random() % 5);
        for (std::uint32_t k = 0; k < reals; ++k) paths.push_back(real_path(std::pow(u(random), 4), random() % 3 == 0));
        for (std::uint32_t k = 0; k < pairs; ++k) {
            const double l = std::pow(u(random), 4);
            const bool loop = random() % 3 == 0;
            const auto at = static_cast<std::uint32_t>(paths.size());
            paths.push_back(mated(l, at + 1, loop));
            paths.push_back(mated(l, at, loop));
        }
        const auto total = static_cast<std::uint32_t>(60 + 2 * (random() % 100));
        const Counts counts = allocate_intervals(paths, total);
        ASSERT_EQ(counts.size(), paths.size());
        EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), 0u), total);
        for (std::size_t p = 0; p < paths.size(); ++p) {
            EXPECT_GE(counts[p], paths[p].is_loop ? 3u : 2u);
            if (paths[p].mate != kNone) { EXPECT_EQ(counts[p], counts[paths[p].mate]); }
        }
        for (std::size_t p = 0; p < paths.size(); ++p)  // longer paths never get fewer
            for (std::size_t q = 0; q < paths.size(); ++q)
                if (paths[p].mate == kNone && paths[q].mate == kNone && paths[p].length > paths[q].length &&
                    paths[p].is_loop == paths[q].is_loop) {
                    EXPECT_GE(counts[p], counts[q]);
                }
    }
}

TEST(BorderGrid, SmallGridByHand) {
    const BorderGrid grid{3, 4};
    EXPECT_EQ(grid.count(), 10u);
    const std::uint32_t samples[10] = {0, 4, 8, 9, 10, 11, 7, 3, 2, 1};
    const double u[10] = {0, 0.5, 1, 1, 1, 1, 0.5, 0, 0, 0};
    const double v[10] = {0, 0, 0, 1 / 3.0, 2 / 3.0, 1, 1, 1, 2 / 3.0, 1 / 3.0};
    for (std::uint32_t t = 0; t < 10; ++t) {
        EXPECT_EQ(grid.sample(t), samples[t]);
        EXPECT_NEAR(grid.uv(t).x, u[t], 1e-15);
        EXPECT_NEAR(grid.uv(t).y, v[t], 1e-15);
    }
    EXPECT_NEAR(grid.uv(2.75).y, 0.25, 1e-15);
    EXPECT_NEAR(grid.uv(9.25).y, 0.25, 1e-15);
    EXPECT_EQ(grid.uv(9.25).x, 0);
}

// ---- the laid border ----

/// Place on the square's border, 0..4 counter-clockwise from (0, 0); -1 inside.
double around(Vec2d p) {
    if (p.y == 0 && p.x < 1) return p.x;
    if (p.x == 1 && p.y < 1) return 1 + p.y;
    if (p.y == 1 && p.x > 0) return 3 - p.x;
    if (p.x == 0) return 4 - p.y;
    return -1;
}
unsigned sides(Vec2d p) {
    return (p.y == 0 ? 1u : 0u) | (p.x == 1 ? 2u : 0u) | (p.y == 1 ? 4u : 0u) | (p.x == 0 ? 8u : 0u);
}

void expect_laid(const Disk& disk, const SquareBorder& border, std::uint32_t m, std::uint32_t n) {
    ASSERT_NO_FATAL_FAILURE(test::expect_links(disk));
    test::expect_disk(disk);
    const std::vector<std::uint32_t> cycle = disk.border();
    const std::size_t count = cycle.size();
    ASSERT_EQ(border.vertices.size(), count);
    ASSERT_EQ(border.uv.size(), count);
    for (std::size_t k = 0; k < count; ++k) ASSERT_EQ(border.vertices[k], origin(disk.mesh.faces, cycle[k]));
    // On the border, strictly counter-clockwise, once around, all four corners hit.
    int wraps = 0;
    std::set<std::pair<double, double>> seen;
    for (std::size_t k = 0; k < count; ++k) {
        const double t = around(border.uv[k]), next = around(border.uv[(k + 1) % count]);
        ASSERT_GE(t, 0) << "vertex " << k << " is off the border";
        ASSERT_NE(t, next);
        wraps += next < t;
        seen.emplace(border.uv[k].x, border.uv[k].y);
    }
    EXPECT_EQ(wraps, 1);
    for (double x : {0.0, 1.0})
        for (double y : {0.0, 1.0}) EXPECT_EQ(seen.count({x, y}), 1u) << "corner " << x << " " << y;
    // No edge inside may join two points of one side.
    std::vector<unsigned> side(disk.mesh.positions.size(), 0);
    for (std::size_t k = 0; k < count; ++k) side[border.vertices[k]] = sides(border.uv[k]);
    for (std::uint32_t h = 0; h < disk.opposite.size(); ++h)
        if (disk.opposite[h] != kNone) {
            ASSERT_EQ(side[origin(disk.mesh.faces, h)] & side[target(disk.mesh.faces, h)], 0u) << "half-edge " << h;
        }
    // Samples: one each, walking from (0,0) along u first; the point is the one that the border vertices put there.
    ASSERT_EQ(border.samples.size(), 2 * (m - 1) + 2 * (n - 1));
    std::set<std::uint32_t> indices;
    std::vector<Vec3d> points;
    for (std::size_t t = 0; t < border.samples.size(); ++t) {
        const BorderSample& s = border.samples[t];
        indices.insert(s.index);
        const std::uint32_t i = s.index / n, j = s.index % n;
        ASSERT_TRUE(i == 0 || j == 0 || i == m - 1 || j == n - 1);
        ASSERT_LT(s.at.face, disk.mesh.faces.size());
        EXPECT_NEAR(s.at.b[0] + s.at.b[1] + s.at.b[2], 1, 1e-12);
        Vec3d p;
        for (int k = 0; k < 3; ++k) {
            EXPECT_GE(s.at.b[k], 0);
            p += disk.mesh.positions[disk.mesh.faces[s.at.face][k]] * s.at.b[k];
        }
        points.push_back(p);
        const double want = around({i / (m - 1.0), j / (n - 1.0)});
        bool found = false;
        for (std::size_t k = 0; k < count && !found; ++k) {
            const double a = around(border.uv[k]);
            double b = around(border.uv[(k + 1) % count]), w = want;
            if (b < a) b += 4;
            if (w < a - 1e-12) w += 4;
            if (w < a - 1e-12 || w > b + 1e-12) continue;
            found = true;
            const double share = (w - a) / (b - a);
            const Vec3d q = disk.mesh.positions[border.vertices[k]] * (1 - share) +
                            disk.mesh.positions[border.vertices[(k + 1) % count]] * share;
            EXPECT_LT(length(p - q), 1e-9) << "sample " << i << ", " << j;
        }
        EXPECT_TRUE(found);
    }
    EXPECT_EQ(indices.size(), border.samples.size());
    for (std::size_t t = 0; t < border.samples.size(); ++t) {
        const std::uint32_t first = border.samples[t].same_as;
        ASSERT_LE(first, t);
        EXPECT_EQ(border.samples[first].same_as, first);
        EXPECT_LT(length(points[t] - points[first]), 1e-9) << "mates sample the same point";
    }
    // Every copy is known: a sample on a cut is not alone in its class.
    std::vector<int> members(border.samples.size(), 0);
    for (const BorderSample& s : border.samples) ++members[s.same_as];
    std::vector<int> copies(disk.weld_count, 0);
    for (std::uint32_t w : disk.weld) ++copies[w];
    for (const BorderSample& s : border.samples)
        for (int k = 0; k < 3; ++k)
            if (s.at.b[k] == 1) {
                EXPECT_EQ(members[s.same_as], copies[disk.weld[disk.mesh.faces[s.at.face][k]]]) << "sample " << s.index;
            }
}

std::vector<TriMesh> surfaces() {
    const std::array<std::array<std::uint32_t, 2>, 2> holes{{{1, 1}, {5, 3}}};
    TriMesh pyramid;
    pyramid.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    pyramid.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    return {test::icosphere(2),
            test::icosphere(0),
            pyramid,
            test::double_sided_quad(),
            test::torus(1, 0.4, 16, 9),
            test::genus_plate(2),
            test::annulus(1, 2, 12, 3),
            test::sheet_with_holes(7, holes),
            test::grid_sheet(4, 4),
            test::polygon_disk(3),
            test::polygon_disk(40),
            test::finger(0.1, 2, 8, 12, 3),
            test::slit_sheet(8, 0.01)};
}

TEST(SquareBorder, KeepsItsPromisesOnEverySurface) {
    int at = 0;
    for (const TriMesh& mesh : surfaces()) {
        CutGraph cut(mesh);
        cut.cut_to_disk();
        for (int branches = 0; branches < 3; ++branches) {
            if (branches > 0) cut.join(static_cast<std::uint32_t>(mesh.positions.size() * branches / 3));
            for (const auto& [m, n, rotation] :
                 {std::tuple{17u, 17u, 0u}, {17u, 17u, 5u}, {15u, 22u, 71u}, {33u, 9u, 13u}}) {
                SCOPED_TRACE("surface " + std::to_string(at) + " branches " + std::to_string(branches) + " grid " +
                             std::to_string(m) + "x" + std::to_string(n) + " rotation " + std::to_string(rotation));
                Disk disk = cut.open();
                const double area = test::surface_area(disk.mesh);
                const SquareBorder border = lay_square_border(disk, m, n, rotation);
                ASSERT_NO_FATAL_FAILURE(expect_laid(disk, border, m, n));
                EXPECT_NEAR(test::surface_area(disk.mesh), area, 1e-12 * area);
                EXPECT_GT(border.smallest_interval, 0);
            }
        }
        ++at;
    }
}

/// Corners of holes are nodes where there is room for them; a scan may have more than the grid has samples. Each edge
/// of a hole then is one of the welded border still, and no hole closes.
TEST(SquareBorder, HolesMayHaveMoreCornersThanThereIsRoomFor) {
    std::vector<std::array<std::uint32_t, 2>> quads;  // of 16 crosses: 12 corners each
    for (std::uint32_t i = 3; i < 20; i += 5)
        for (std::uint32_t j = 3; j < 20; j += 5)
            for (const auto& quad : {std::array{i, j}, {i - 1, j}, {i + 1, j}, {i, j - 1}, {i, j + 1}})
                quads.push_back(quad);
    const TriMesh mesh = test::sheet_with_holes(22, quads);
    CutGraph cut(mesh);
    cut.cut_to_disk();
    for (const std::uint32_t side : {33u, 65u}) {
        SCOPED_TRACE(side);
        Disk disk = cut.open();
        const std::uint32_t total = 4 * (side - 1);
        EXPECT_EQ(disk.paths().size() > total, side == 33);
        EXPECT_EQ(border_paths(disk, total).size() == disk.paths().size(), side == 65);
        const SquareBorder border = lay_square_border(disk, side, side, 0);
        ASSERT_NO_FATAL_FAILURE(expect_laid(disk, border, side, side));
        std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
        for (std::size_t t = 0; t < border.samples.size(); ++t) {
            const std::uint32_t a = border.samples[t].same_as;
            const std::uint32_t b = border.samples[(t + 1) % border.samples.size()].same_as;
            ++uses[std::minmax(a, b)];
        }
        std::size_t alone = 0;
        for (const auto& [edge, count] : uses) {
            EXPECT_NE(edge.first, edge.second);
            EXPECT_LE(count, 2);
            alone += count == 1;
        }
        EXPECT_GE(alone, 3u * (16 + 1)) << "three edges a hole";
    }
}

/// Surfaces with one side are opened in the repair; the border joins the two sides again, and says which copies face
/// the other way: those that an odd number of such sides lies between.
TEST(SquareBorder, JoinsTheSidesOfOneSidedSurfaces) {
    for (const TriMesh& source :
         {test::moebius(9, 3), test::moebius(30, 4), test::klein_bottle(16, 12), test::projective_plane(6, 24)}) {
        const TriMesh mesh = repair(source).components[0];
        CutGraph cut(mesh);
        cut.cut_to_disk();
        for (int branches = 0; branches < 3; ++branches) {
            if (branches > 0) cut.join(static_cast<std::uint32_t>(mesh.positions.size() * branches / 3));
            for (const auto& [m, n, rotation] :
                 {std::tuple{17u, 17u, 0u}, {17u, 17u, 5u}, {15u, 22u, 71u}, {33u, 9u, 13u}}) {
                SCOPED_TRACE("rotation " + std::to_string(rotation) + " branches " + std::to_string(branches));
                Disk disk = cut.open();
                const SquareBorder border = lay_square_border(disk, m, n, rotation);
                ASSERT_NO_FATAL_FAILURE(expect_laid(disk, border, m, n));
                const std::vector<std::uint8_t> reversed = disk.reversed_vertices();
                ASSERT_FALSE(reversed.empty());
                std::size_t against = 0;
                for (const BorderSample& s : border.samples) {
                    const BorderSample& first = border.samples[s.same_as];
                    against += s.reversed;
                    EXPECT_FALSE(first.reversed);
                    for (int k = 0; k < 3; ++k)
                        for (int l = 0; l < 3; ++l)
                            if (s.at.b[k] == 1 && first.at.b[l] == 1) {
                                const std::uint32_t a = disk.mesh.faces[s.at.face][k],
                                                    b = disk.mesh.faces[first.at.face][l];
                                EXPECT_EQ(s.reversed, reversed[a] != reversed[b]) << "sample " << s.index;
                            }
                }
                EXPECT_GT(against, 2u);
            }
        }
    }
}

/// A rectangle's own corners go to the square's, and its sides keep arc length.
TEST(SquareBorder, RectangleIsLaidSideBySide) {
    const TriMesh mesh = test::grid_sheet(6, 4, 3, 2);
    Disk disk = CutGraph(mesh).open();
    const SquareBorder border = lay_square_border(disk, 9, 9, 0);
    // Up to a quarter turn: the first path may be any side.
    const auto turned = [&](std::size_t k, int quarters) {
        Vec2d p{disk.mesh.positions[border.vertices[k]].x / 3, disk.mesh.positions[border.vertices[k]].y / 2};
        for (; quarters > 0; --quarters) p = {p.y, 1 - p.x};
        return p;
    };
    int quarters = 0;
    while (quarters < 4 && length(turned(0, quarters) - border.uv[0]) > 1e-12) ++quarters;
    ASSERT_LT(quarters, 4);
    for (std::size_t k = 0; k < border.vertices.size(); ++k)
        EXPECT_LT(length(turned(k, quarters) - border.uv[k]), 1e-12);
}

/// The first path starts at the sample asked for: leaves and corners move with the rotation.
TEST(SquareBorder, RotationCountsSamples) {
    const TriMesh mesh = test::annulus(1, 2, 12, 3);
    CutGraph cut(mesh);
    cut.cut_to_disk();
    const std::vector<BorderPath> paths = cut.open().paths();
    const std::uint32_t first = origin(cut.open().mesh.faces, paths[0].half_edges.front());
    const BorderGrid grid{11, 9};
    for (std::uint32_t r = 0; r < grid.count(); r += 3) {
        Disk disk = cut.open();
        const SquareBorder border = lay_square_border(disk, 11, 9, r);
        const auto at = std::find(border.vertices.begin(), border.vertices.end(), first) - border.vertices.begin();
        ASSERT_LT(static_cast<std::size_t>(at), border.vertices.size());
        const std::uint32_t sample = grid.sample(r);
        EXPECT_NEAR(border.uv[at].x, sample / 9 / 10.0, 1e-12);
        EXPECT_NEAR(border.uv[at].y, sample % 9 / 8.0, 1e-12);
    }
}

/// Vertices of one loop of a tube have one z: they fill one side of the square, corner to corner, and the two copies of
/// each vertex of the cut face each other.
TEST(SquareBorder, LoopsOfARingFaceEachOther) {
    const double height = 2;
    for (const double top : {1.0, 0.01, 5.0})
        for (const auto& [m, n] : {std::pair{17u, 17u}, {15u, 22u}, {33u, 9u}, {5u, 40u}})
            for (const BorderShares shares : {BorderShares::kLoopsOnM, BorderShares::kLoopsOnN}) {
                const bool on_m = shares == BorderShares::kLoopsOnM;
                if ((on_m ? m : n) < 5 || (on_m ? n : m) < 5) continue;
                SCOPED_TRACE(std::to_string(m) + "x" + std::to_string(n) + (on_m ? " on m" : " on n"));
                const TriMesh mesh = test::tube(1, top, height, 12, 4);
                CutGraph cut(mesh);
                cut.cut_to_disk();
                Disk disk = cut.open();
                const SquareBorder border = lay_square_border(disk, m, n, 3, shares);
                ASSERT_NO_FATAL_FAILURE(expect_laid(disk, border, m, n));
                // (along the loops, from loop to loop)
                const auto at = [&](std::size_t k) {
                    return on_m ? border.uv[k] : Vec2d{border.uv[k].y, border.uv[k].x};
                };
                std::vector<std::vector<double>> copies(disk.weld_count);
                double lower_side = -1;
                std::size_t on_loops = 0;
                for (std::size_t k = 0; k < border.vertices.size(); ++k) {
                    const Vec3d p = disk.mesh.positions[border.vertices[k]];
                    const Vec2d q = at(k);
                    if (p.z == 0 && lower_side < 0) lower_side = q.y;
                    if (p.z == 0) { EXPECT_EQ(q.y, lower_side); }
                    if (p.z == height) { EXPECT_EQ(q.y == 0, lower_side != 0) << q.y; }
                    on_loops += p.z == 0 || p.z == height;
                    if (q.x == 0 || q.x == 1) copies[disk.weld[border.vertices[k]]].push_back(q.y);
                }
                EXPECT_EQ(on_loops, 2 * (12u + 1));
                std::size_t pairs = 0;
                for (const std::vector<double>& both : copies)
                    if (!both.empty()) {
                        ASSERT_EQ(both.size(), 2u);
                        EXPECT_NEAR(both[0], both[1], 1e-12);
                        ++pairs;
                    }
                EXPECT_GE(pairs, 5u);
                for (const BorderSample& s : border.samples) {
                    const std::uint32_t i = s.index / n, j = s.index % n, along = on_m ? i : j;
                    const bool on_cut = along == 0 || along == (on_m ? m : n) - 1;
                    const std::uint32_t mate = border.samples[s.same_as].index;
                    if (!on_cut) { EXPECT_EQ(mate, s.index); }
                    if (on_cut) { EXPECT_EQ(on_m ? mate % n : mate / n, on_m ? j : i) << "in the same line"; }
                }
            }
}

/// Each path of a loop between corners of the open border by its share of the loop.
TEST(SquareBorder, CornersOfALoopLieOnSamples) {
    const TriMesh box = test::tube(1, 1, 1, 4, 3);  // a square tube: four corners a loop
    CutGraph cut(box);
    cut.cut_to_disk();
    Disk disk = cut.open();
    const SquareBorder border = lay_square_border(disk, 17, 9, 0, BorderShares::kLoopsOnM);
    for (std::size_t k = 0; k < border.vertices.size(); ++k)
        if (border.uv[k].y == 0 || border.uv[k].y == 1) {
            EXPECT_NEAR(std::remainder(border.uv[k].x, 0.25), 0, 1e-12) << border.uv[k].x;
        }
}

TEST(SquareBorder, OnlyACutFromLoopToLoopLetsThemFaceEachOther) {
    const auto code = [](Disk disk) {
        try {
            (void)lay_square_border(disk, 17, 17, 0, BorderShares::kLoopsOnM);
        } catch (const model::Error& e) { return e.code().number; }
        return 0;
    };
    const std::array<std::array<std::uint32_t, 2>, 2> holes{{{1, 1}, {5, 3}}};
    TriMesh mesh = test::tube(1, 1, 2, 12, 6);
    CutGraph branched(mesh);
    branched.cut_to_disk();
    EXPECT_EQ(code(branched.open()), 0);
    branched.join(3 * 12 + 6);
    const int unsuited = model::codes::kMethodUnsuited.number;
    EXPECT_EQ(code(branched.open()), unsuited) << "a branch";
    for (const TriMesh& other : {test::icosphere(2), test::torus(1, 0.4, 16, 9), test::grid_sheet(4, 4),
                                 test::sheet_with_holes(7, holes), test::finger(0.1, 2, 8, 12, 3)}) {
        CutGraph cut(other);
        cut.cut_to_disk();
        EXPECT_EQ(code(cut.open()), unsuited);
    }
    const TriMesh strip = repair(test::moebius(30, 4)).components[0];
    CutGraph one_sided(strip);
    one_sided.cut_to_disk();
    EXPECT_EQ(code(one_sided.open()), unsuited);
    Disk ring = [&] {
        CutGraph cut(mesh);
        cut.cut_to_disk();
        return cut.open();
    }();
    try {
        (void)lay_square_border(ring, 3, 17, 0, BorderShares::kLoopsOnM);
        FAIL() << "a loop in two intervals";
    } catch (const model::Error& e) { EXPECT_EQ(e.code().number, model::codes::kGridTooSmall.number); }
}

TEST(SquareBorder, CandidateRotationsKeepLeavesOffTheCorners) {
    for (const TriMesh& mesh : {test::icosphere(2), test::comb(3, 2), test::annulus(1, 2, 12, 3)}) {
        CutGraph cut(mesh);
        cut.cut_to_disk();
        cut.join(static_cast<std::uint32_t>(mesh.positions.size() / 2));
        const std::vector<std::uint32_t> rotations = candidate_rotations(cut.open(), 17, 13, 6);
        ASSERT_FALSE(rotations.empty());
        EXPECT_LE(rotations.size(), 6u);
        EXPECT_EQ(std::set<std::uint32_t>(rotations.begin(), rotations.end()).size(), rotations.size());
        for (std::uint32_t r : rotations) {
            Disk disk = cut.open();
            const std::vector<BorderPath> paths = disk.paths();
            std::set<std::uint32_t> leaves;
            for (std::size_t p = 0; p < paths.size(); ++p)
                if (paths[p].mate == (p + 1) % paths.size())
                    leaves.insert(target(disk.mesh.faces, paths[p].half_edges.back()));
            const SquareBorder border = lay_square_border(disk, 17, 13, r);
            for (std::size_t k = 0; k < border.vertices.size(); ++k)
                if (leaves.count(border.vertices[k])) {
                    const Vec2d p = border.uv[k];
                    EXPECT_FALSE((p.x == 0 || p.x == 1) && (p.y == 0 || p.y == 1));
                }
        }
    }
}

TEST(SquareBorder, TooSmallAGridIsRefused) {
    const TriMesh plate = test::genus_plate(5);
    CutGraph handles(plate);
    handles.cut_to_disk();
    Disk disk = handles.open();
    try {
        (void)lay_square_border(disk, 4, 4, 0);
        FAIL() << "accepted";
    } catch (const model::Error& e) { EXPECT_EQ(e.code().number, model::codes::kGridTooSmall.number); }
}

}  // namespace
}  // namespace dgm::bake
