// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/spatial/closest_point_test.cpp
// The index against known distances and against an exhaustive search in long double by another method.
#include "geometry/spatial/closest_point.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "unit/geometry/metrics/test_meshes.h"

namespace dgm::bake {
namespace {
using model::Face;
using model::Vec3d;

struct Wide {
    long double x, y, z;
};
Wide wide(const Vec3d& a) {
    return {a.x, a.y, a.z};
}
Wide operator-(const Wide& a, const Wide& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Wide operator+(const Wide& a, const Wide& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
Wide operator*(const Wide& a, long double s) {
    return {a.x * s, a.y * s, a.z * s};
}
long double dot(const Wide& a, const Wide& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

long double segment(const Wide& p, const Wide& a, const Wide& b) {
    const Wide e = b - a;
    const long double squared = dot(e, e);
    const long double t = squared > 0 ? std::clamp<long double>(dot(p - a, e) / squared, 0, 1) : 0;
    const Wide d = p - (a + e * t);
    return dot(d, d);
}

/// Squared distance by minimising over the edges and, where the unconstrained minimum of |p - a - s u - t v| lies
/// inside, over the plane: Gram-Schmidt, so needles lose little.
long double reference(const Vec3d& point, const Vec3d& pa, const Vec3d& pb, const Vec3d& pc) {
    const Wide p = wide(point), a = wide(pa), b = wide(pb), c = wide(pc);
    long double best = std::min({segment(p, a, b), segment(p, b, c), segment(p, c, a)});
    const Wide u = b - a, v = c - a, d = p - a;
    const long double uu = dot(u, u);
    if (!(uu > 0)) return best;
    const Wide w = v - u * (dot(u, v) / uu);  // v's part across u
    const long double ww = dot(w, w);
    if (!(ww > 1e-30L * uu)) return best;
    const long double t = dot(d, w) / ww, s = dot(d, u) / uu - t * dot(u, v) / uu;
    if (s < 0 || t < 0 || s + t > 1) return best;
    const Wide r = d - (u * s + v * t);
    return std::min(best, dot(r, r));
}

/// Triangles of many sizes, among them needles of every thinness, flat ones and points.
struct Soup {
    std::vector<Vec3d> positions;
    std::vector<Face> faces;
};
Soup random_soup(std::uint64_t seed, std::uint32_t count, double scale, const Vec3d& offset) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> u(-1, 1);
    const auto vec = [&] { return Vec3d{u(random), u(random), u(random)}; };
    Soup soup;
    for (std::uint32_t f = 0; f < count; ++f) {
        const Vec3d a = vec(), b = a + vec() * std::pow(10.0, -2 * std::abs(u(random)));
        Vec3d c = a + vec() * std::pow(10.0, -2 * std::abs(u(random)));
        if (f % 3 == 1)
            c = a + (b - a) * u(random) + vec() * std::pow(10.0, -16 * std::abs(u(random)));  // needle or cap
        if (f % 97 == 0) c = (a + b) * 0.5;
        if (f % 101 == 0) c = a;
        for (const Vec3d& p : {a, b, c}) soup.positions.push_back(p * scale + offset);
        soup.faces.push_back({3 * f, 3 * f + 1, 3 * f + 2});
    }
    return soup;
}

class ClosestPointSoup : public testing::TestWithParam<std::pair<double, Vec3d>> {};

TEST_P(ClosestPointSoup, AgreesWithExhaustiveSearch) {
    const auto [scale, offset] = GetParam();
    const Soup soup = random_soup(11, 200, scale, offset);
    const ClosestPointIndex index(soup.positions, soup.faces);
    std::mt19937_64 random(23);
    std::uniform_real_distribution<double> u(-1.5, 1.5);
    // Coordinates near `offset` carry its rounding; the search itself must not add more than a few units of it.
    const double tolerance = 1e-9 * scale + 8 * std::numeric_limits<double>::epsilon() * length(offset);
    for (int k = 0; k < 10'000; ++k) {
        Vec3d p = Vec3d{u(random), u(random), u(random)} * scale + offset;
        if (k % 5 == 0) p = soup.positions[random() % soup.positions.size()] + (p - offset) * 1e-7;  // almost touching
        if (k % 50 == 0) p = (p - offset) * 1e4 + offset;                                            // far away
        long double best = std::numeric_limits<long double>::infinity();
        for (const Face& f : soup.faces)
            best = std::min(best, reference(p, soup.positions[f[0]], soup.positions[f[1]], soup.positions[f[2]]));
        const double want = static_cast<double>(std::sqrt(best));
        const ClosestPoint found = index.query(p);
        ASSERT_NEAR(found.distance, want, tolerance + 1e-14 * want) << "query " << k;
        ASSERT_LT(found.face, soup.faces.size());
        // The point is where the barycentric coordinates say, and as far as the distance says.
        const Face& f = soup.faces[found.face];
        const Vec3d at = soup.positions[f[0]] * found.barycentric[0] + soup.positions[f[1]] * found.barycentric[1] +
                         soup.positions[f[2]] * found.barycentric[2];
        ASSERT_NEAR(length(at - found.point), 0, tolerance);
        ASSERT_NEAR(length(p - found.point), found.distance, tolerance + 1e-14 * want);
        for (const double w : found.barycentric) ASSERT_GE(w, 0);
        // A hint, good or bad, changes nothing.
        const ClosestPoint hinted = index.query(p, static_cast<std::uint32_t>(random() % 250));
        ASSERT_EQ(hinted.face, found.face);
        ASSERT_EQ(hinted.distance, found.distance);
        ASSERT_EQ(hinted.point, found.point);
    }
}
INSTANTIATE_TEST_SUITE_P(Frames, ClosestPointSoup,
                         testing::Values(std::pair{1.0, Vec3d{}}, std::pair{1e-9, Vec3d{}},
                                         std::pair{1.0, Vec3d{1e7, -1e7, 3e6}}, std::pair{1e12, Vec3d{}}));

TEST(ClosestPoint, RegionsOfOneTriangle) {
    const std::vector<Vec3d> positions{{0, 0, 0}, {4, 0, 0}, {0, 3, 0}};
    const std::vector<Face> faces{{0, 1, 2}};
    const ClosestPointIndex index(positions, faces);
    const auto expect = [&](Vec3d p, Vec3d q, double distance) {
        const ClosestPoint found = index.query(p);
        EXPECT_NEAR(length(found.point - q), 0, 1e-14);
        EXPECT_NEAR(found.distance, distance, 1e-14);
    };
    expect({1, 1, 2}, {1, 1, 0}, 2);                           // face
    expect({1, -2, 0}, {1, 0, 0}, 2);                          // edge
    expect({-3, -4, 0}, {0, 0, 0}, 5);                         // corner
    expect({2 + 3, 1.5 + 4, 0}, {2, 1.5, 0}, 5);               // hypotenuse, along its normal (3, 4)/5
    expect({4, 3, 12}, {2.56, 1.08, 0}, std::hypot(2.4, 12));  // foot of (4, 3) on the hypotenuse
}

TEST(ClosestPoint, TiesGoToTheLowestFace) {
    const auto mesh = test::square(1, 0, 8);
    const ClosestPointIndex index(mesh.positions, mesh.faces);
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
        std::uint32_t lowest = ClosestPointIndex::kNoFace;
        for (std::uint32_t f = 0; f < mesh.faces.size() && lowest == ClosestPointIndex::kNoFace; ++f)
            for (const std::uint32_t w : mesh.faces[f])
                if (w == v) lowest = f;
        EXPECT_EQ(index.query(mesh.positions[v]).face, lowest);
        EXPECT_EQ(index.query(mesh.positions[v]).distance, 0);
    }
    // Twice the same triangle, and its mirror image in winding.
    const std::vector<Vec3d> positions{{0, 0, 0}, {1, 0.1, 0}, {0.3, 1, 0.2}};
    const std::vector<Face> faces{{2, 0, 1}, {0, 1, 2}, {1, 0, 2}};
    const ClosestPointIndex twice(positions, faces);
    EXPECT_EQ(twice.query({-1, 0.5, 3}).face, 0u);
    EXPECT_EQ(twice.query({0.2, -1, 0}).face, 0u);
}

TEST(ClosestPoint, FacingIgnoresTheOtherSide) {
    auto mesh = test::square(1, 0, 2);  // faces up
    const auto below = test::square(1, -1, 2);
    const auto shift = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), below.positions.begin(), below.positions.end());
    for (const Face& f : below.faces) mesh.faces.push_back({f[0] + shift, f[2] + shift, f[1] + shift});
    const ClosestPointIndex index(mesh.positions, mesh.faces);
    EXPECT_NEAR(index.query({0.4, 0.6, -0.1}).distance, 0.1, 1e-15);
    EXPECT_NEAR(index.query_facing({0.4, 0.6, -0.1}, {0, 0, -1}, 0.5).distance, 0.9, 1e-15);
    EXPECT_NEAR(index.query_facing({0.4, 0.6, -0.1}, {0, 0, 1}, 0.5).distance, 0.1, 1e-15);
    EXPECT_EQ(index.query_facing({0.4, 0.6, -0.1}, {1, 0, 0}, 0.5).face, ClosestPointIndex::kNoFace);
    constexpr auto kNoHint = ClosestPointIndex::kNoFace;
    EXPECT_NEAR(index.query_facing({0.4, 0.6, -0.1}, {0, 0, -1}, 0.5, kNoHint, 0.9).distance, 0.9, 1e-15);
    EXPECT_EQ(index.query_facing({0.4, 0.6, -0.1}, {0, 0, -1}, 0.5, kNoHint, 0.89).face, kNoHint);
}

TEST(ClosestPoint, BrokenInput) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    const std::vector<Vec3d> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {nan, 0, 0}, {0, inf, 0}};
    const std::vector<Face> faces{{0, 1, 3}, {0, 1, 4}, {0, 1, 77}, {0, 1, 2}};
    const ClosestPointIndex index(positions, faces);
    const ClosestPoint found = index.query({0.2, 0.2, 5});
    EXPECT_EQ(found.face, 3u);
    EXPECT_NEAR(found.distance, 5, 1e-14);
    EXPECT_EQ(index.query({nan, 0, 0}).face, ClosestPointIndex::kNoFace);
    EXPECT_EQ(index.query({1e30, 0, 0}).face, 3u);
    EXPECT_NEAR(index.query({1e30, 0, 0}).distance, 1e30, 1e15);
    const ClosestPointIndex none(positions, std::span<const Face>{});
    EXPECT_EQ(none.query({0, 0, 0}).face, ClosestPointIndex::kNoFace);
    const std::vector<Face> point{{1, 1, 1}};
    EXPECT_NEAR(ClosestPointIndex(positions, point).query({1, 2, 0}).distance, 2, 1e-15);
}

}  // namespace
}  // namespace dgm::bake
