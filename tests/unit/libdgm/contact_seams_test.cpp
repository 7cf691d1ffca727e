// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/contact_seams_test.cpp
// Copies of a weld class stay equal to the bit through thousands of random contacts of two maps, and the answer of a
// search does not depend on where the last one ended. Looks at the library's inside for the latter.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <numbers>
#include <random>

#include "contact/contact_impl.h"
#include "contact_shapes.h"

namespace dgm::test {
namespace {

using Random = std::mt19937;
using Shape3 = std::function<std::array<double, 3>(std::array<double, 3>)>;

double uniform(Random& random, double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
}
std::uint32_t below(Random& random, std::uint32_t count) {
    return std::uniform_int_distribution<std::uint32_t>(0, count - 1)(random);
}

/// Coordinates rounded to eighths now and then: points that are as near to many triangles of another such map.
Point rounded(const std::array<double, 3>& p, bool coarse) {
    const auto one = [coarse](double v) { return static_cast<float>(coarse ? std::round(8 * v) / 8 : v); };
    return {one(p[0]), one(p[1]), one(p[2])};
}

/// Closed: a torus, both pairs of sides glued; all four corners are one class.
ChartSpec torus_chart(std::uint32_t m, std::uint32_t n, const Shape3& shape, bool coarse) {
    SeamPairs seams;
    for (std::uint32_t i = 1; i + 1 < m; ++i) seams.push_back({i * n, i * n + n - 1});
    for (std::uint32_t j = 1; j + 1 < n; ++j) seams.push_back({j, (m - 1) * n + j});
    for (const std::uint32_t corner : {n - 1, (m - 1) * n, m * n - 1}) seams.push_back({0, corner});
    return grid_chart(
        m, n,
        [&](double i, double j) {
            const double a = 2 * std::numbers::pi * i / (m - 1), b = 2 * std::numbers::pi * j / (n - 1);
            const double r = 0.7 + 0.3 * std::cos(b);
            return rounded(shape({r * std::cos(a), r * std::sin(a), 0.3 * std::sin(b)}), coarse);
        },
        seams);
}

ChartSpec random_chart(Random& random) {
    const bool coarse = below(random, 2) == 0;
    const double wave = uniform(random, 0, 0.3), turn = uniform(random, 0, 6), many = 2 + below(random, 4);
    const double flat = below(random, 4) == 0 ? 0.05 : uniform(random, 0.5, 1);
    const Shape3 shape = [=](std::array<double, 3> p) {
        const double r = 1 + wave * std::sin(many * p[0] + turn) * std::cos(many * p[1]);
        return std::array<double, 3>{r * p[0], r * p[1], r * flat * p[2]};
    };
    const std::uint32_t side = 9 + 2 * below(random, 5);
    switch (below(random, 5)) {
        case 0:
            return torus_chart(side, 7 + below(random, 7), shape, coarse);
        case 1:
            return closed_free_chart(side, [&](const std::array<double, 3>& n) { return rounded(shape(n), coarse); });
        case 2: {  // open: a tube
            const std::uint32_t n = 8 + below(random, 9);
            return grid_chart(
                side, n,
                [&](double i, double j) {
                    const double a = 2 * std::numbers::pi * j / (n - 1);
                    return rounded(shape({std::cos(a), std::sin(a), 2 * i / (side - 1) - 1}), coarse);
                },
                tube_seams(side, n));
        }
        case 3: {  // open: a folded slit
            return grid_chart(
                side, side,
                [&](double i, double j) {
                    const double a = 2 * std::numbers::pi * i / (side - 1), r = 0.1 + j / (side - 1);
                    return rounded(shape({r * std::cos(a), j == 0 ? 0 : r * std::sin(a), 0.2 * r}), coarse);
                },
                fold_seams(side, side));
        }
        default:
            return grid_chart(
                side, side,
                [&](double i, double j) { return rounded(shape(octahedral(i / (side - 1), j / (side - 1))), coarse); },
                octahedral_seams(side));
    }
}

void add_mobility(Random& random, ChartSpec& chart) {
    std::vector<float> values;
    for (std::uint32_t k = 0; k < chart.rows * chart.cols; ++k)
        values.insert(values.end(), {1.0f, static_cast<float>(uniform(random, 0, 1))});
    chart.add("contact", ElementType::kF32, {chart.rows, chart.cols, 2}, values);
}

/// Plane, sphere, capsule, box or the other map, in reach of a shape about as large as 1.
Obstacle random_obstacle(Random& random, State& other, std::uint32_t kind) {
    Obstacle o{.kind = static_cast<ObstacleKind>(kind)};
    const auto vec = [&](double size) {
        const auto one = [&] { return static_cast<float>(uniform(random, -size, size)); };
        const float x = one(), y = one();
        return Vec3{x, y, one()};
    };
    o.point = vec(1.2);
    o.end = vec(1.2);
    o.normal = vec(1);
    if (dot(o.normal, o.normal) < 0.01f) o.normal = {0, 0, 1};
    o.radius = static_cast<float>(uniform(random, 0.1, 0.8));
    o.half = {0.4f, static_cast<float>(uniform(random, 0.1, 0.9)), 0.3f};
    if (below(random, 2) == 0) {
        const double a = uniform(random, 0, 6);
        const auto c = static_cast<float>(std::cos(a)), s = static_cast<float>(std::sin(a));
        const float turned[9] = {c, -s, 0, s, c, 0, 0, 0, 1};
        std::copy_n(turned, 9, o.rotation);
    } else if (below(random, 2) == 0) {
        o.point = {std::round(8 * o.point.x) / 8, std::round(8 * o.point.y) / 8, std::round(8 * o.point.z) / 8};
    }
    o.surface = &other;
    if (below(random, 4) == 0) o.reach = static_cast<float>(uniform(random, 0.01, 0.6));
    return o;
}

ContactOptions random_options(Random& random, std::span<const RingSize> rings) {
    ContactOptions options;
    options.bulge = static_cast<Bulge>(below(random, 6) < 4 ? 0 : below(random, 3));
    options.mode = below(random, 3) == 0 ? DeformMode::Plastic : DeformMode::Elastic;
    options.smoothing = below(random, 10);
    if (below(random, 3) == 0) options.rings = rings;
    return options;
}

/// The shapes themselves are pressed flat, torn at creases and turned inside out by this: seams must hold all the same.
class RandomContacts : public testing::TestWithParam<std::uint32_t> {};

TEST_P(RandomContacts, LeaveSeamsClosed) {
    Random random(GetParam());
    std::uint32_t contacts = 0, surfaces = 0;
    const RingSize rings[] = {{0.5f, 0.5f, 0.06f}, {1e9f, 1.5f, 0.3f}};
    for (int pair = 0; pair < 60; ++pair) {
        ChartSpec chart = random_chart(random);
        if (below(random, 3) == 0) add_mobility(random, chart);
        StateOptions state_options;
        state_options.plain_loops = below(random, 2) == 0;
        State state = State::create(Opened(build({chart})).chart(), state_options).value();
        State other = State::create(Opened(build({random_chart(random)})).chart(), state_options).value();
        const ContactSolver solver = ContactSolver::create(state).value();
        for (int call = 0; call < 40; ++call) {
            const std::uint32_t kind = below(random, 2) == 0 ? 4 : below(random, 4);
            const Obstacle o = random_obstacle(random, other, kind);
            const auto done = resolve_contact(state, solver, o, random_options(random, rings));
            ASSERT_TRUE(done.ok()) << done.error().message;
            contacts += done.value().status == ContactStatus::Clear ? 0 : 1;
            surfaces += done.value().status != ContactStatus::Clear && kind == 4 ? 1 : 0;
            expect_closed_seams(state);
            if (testing::Test::HasFatalFailure()) FAIL() << "pair " << pair << " call " << call << " kind " << kind;
            if (below(random, 3) == 0) state.release();
        }
    }
    EXPECT_GT(contacts, 1000u);
    EXPECT_GT(surfaces, 400u);
}
INSTANTIATE_TEST_SUITE_P(Seeds, RandomContacts, testing::Range(1u, 9u));

bool same(const detail::Probe& a, const detail::Probe& b) {
    return std::memcmp(&a.distance, &b.distance, 8) == 0 && std::memcmp(&a.nearest, &b.nearest, 24) == 0 &&
           a.facet == b.facet;
}

/// Points on and off the surface, above corners and edges, each searched from every kind of start.
TEST(Contact, SearchesDoNotDependOnTheirHints) {
    Random random(11);
    std::uint32_t inside = 0;
    for (int map = 0; map < 40; ++map) {
        State body = make_state(random_chart(random));
        const Obstacle o = random_obstacle(random, body, 4);
        detail::Shape shape = detail::make_shape(o).value();
        const auto near = std::make_unique<detail::NearTiles>();
        std::vector<std::uint64_t> names;
        for (std::uint32_t k = 0; k < body.sample_count(); ++k) {
            const std::uint32_t cols = body.cols();
            if (k / cols + 1 < body.rows() && k % cols + 1 < cols && k < cols * body.rows() &&
                shape.surface->tables.has_quad(k / cols, k % cols))
                names.insert(names.end(), {2 * std::uint64_t{k}, 2 * std::uint64_t{k} + 1});
        }
        for (std::size_t f = 0; f < shape.surface->faces.size() / 3; ++f)
            names.push_back(2 * std::uint64_t{shape.surface->tables.total} + f);
        for (int q = 0; q < 150; ++q) {
            // At a sample, along an edge's middle, or anywhere; off the surface by nothing, a little, or much.
            const std::uint32_t a = below(random, body.sample_count());
            if (!body.on_surface(a)) continue;
            detail::Double3 at = detail::widen(body.positions()[a]);
            if (q % 3 == 1) at = {std::round(8 * at.x) / 8, std::round(8 * at.y) / 8, std::round(4 * at.z) / 8};
            if (q % 3 == 2) at = {uniform(random, -1.5, 1.5), uniform(random, -1.5, 1.5), uniform(random, -1, 1)};
            if (q % 2 == 0) at.z = at.z + uniform(random, -0.1, 0.1);
            shape.hint = detail::kNoTriangle;
            shape.near = nullptr;
            const detail::Probe first = detail::probe(shape, at);
            inside += first.distance < 0 ? 1 : 0;
            for (int start = 0; start < 12; ++start) {
                shape.hint = names[below(random, static_cast<std::uint32_t>(names.size()))];
                shape.near = start % 2 == 0 ? nullptr : near.get();
                if (start % 4 == 1) *near = {};
                const detail::Probe again = detail::probe(shape, at);
                ASSERT_TRUE(same(first, again)) << "map " << map << " point " << q << ": " << first.distance << " and "
                                                << again.distance << " from " << shape.hint;
            }
        }
    }
    EXPECT_GT(inside, 500u);
}

}  // namespace
}  // namespace dgm::test
