// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/pick_test.cpp
// Rays: against planes and spheres by formula, against another triangle test in long double, and to the bit against the
// same test on every triangle. DGM_PICK_RAYS=1000000 asks for the long form of the last.
#include <gtest/gtest.h>

#include <dgm/contact.h>
#include <dgm/deform.h>
#include <dgm/dgm.h>
#include <dgm/pick.h>
#include <dgm/tick.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

#include "../../../libdgm/src/ray_triangle.h"
#include "contact_shapes.h"
#include "opened.h"

namespace dgm::test {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

Point flat(double i, double j) {
    return {static_cast<float>(i), static_cast<float>(j), 0};
}
/// A closed tube with folds: near sheets that are far apart along the surface.
Point folds(double i, double j) {
    const double a = 2 * 3.14159265358979 * j / 40, r = 3 + 2.5 * std::sin(3 * a) * std::cos(i / 4);
    return {static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)), static_cast<float>(i / 5)};
}
ChartSpec mixed(ChartSpec chart, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<std::uint8_t> bits((chart.rows - 1) * (chart.cols - 1));
    for (std::uint8_t& bit : bits) bit = static_cast<std::uint8_t>(random() >> 31);
    chart.add("diagonals", ElementType::kU8, {chart.rows - 1, chart.cols - 1}, bits);
    return chart;
}
DeformTable table_of(std::uint32_t reach) {
    KernelOptions kernel;
    kernel.reach = reach;
    kernel.sigma = static_cast<float>(reach);
    return DeformTable::create(kernel).value();
}
double length(Vec3 v) {
    return std::sqrt(double{v.x} * v.x + double{v.y} * v.y + double{v.z} * v.z);
}

// --- Expected values by formula ---------------------------------------------------------------------------------

TEST(Pick, FlatSheetByHand) {
    State state = make_state(grid_chart(20, 30, flat));
    // Quad (3, 7), diagonal 0 from (3, 7) to (4, 8): (3.75, 7.25) lies on the side of (4, 7), triangle 0.
    const auto hit = pick_ray(state, {3.75f, 7.25f, 5}, {0, 0, -0.25f}).value();
    EXPECT_EQ(hit.row, 3u);
    EXPECT_EQ(hit.column, 7u);
    EXPECT_EQ(hit.triangle, 0u);
    EXPECT_EQ(hit.corners[0], 3u * 30 + 7);
    EXPECT_EQ(hit.corners[1], 4u * 30 + 7);
    EXPECT_EQ(hit.corners[2], 4u * 30 + 8);
    EXPECT_FLOAT_EQ(hit.barycentric[0], 0.25f);  // 3.75 = 4 - 0.25, 7.25 = 7 + 0.25
    EXPECT_FLOAT_EQ(hit.barycentric[1], 0.5f);
    EXPECT_FLOAT_EQ(hit.barycentric[2], 0.25f);
    EXPECT_EQ(hit.sample, 4u * 30 + 7);
    EXPECT_EQ(hit.distance, 5);  // not 20 lengths of the direction
    EXPECT_EQ(hit.point, (Vec3{3.75f, 7.25f, 0}));
    EXPECT_EQ(hit.normal, (Vec3{0, 0, 1}));  // u along x, v along y
    EXPECT_TRUE(hit.front);
    // From below it is seen from behind; the other triangle of the quad.
    const auto back = pick_ray(state, {3.25f, 7.5f, -2}, {0, 0, 1e-20f}).value();
    EXPECT_EQ(back.triangle, 1u);
    EXPECT_EQ(back.distance, 2);
    EXPECT_FALSE(back.front);
    EXPECT_EQ(back.normal, (Vec3{0, 0, 1}));
    PickOptions front_only;
    front_only.back_faces = false;
    EXPECT_EQ(pick_ray(state, {3.25f, 7.5f, -2}, {0, 0, 1}, front_only).error().code, ErrorCode::NotFound);
    EXPECT_TRUE(pick_ray(state, {3.25f, 7.5f, 2}, {0, 0, -1}, front_only).ok());
}

TEST(Pick, DistanceAndItsLimit) {
    State state = make_state(grid_chart(20, 30, flat));
    // 3-4-5: 12 along, 9 down is 15.
    PickOptions options;
    options.max_distance = 15;
    EXPECT_EQ(pick_ray(state, {2, 7.5f, 9}, {4, 0, -3}, options).value().distance, 15);
    options.max_distance = std::nextafter(15.0f, 0.0f);
    EXPECT_EQ(pick_ray(state, {2, 7.5f, 9}, {4, 0, -3}, options).error().code, ErrorCode::NotFound);
    // On the surface: distance 0, whichever way.
    options.max_distance = 0;
    for (const Vec3 d : {Vec3{0, 0, 1}, Vec3{0, 0, -1}, Vec3{1, 2, -0.5f}})
        EXPECT_EQ(pick_ray(state, {3.5f, 7.25f, 0}, d, options).value().distance, 0);
    EXPECT_FALSE(pick_ray(state, {3.5f, 7.25f, 1}, {0, 0, 1}).ok());  // behind the origin
    EXPECT_FALSE(pick_ray(state, {3.5f, 30, 1}, {0, 0, -1}).ok());    // beside the sheet
    EXPECT_FALSE(pick_ray(state, {-5, 7.25f, 0}, {1, 0, 0}).ok());    // in its plane
    EXPECT_FALSE(pick_ray(state, {-5, 7.25f, 1e-6f}, {1, 0, 0}).ok());
}

TEST(Pick, SphereByFormula) {
    constexpr std::uint32_t kSide = 65;
    State state = make_state(sphere_chart(kSide));
    // A chord's sagitta: edges here are at most 2.2 * pi / 64 long.
    const double sag = 0.11 * 0.11 / 2;
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    int hits = 0, misses = 0;
    for (int k = 0; k < 5000; ++k) {
        const double o[3] = {2 * normal(random), 2 * normal(random), 2 * normal(random)};
        // Towards the sphere, more or less.
        const double d[3] = {normal(random) - o[0], normal(random) - o[1], normal(random) - o[2]};
        double oo = 0, od = 0, dd = 0;
        for (int a = 0; a < 3; ++a) oo += o[a] * o[a], od += o[a] * d[a], dd += d[a] * d[a];
        const double root = od * od - dd * (oo - 1), away = oo - od * od / dd;  // squared distance of the line
        if (std::fabs(std::sqrt(oo) - 1) < 2 * sag || std::fabs(std::sqrt(away) - 1) < 0.05) continue;
        const bool inside = oo < 1;
        const auto hit =
            pick_ray(state, {float(o[0]), float(o[1]), float(o[2])}, {float(d[0]), float(d[1]), float(d[2])});
        const bool expected = inside || (away < 1 && od < 0);
        ASSERT_EQ(hit.ok(), expected) << k;
        if (!expected) {
            ++misses;
            continue;
        }
        ++hits;
        const double t = (-od + (inside ? 1 : -1) * std::sqrt(root)) / dd;
        const double cosine = std::sqrt(1 - away);
        ASSERT_NEAR(hit.value().distance, t * std::sqrt(dd), sag / cosine + 1e-5) << k;
        ASSERT_NE(hit.value().front, inside);
        for (int a = 0; a < 3; ++a) {
            const double p = o[a] + t * d[a];
            ASSERT_NEAR((&hit.value().point.x)[a], p, 2 * sag / cosine + 1e-5);
            ASSERT_NEAR((&hit.value().normal.x)[a], p, 0.12);
        }
    }
    EXPECT_GT(hits, 1000);
    EXPECT_GT(misses, 1000);
}

// --- Against other searches -------------------------------------------------------------------------------------

/// The library's own test on every triangle, in index order.
struct Exhaustive {
    std::vector<std::uint32_t> indices;
    explicit Exhaustive(const State& state) : indices(Triangles(state).indices) {}
    struct Answer {
        bool found = false;
        double distance = 0;
        std::uint32_t corners[3] = {};
        detail::TriangleHit hit;
    };
    [[nodiscard]] Answer operator()(const State& state, Vec3 origin, Vec3 direction, const PickOptions& o) const {
        const detail::Ray ray = detail::make_ray(origin, direction);
        const PointView p = state.positions();
        const detail::RayPlanes planes = detail::planes_of(ray, {p.x, p.y, p.z});
        Answer best;
        best.distance = o.max_distance;
        for (std::size_t k = 0; k < indices.size(); k += 3) {
            detail::TriangleHit hit;
            if (!detail::meets(ray, detail::shear(ray, planes, indices[k]), detail::shear(ray, planes, indices[k + 1]),
                               detail::shear(ray, planes, indices[k + 2]), hit) ||
                (!hit.front && !o.back_faces))
                continue;
            if (hit.distance > best.distance || (best.found && hit.distance == best.distance)) continue;
            best = {true, hit.distance, {indices[k], indices[k + 1], indices[k + 2]}, hit};
        }
        return best;
    }
};

/// Nearest crossing in long double by Moeller and Trumbore's rule; `margin`: how far from every edge, at the least.
struct Oracle {
    long double distance = std::numeric_limits<long double>::infinity();
    long double margin = std::numeric_limits<long double>::infinity();
    void offer(Vec3 a, Vec3 b, Vec3 c, Vec3 origin, Vec3 direction) {
        using Real = long double;
        const auto sub = [](Vec3 p, Vec3 q) {
            return std::array<Real, 3>{Real(p.x) - q.x, Real(p.y) - q.y, Real(p.z) - q.z};
        };
        const auto cross = [](const auto& p, const auto& q) {
            return std::array<Real, 3>{p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
        };
        const auto product = [](const auto& p, const auto& q) { return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]; };
        const auto e = sub(b, a), f = sub(c, a), o = sub(origin, a), d = sub(direction, {});
        const auto h = cross(d, f);
        const Real det = product(e, h);
        if (det == 0) return;
        const Real u = product(o, h) / det;
        const auto q = cross(o, e);
        const Real v = product(d, q) / det, t = product(f, q) / det * std::sqrt(product(d, d));
        const Real inside = std::min({u, v, 1 - u - v});
        if (t > -1e-6L) margin = std::min({margin, std::fabs(inside), std::fabs(t)});
        if (inside >= 0 && t >= 0) distance = std::min(distance, t);
    }
};

long rays_wanted() {
    const char* wish = std::getenv("DGM_PICK_RAYS");
    return wish == nullptr ? 20000 : std::atol(wish);
}

struct Around {
    Vec3 middle;
    float size;
    explicit Around(const State& state) {
        Vec3 low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
        for (std::uint32_t k = 0; k < state.sample_count(); ++k) {
            if (!state.on_surface(k)) continue;
            const Vec3 p = state.positions()[k];
            low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
        }
        middle = 0.5f * (low + high);
        size = static_cast<float>(length(high - low));
    }
};

/// Rays of every kind: from anywhere, from and to samples, along edges and axes, grazing.
struct Rays {
    std::mt19937 random;
    Around box;
    Rays(const State& state, unsigned seed) : random(seed), box(state) {}
    Vec3 anywhere(float size) {
        std::normal_distribution<float> n(0, size);
        const float x = n(random), y = n(random), z = n(random);
        return {x, y, z};
    }
    Vec3 sample(const State& state) {
        for (;;) {
            const auto k = static_cast<std::uint32_t>(random() % state.sample_count());
            if (state.on_surface(k)) return state.positions()[k];
        }
    }
    void next(const State& state, Vec3& origin, Vec3& direction, PickOptions& o) {
        o = {};
        o.back_faces = random() % 4 != 0;
        if (random() % 4 == 0) o.max_distance = box.size * static_cast<float>(random() % 100) / 80;
        const Vec3 p = sample(state), q = sample(state);
        origin = box.middle + anywhere(box.size);
        switch (random() % 8) {
            case 0:
                direction = anywhere(1);
                break;
            case 1:
            case 2:
                direction = box.middle + anywhere(box.size / 4) - origin;
                break;
            case 3:
                direction = p - origin;
                break;  // through a corner, but for rounding
            case 4:
                direction = 0.5f * (p + q) - origin;
                break;
            case 5:
                origin = p, direction = random() % 2 == 0 ? q - p : anywhere(1);
                break;  // starts on the surface
            case 6:     // along an axis, through a corner to the bit
                origin = p;
                (&origin.x)[random() % 3] += box.size;
                direction = p - origin;
                break;
            default: {  // nearly along an edge: from outside, past p and its neighbour in memory
                direction = sample(state) - p;
                origin = p - (2 * box.size / std::max(1e-6f, static_cast<float>(length(direction)))) * direction;
            }
        }
        if (direction == Vec3{}) direction = {1, 0, 0};
    }
};

void compare(State& state, long count, unsigned seed, int* found = nullptr) {
    const Exhaustive all(state);
    Rays rays(state, seed);
    int hits = 0;
    for (long k = 0; k < count; ++k) {
        Vec3 origin, direction;
        PickOptions o;
        rays.next(state, origin, direction, o);
        const auto got = pick_ray(state, origin, direction, o);
        const auto want = all(state, origin, direction, o);
        ASSERT_EQ(got.ok(), want.found) << k;
        if (!want.found) {
            ASSERT_EQ(got.error().code, ErrorCode::NotFound);
            continue;
        }
        ++hits;
        const RayHit& h = got.value();
        ASSERT_EQ(h.distance, static_cast<float>(want.distance)) << k;
        double sum = 0;
        int nearest = 0;
        for (int c = 0; c < 3; ++c) {
            ASSERT_EQ(h.corners[c], want.corners[c]) << k;
            ASSERT_EQ(h.barycentric[c], static_cast<float>(want.hit.weight[c])) << k;
            ASSERT_GE(h.barycentric[c], 0) << k;
            sum += double{h.barycentric[c]};
            if (want.hit.weight[c] > want.hit.weight[nearest]) nearest = c;
        }
        ASSERT_NEAR(sum, 1, 1e-6);
        ASSERT_EQ(h.front, want.hit.front);
        const std::uint32_t id = state.class_of(h.corners[nearest]);
        ASSERT_EQ(h.sample, id == kNone ? h.corners[nearest] : state.class_members(id)[0]);
        const double size = length(origin) + static_cast<double>(h.distance) + static_cast<double>(rays.box.size);
        const double step = static_cast<double>(h.distance) / length(direction);
        for (int a = 0; a < 3; ++a)
            ASSERT_NEAR((&h.point.x)[a], double{(&origin.x)[a]} + step * double{(&direction.x)[a]}, 4e-7 * size) << k;
    }
    if (found != nullptr) *found += hits;
    EXPECT_GT(hits, count / 10);
}

/// Compares with the independent oracle where no edge is near.
void compare_oracle(State& state, int count, unsigned seed) {
    const Exhaustive all(state);
    const PointView p = state.positions();
    std::mt19937 random(seed);
    Rays rays(state, seed);
    int compared = 0;
    for (int k = 0; k < count; ++k) {
        const Vec3 origin = rays.box.middle + rays.anywhere(rays.box.size);
        const Vec3 direction = rays.box.middle + rays.anywhere(rays.box.size / 4) - origin;
        Oracle oracle;
        for (std::size_t t = 0; t < all.indices.size(); t += 3)
            oracle.offer(p[all.indices[t]], p[all.indices[t + 1]], p[all.indices[t + 2]], origin, direction);
        if (oracle.margin < 1e-9L) continue;
        ++compared;
        const auto hit = pick_ray(state, origin, direction);
        ASSERT_EQ(hit.ok(), std::isfinite(oracle.distance)) << k;
        if (!hit.ok()) continue;
        const auto distance = static_cast<double>(oracle.distance);
        ASSERT_NEAR(hit.value().distance, distance, 2e-7 * distance + 1e-12) << k;
    }
    EXPECT_GT(compared, count * 9 / 10);
}

TEST(Pick, EqualsExhaustiveSearch) {
    const long count = rays_wanted();
    int hits = 0;
    const ChartSpec charts[] = {grid_chart(43, 41, folds, tube_seams(43, 41)),
                                mixed(grid_chart(43, 41, folds, tube_seams(43, 41)), 5),
                                sphere_chart(33),
                                mixed(sphere_chart(41), 6),
                                free_chart(30, 21, folds),
                                mixed(free_chart(26, 35, test::sheet), 7),
                                grid_chart(18, 10, test::sheet),
                                grid_chart(2, 9, test::sheet)};
    unsigned seed = 1;
    for (const ChartSpec& chart : charts) {
        State state = make_state(chart);
        compare(state, count / 8, seed++, &hits);
        if (HasFatalFailure()) return;
    }
    RecordProperty("hits", hits);
}

TEST(Pick, EqualsAnotherTriangleTest) {
    for (const ChartSpec& chart :
         {mixed(grid_chart(43, 41, folds, tube_seams(43, 41)), 5), free_chart(30, 21, folds)}) {
        State state = make_state(chart);
        compare_oracle(state, 400, 9);
    }
}

TEST(Pick, FollowsEveryChange) {
    const ChartSpec charts[] = {mixed(sphere_chart(33), 8), free_chart(30, 35, test::sheet),
                                grid_chart(43, 41, folds, tube_seams(43, 41))};
    for (const ChartSpec& chart : charts) {
        State state = make_state(chart);
        const DeformTable table = table_of(6);
        const Around box(state);
        std::mt19937 random(11);
        const auto sample = [&] {
            for (;;) {
                const auto k = static_cast<std::uint32_t>(random() % state.sample_count());
                if (state.on_surface(k)) return k;
            }
        };
        for (int round = 0; round < 40; ++round) {
            Touch touch;
            touch.sample = sample();
            touch.d_max = box.size / 5;
            touch.displacement = {float(random() % 9) - 4, float(random() % 9) - 4, float(random() % 9) - 4};
            touch.mode = round % 4 == 0 ? DeformMode::Plastic : DeformMode::Elastic;
            if (round % 3 == 0) {
                ASSERT_TRUE(deform(state, table, touch).ok());
            } else {
                TickOptions options;
                options.d_max = touch.d_max;
                options.relax_rate = round % 3 == 1 ? 20.0f : kInfinity;
                ToolInput in;
                in.position = state.positions()[touch.sample] - (box.size / 40) * state.normal(touch.sample);
                for (int k = 0; k < 5; ++k) ASSERT_TRUE(tick(state, table, options, {&in, 1}, {}).ok());
            }
            if (round % 7 == 0) { ASSERT_TRUE(state.relax(0.01f, 30).ok()); }
            if (round % 11 == 0) state.release();
            if (round == 30) state.reset();
            compare(state, 100, 100 + static_cast<unsigned>(round));
            if (HasFatalFailure()) return;
        }
    }
}

// --- Nothing slips through --------------------------------------------------------------------------------------

/// A ray from inside a closed surface leaves it, wherever it is aimed: at corners, seams, edges, to the bit.
void expect_closed(State& state, Vec3 inside, float shift, bool from_behind = true) {
    const PointView p = state.positions();
    const Triangles mesh(state);
    for (std::size_t k = 0; k < mesh.indices.size(); k += 3)
        for (std::size_t c = 0; c < 3; ++c) {
            const Vec3 a = p[mesh.indices[k + c]], b = p[mesh.indices[k + (c + 1) % 3]];
            for (const float w : {0.0f, 0.5f, 0.25f, shift}) {
                const Vec3 at = w == 0 ? a : (1 - w) * a + w * b;
                const auto hit = pick_ray(state, inside, at - inside);
                ASSERT_TRUE(hit.ok()) << k << " " << c << " " << double{w};
                ASSERT_TRUE(!from_behind || !hit.value().front);
            }
        }
}

TEST(Pick, NoRayLeavesAClosedSurface) {
    for (const std::uint32_t side : {9u, 17u, 33u}) {
        State state = make_state(mixed(sphere_chart(side), side));
        expect_closed(state, {0, 0, 0}, 0.3f);
        expect_closed(state, {0.31f, -0.24f, 0.17f}, 0.7f);
    }
    // Long thin triangles far from the origin, where coordinates have few digits left: rounding folds the surface.
    State far = make_state(closed_chart(17, [](std::array<double, 3> n) {
        return std::array<double, 3>{1e4 + n[0], 3e3 + 1e-3 * n[1], 50 * n[2]};
    }));
    expect_closed(far, {1e4f, 3e3f, 0}, 0.1f, false);
}

TEST(Pick, GrazingRaysAndEdgesAlongTheAxes) {
    // On a flat grid of whole numbers, rays straight down at half steps run through corners, sides and diagonals.
    State state = make_state(mixed(grid_chart(17, 17, flat), 2));
    for (int i = 0; i <= 64; ++i)
        for (int j = 0; j <= 64; ++j) {
            const Vec3 at{static_cast<float>(i) / 4, static_cast<float>(j) / 4, 0};
            for (const Vec3 d : {Vec3{0, 0, -1}, Vec3{1, 2, -4}, Vec3{-3, 1, -1}}) {
                const auto hit = pick_ray(state, at - 2 * d, d);
                ASSERT_TRUE(hit.ok()) << i << " " << j;
                ASSERT_EQ(hit.value().point, at);
                ASSERT_NEAR(hit.value().distance, 2 * length(d), 1e-6);
                ASSERT_TRUE(hit.value().front);
            }
        }
    // Almost in the plane: down by one part in ten million of the way.
    const auto grazing = pick_ray(state, {-100, 8.25f, 1e-5f}, {108.5f, 0, -1e-5f});
    ASSERT_TRUE(grazing.ok());
    EXPECT_NEAR(grazing.value().point.x, 8.5, 1e-4);
    EXPECT_NEAR(grazing.value().distance, 108.5, 1e-4);
}

TEST(Pick, SeamSampleIsTheRepresentative) {
    State state = make_state(grid_chart(43, 41, folds, tube_seams(43, 41)));
    for (std::uint32_t i = 1; i < 42; ++i) {
        const Vec3 p = state.positions()[i * 41 + 40], n = state.normal(i * 41 + 40);
        const auto hit = pick_ray(state, p + 0.05f * n, Vec3{} - n);
        ASSERT_TRUE(hit.ok());
        ASSERT_NEAR(hit.value().distance, 0.05, 1e-5);
        ASSERT_EQ(hit.value().sample, i * 41);
    }
}

TEST(Pick, BorderStrip) {
    State state = make_state(free_chart(12, 9, flat));
    // Between the outermost grid samples (row 1) and the border samples (row 0.5).
    const auto hit = pick_ray(state, {0.6f, 4.3f, 3}, {0, 0, -1}).value();
    EXPECT_EQ(hit.row, kNone);
    EXPECT_EQ(hit.column, kNone);
    EXPECT_NEAR(hit.point.x, 0.6, 1e-6);
    EXPECT_NEAR(hit.point.y, 4.3, 1e-6);
    EXPECT_EQ(hit.distance, 3);
    EXPECT_GE(hit.sample, 12u * 9);  // 0.1 from the border samples' row, 0.4 from the grid's
    std::vector<std::uint32_t> faces = Triangles(state).indices;
    const std::size_t quads = 2 * (11 - 2) * (8 - 2);
    for (int c = 0; c < 3; ++c)
        EXPECT_EQ(hit.corners[c], faces[3 * (quads + hit.triangle) + static_cast<std::size_t>(c)]);
    EXPECT_FALSE(pick_ray(state, {0.4f, 4.3f, 3}, {0, 0, -1}).ok());
    // Every place of strip and grid, to the rim.
    for (float x = 0.5f; x <= 10.5f; x += 0.125f)
        for (float y = 0.5f; y <= 7.5f; y += 0.125f) EXPECT_TRUE(pick_ray(state, {x, y, 3}, {0, 0, -1}).ok()) << x;
}

TEST(Pick, EachMovedBorderSampleTakesItsFacesAlong) {
    // Faces of the strip may have corners in several tiles: all their leaves must hear of each corner.
    State state = make_state(free_chart(28, 35, flat));
    const DeformTable table = table_of(1);  // less than a step around the contact
    const Exhaustive all(state);
    for (std::uint32_t k = 28 * 35; k < state.sample_count(); ++k) {
        Touch touch;
        touch.sample = k;
        touch.displacement = {0.125f, 0.25f, 3};
        touch.d_max = 4;
        ASSERT_TRUE(deform(state, table, touch).ok());
        const Vec3 p = state.positions()[k];
        for (std::size_t f = 2 * (27 - 2) * (34 - 2) * std::size_t{3}; f < all.indices.size(); f += 3) {
            const std::uint32_t* c = all.indices.data() + f;
            if (c[0] != k && c[1] != k && c[2] != k) continue;
            // Sideways through a place of the face near the moved corner.
            Vec3 middle = 0.9f * p;
            for (int e = 0; e < 3; ++e)
                if (c[e] != k) middle = middle + 0.05f * state.positions()[c[e]];
            for (const Vec3 d : {Vec3{1, 0.25f, 0.5f}, Vec3{-0.25f, 1, -0.125f}, Vec3{0.5f, 1, 0.25f}}) {
                const auto hit = pick_ray(state, middle - 4 * d, d);
                const auto want = all(state, middle - 4 * d, d, {});
                ASSERT_EQ(hit.ok(), want.found) << k;
                if (want.found) { ASSERT_EQ(hit.value().distance, static_cast<float>(want.distance)) << k; }
            }
        }
        state.release();
        // Boxes are up to date before the next touch, which alone must tell of itself.
        static_cast<void>(pick_ray(state, {}, {0, 0, 1}));
    }
}

// --- Hard numbers -----------------------------------------------------------------------------------------------

TEST(Pick, HugeAndTinyCoordinates) {
    for (const double size : {1e-30, 1e-12, 1e12, 1e18, 1e30, 1e37}) {
        State state = make_state(grid_chart(17, 17, [&](double i, double j) {
            return Point{static_cast<float>(size * i), static_cast<float>(size * j), 0};
        }));
        const auto f = static_cast<float>(size);
        for (const float d : {1e-38f, 1.0f, 3e38f}) {
            const auto hit = pick_ray(state, {3.5f * f, 4.25f * f, 8 * f}, {0, 0, -d});
            ASSERT_TRUE(hit.ok()) << size;
            EXPECT_NEAR(hit.value().distance / (8 * size), 1, 1e-6);
            EXPECT_EQ(hit.value().row, 3u);
            EXPECT_EQ(hit.value().column, 4u);
            EXPECT_EQ(hit.value().normal, (Vec3{0, 0, 1}));
        }
        if (size < 1e37) compare(state, 500, 3);
    }
    // A distance beyond float.
    State state = make_state(grid_chart(3, 3, [](double i, double j) {
        return Point{static_cast<float>(3e38 * (i - 1)), static_cast<float>(3e38 * (j - 1)), -3e38f};
    }));
    EXPECT_EQ(pick_ray(state, {0, 0, 3e38f}, {0, 0, -1}).value().distance, std::numeric_limits<float>::max());
}

TEST(Pick, RefusesNonsense) {
    State state = make_state(grid_chart(9, 9, flat));
    const float nan = std::nanf("");
    const auto code = [&](Vec3 o, Vec3 d, float max = 1) {
        PickOptions options;
        options.max_distance = max;
        return pick_ray(state, o, d, options).error().code;
    };
    EXPECT_EQ(code({}, {}), ErrorCode::BadArgument);
    EXPECT_EQ(code({}, {-0.0f, 0, 0}), ErrorCode::BadArgument);
    EXPECT_EQ(code({nan, 0, 0}, {0, 0, 1}), ErrorCode::BadArgument);
    EXPECT_EQ(code({0, kInfinity, 0}, {0, 0, 1}), ErrorCode::BadArgument);
    EXPECT_EQ(code({}, {0, nan, 1}), ErrorCode::BadArgument);
    EXPECT_EQ(code({}, {0, -kInfinity, 1}), ErrorCode::BadArgument);
    EXPECT_EQ(code({}, {0, 0, 1}, -1), ErrorCode::BadArgument);
    EXPECT_EQ(code({}, {0, 0, 1}, nan), ErrorCode::BadArgument);
    EXPECT_EQ(code({20, 20, 0}, {0, 0, 1}), ErrorCode::NotFound);
    // A chart all of whose triangles have no area.
    State point = make_state(grid_chart(9, 9, [](double, double) { return Point{1, 2, 3}; }));
    EXPECT_EQ(pick_ray(point, {}, {1, 2, 3}).error().code, ErrorCode::NotFound);
}

TEST(Pick, CInterface) {
    const Bytes bytes = build({free_chart(12, 9, test::sheet)}).bytes;
    dgm_asset* asset = nullptr;
    dgm_state* state = nullptr;
    ASSERT_EQ(dgm_asset_open_memory(bytes.data(), bytes.size(), nullptr, nullptr, &asset, nullptr), DGM_OK);
    ASSERT_EQ(dgm_state_create(asset, 0, nullptr, nullptr, &state, nullptr), DGM_OK);
    State same = make_state(free_chart(12, 9, test::sheet));
    dgm_error error{};
    error.struct_size = sizeof error;
    dgm_ray_hit hit{};
    hit.struct_size = sizeof hit;
    const float down[3] = {0.1f, 0, -2};
    for (const Vec3 o : {Vec3{3.3f, 4.6f, 5}, Vec3{0.6f, 4.3f, 3}}) {
        const float origin[3] = {o.x, o.y, o.z};
        ASSERT_EQ(dgm_pick_ray(state, origin, down, nullptr, &hit, &error), DGM_OK);
        const RayHit want = pick_ray(same, o, {0.1f, 0, -2}).value();
        EXPECT_EQ(hit.sample, want.sample);
        EXPECT_EQ(hit.row, want.row);
        EXPECT_EQ(hit.column, want.column);
        EXPECT_EQ(hit.triangle, want.triangle);
        EXPECT_EQ(hit.distance, want.distance);
        EXPECT_EQ(hit.front, 1u);
        for (int k = 0; k < 3; ++k) {
            EXPECT_EQ(hit.corners[k], want.corners[k]);
            EXPECT_EQ(hit.barycentric[k], want.barycentric[k]);
            EXPECT_EQ(hit.point[k], (&want.point.x)[k]);
            EXPECT_EQ(hit.normal[k], (&want.normal.x)[k]);
        }
    }
    dgm_pick_options options{};
    options.struct_size = sizeof options;
    options.max_distance = 2;
    const float origin[3] = {3.3f, 4.6f, 5}, below[3] = {3.3f, 4.6f, -5}, up[3] = {0, 0, 1}, zero[3] = {};
    EXPECT_EQ(dgm_pick_ray(state, origin, down, &options, &hit, &error), DGM_NOT_FOUND);
    EXPECT_EQ(error.code, unsigned{DGM_NOT_FOUND});
    options.max_distance = 0;
    EXPECT_EQ(dgm_pick_ray(state, below, up, &options, nullptr, nullptr), DGM_OK);
    options.skip_back_faces = 1;
    EXPECT_EQ(dgm_pick_ray(state, below, up, &options, &hit, &error), DGM_NOT_FOUND);
    EXPECT_EQ(dgm_pick_ray(state, origin, zero, nullptr, &hit, &error), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_pick_ray(nullptr, origin, down, nullptr, &hit, &error), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_pick_ray(state, nullptr, down, nullptr, &hit, &error), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_pick_ray(state, origin, nullptr, nullptr, &hit, &error), DGM_BAD_ARGUMENT);
    options.max_distance = -1;
    EXPECT_EQ(dgm_pick_ray(state, origin, down, &options, &hit, &error), DGM_BAD_ARGUMENT);
    options.struct_size = 0;
    EXPECT_EQ(dgm_pick_ray(state, origin, down, &options, &hit, &error), DGM_BAD_ARGUMENT);
    dgm_state_destroy(state);
    dgm_asset_close(asset);
}

}  // namespace
}  // namespace dgm::test
