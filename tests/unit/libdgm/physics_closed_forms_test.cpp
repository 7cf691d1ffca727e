// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/physics_closed_forms_test.cpp
// Bodies at rest against solutions that are worked out here without the model: by formula, quadrature or shooting.
#include <gtest/gtest.h>

#include <complex>
#include <numbers>

#include "physics/physics_impl.h"
#include "physics_shapes.h"

namespace dgm::test {
namespace {

constexpr double kPi = std::numbers::pi;

/// The unit sphere cut open along an arc, as `stretch` does: the border of the square folds at two opposite corners.
/// Square to disk [Shirley, Chiu 1997], disk to the plane outside a segment [Joukowski], that to the sphere.
ChartSpec slit_sphere_chart(std::uint32_t side) {
    const std::uint32_t e = side - 1;
    SeamPairs seams;
    for (std::uint32_t k = 1; k < e; ++k) {
        seams.push_back({k, k * side});                 // side i = 0 onto side j = 0
        seams.push_back({k * side + e, e * side + k});  // side j = e onto side i = e
    }
    seams.push_back({e, e * side});
    return grid_chart(
        side, side,
        [=](double i, double j) {
            const double x = 2 * i / e - 1, y = 2 * j / e - 1, r = std::max(std::fabs(x), std::fabs(y));
            double turn = 0;  // from the corner (0, 0), in quarter turns; mates at opposite angles
            if (r > 0) {
                const double eighths = -x == r ? 1 + y / r : y == r ? 3 + x / r : x == r ? 5 - y / r : 7 - x / r;
                turn = r == 1 ? std::min(eighths, 8 - eighths) / 2 : eighths / 2;
            }
            const std::complex<double> z = std::polar(r, turn * kPi / 2);
            if (r == 0) return Point{0, 0, 1};
            const std::complex<double> w = 0.5 * (z + 1.0 / z);
            const double n = std::norm(w);
            return Point{float(2 * w.real() / (1 + n)), float(2 * w.imag() / (1 + n)), float((n - 1) / (1 + n))};
        },
        seams);
}

class Pressurised : public testing::TestWithParam<const char*> {};
TEST_P(Pressurised, SphereHasLaplacesPressure) {
    // Stretched by s, energy 4 pi R^2 2 (mu + lambda) (s - 1)^2, mu + lambda = E t / (2 (1 - nu)); p = dE / dV.
    const double radius = 0.1, modulus = 200, nu = 0.3;
    for (const double swollen : {1.02, 1.2}) {
        PhysicsOptions options{.material = Material{float(modulus), float(nu), 0, 0, 5, 0}};
        options.metres_per_unit = radius;
        options.dt = 1;
        Body body(GetParam()[0] == 'o' ? sphere_chart(65) : slit_sphere_chart(65), options);
        body.physics.impl()->rest_volume *= swollen;
        StepOptions o;
        o.cycles = 10;
        StepReport r;
        for (int k = 0; k < 30; ++k) r = step(body.state, body.physics, o).value();
        const double s = std::cbrt(swollen), exact = 2 * modulus * (s - 1) / ((1 - nu) * radius * s * s);
        EXPECT_NEAR(r.pressure, exact, 0.01 * exact) << swollen;
        EXPECT_NEAR(r.elastic, 4 * kPi * radius * radius * modulus / (1 - nu) * (s - 1) * (s - 1), 0.01 * r.elastic);
        EXPECT_LT(std::fabs(r.volume_error), 1e-8);
        const PointView now = body.state.positions();
        const detail::PhysicsImpl& p = *body.physics.impl();
        Vec3 middle;  // of the mass, since samples are not spread evenly
        float mass = 0;
        for (std::uint32_t k = 0; k < now.count; ++k) {
            const float share = p.fine().own[k] * p.mass[k];
            middle = middle + share * now[k];
            mass += share;
        }
        middle = (1 / mass) * middle;
        double low = 1e9, high = 0;
        for (std::uint32_t k = 0; k < now.count; ++k) {
            const Vec3 v = now[k] - middle;
            low = std::min(low, std::sqrt(double{dot(v, v)}));
            high = std::max(high, std::sqrt(double{dot(v, v)}));
        }
        EXPECT_LT(high / low, 1.01) << "it stays a sphere";
    }
}
INSTANTIATE_TEST_SUITE_P(Maps, Pressurised, testing::Values("octahedral", "slit"));

/// Deflection in the middle of a clamped round membrane under a uniform load, in a (q a / (E t))^(1/3): Foeppl's
/// equations for N_r = (E t q^2 a^2)^(1/3) n(x), 3 n' + x n'' = -x / (8 n^2), n'(0) = 0,
/// n'(1) + (1 - nu) n(1) = 0, by shooting.
/// [Hencky 1915] has 0.653 by a series for nu = 0.3.
double membrane_deflection(double nu) {
    constexpr int kSteps = 4000;
    double deflection = 0;
    const auto edge = [&](double start) {  // n'(1) + (1 - nu) n(1)
        double n = start, slope = 0;
        const double h = 1.0 / kSteps;
        deflection = 0;
        const auto bend = [](double x, double value, double first) {
            return x > 0 ? -1 / (8 * value * value) - 3 * first / x : -1 / (32 * value * value);
        };
        for (int k = 0; k < kSteps; ++k) {  // the midpoint rule
            const double x = k * h;
            const double half = n + 0.5 * h * slope, half_slope = slope + 0.5 * h * bend(x, n, slope);
            slope += h * bend(x + 0.5 * h, half, half_slope);
            n += h * half_slope;
            deflection += h * (x + 0.5 * h) / (2 * half);
            if (!(n > 0)) return -1.0;
        }
        return slope + (1 - nu) * n;
    };
    double low = 0.1, high = 2;
    for (int k = 0; k < 60; ++k) (edge((low + high) / 2) < 0 ? low : high) = (low + high) / 2;
    return deflection;
}

/// A disk of radius 1: squares of samples become circles. `ring` moves those, 0 .. 1.
template <class F>
ChartSpec disk_chart(std::uint32_t side, F ring) {
    const std::uint32_t e = side - 1;
    return grid_chart(side, side, [=](double i, double j) {
        const double x = 2 * i / e - 1, y = 2 * j / e - 1, r = std::max(std::fabs(x), std::fabs(y));
        const bool across = std::fabs(x) > std::fabs(y);
        const double q = across ? y / x : r == 0 ? 0 : x / y, at = ring(r);
        const double c = at * std::cos(q * kPi / 4), s = at * std::sin(q * kPi / 4);
        return across ? Point{float(x > 0 ? c : -c), float(x > 0 ? s : -s), 0}
                      : Point{float(y > 0 ? s : -s), float(y > 0 ? c : -c), 0};
    });
}
/// The outer rows and columns, so many, where they are at rest.
std::vector<Pin> pinned_border(const State& state, std::uint32_t side, std::uint32_t deep) {
    std::vector<Pin> pins;
    const PointView rest = state.rest_positions();
    for (std::uint32_t k = 0; k < rest.count; ++k) {
        const std::uint32_t i = k / side, j = k % side;
        if (std::min(i, j) < deep || std::max(i, j) >= side - deep) pins.push_back({k, rest[k]});
    }
    return pins;
}

TEST(ClosedForms, DiskUnderPressure) {
    // The load is the weight, so it does not turn with the surface. Slopes stay below 0.06.
    const double modulus = 100, density = 1e-2, nu = 0.3, wanted = 0.03, unit = membrane_deflection(nu);
    ASSERT_NEAR(unit, 0.6535, 1e-3);
    const double load = modulus * std::pow(wanted / unit, 3);
    PhysicsOptions options{.material = Material{float(modulus), float(nu), 0, 0, float(density), 0}};
    options.metres_per_unit = 1;
    options.dt = 0.1f;
    const std::uint32_t side = 65;
    Body body(disk_chart(side, [](double r) { return r; }), options);
    const std::vector<Pin> pins = pinned_border(body.state, side, 1);
    StepOptions o;
    o.cycles = 10;
    o.gravity = {0, 0, float(-load / density)};
    o.pins = pins;
    for (int k = 0; k < 150; ++k) ASSERT_TRUE(step(body.state, body.physics, o).ok());
    EXPECT_NEAR(-double(body.state.positions()[side / 2 * side + side / 2].z), wanted, 0.01 * wanted);
}

TEST(ClosedForms, ClampedPlateUnderItsWeight) {
    // w = q a^4 / (64 B) in the middle [Timoshenko, Woinowsky-Krieger 1959, section 16]; clamped, it has no part of
    // Poisson's ratio. The outer two rings are held: the clamp is between them, so they are close together.
    const double radius = 0.1, bending = 1e-3, density = 5, wanted = 1e-5;
    const double load = 64 * bending * wanted / std::pow(radius, 4);
    PhysicsOptions options{.material = Material{200, 0.3f, float(bending), 0, float(density), 0}};
    options.metres_per_unit = radius;
    options.dt = 1;
    const std::uint32_t side = 65;
    Body body(disk_chart(side, [](double r) { return r > 0.98 ? 1 : r / 0.97 * 0.995; }), options);
    const std::vector<Pin> pins = pinned_border(body.state, side, 2);
    StepOptions o;
    o.cycles = 30;
    o.gravity = {0, 0, float(-load / density)};
    o.pins = pins;
    for (int k = 0; k < 40; ++k) ASSERT_TRUE(step(body.state, body.physics, o).ok());
    const double is = -double(body.state.positions()[side / 2 * side + side / 2].z) * radius;
    EXPECT_NEAR(is, wanted, 0.02 * wanted);
}

TEST(ClosedForms, SheetOnItsFoundationSwingsAsImplicitEulerSays) {
    // Moved as a whole, only the foundation pulls: v' = (v - h w^2 x) / (1 + h^2 w^2), x' = x + h v', w^2 = kappa/rho.
    const double kappa = 2e4, density = 5, h = 2e-3, square = kappa / density, start = 2e-3;
    PhysicsOptions options{.material = Material{200, 0.3f, 1e-3f, float(kappa), float(density), 0}};
    options.metres_per_unit = 1e-3;
    options.dt = float(h);
    Body body(grid_chart(17, 23,
                         [](double i, double j) {
                             return Point{float(5 * i), float(4 * j), float(j)};
                         }),
              options);
    std::vector<Pin> pins;
    const PointView rest = body.state.rest_positions();
    for (std::uint32_t k = 0; k < rest.count; ++k) pins.push_back({k, rest[k] + Vec3{0, 0, float(1e3 * start)}});
    StepOptions o;
    o.cycles = 20;
    o.pins = pins;
    for (int k = 0; k < 2; ++k) ASSERT_TRUE(step(body.state, body.physics, o).ok());  // the second one: at rest there
    o.pins = {};
    double x = start, v = 0, area = 0;
    const detail::PhysicsImpl& p = *body.physics.impl();
    for (std::uint32_t k = 0; k < p.total; ++k) area += double{p.mass[k]} / density;
    EXPECT_NEAR(area, 16 * 22 * 5 * std::sqrt(17.0) * 1e-6, 1e-4 * area);
    for (int k = 0; k < 100; ++k) {
        const StepReport r = step(body.state, body.physics, o).value();
        v = (v - h * square * x) / (1 + h * h * square);
        x += h * v;
        for (const std::uint32_t s : {0u, 200u, p.total - 1})
            ASSERT_NEAR(1e-3 * double(body.state.positions()[s].z - rest[s].z), x, 1e-3 * start) << k;
        ASSERT_NEAR(r.kinetic + r.elastic, area / 2 * (density * v * v + kappa * x * x),
                    1e-3 * area / 2 * kappa * start * start)
            << k;
    }
}

/// K0(x e^(i pi / 4)), ker x + i kei x, and its first derivative by x, by quadrature.
std::array<std::complex<double>, 2> kelvin(double x) {
    const std::complex<double> turn = std::polar(1.0, kPi / 4), z = x * turn;
    std::complex<double> value = 0, slope = 0;
    const double h = 1e-3;
    for (int k = 0; k < 12000; ++k) {
        const double c = std::cosh((k + 0.5) * h);
        const std::complex<double> term = h * std::exp(-z * c);
        value += term;
        slope -= c * turn * term;
        if (x * c > 60) break;
    }
    return {value, slope};
}

TEST(ClosedForms, RoundFlatPunchOnAPlateAndItsFoundation) {
    // A plate B on a foundation kappa, pressed by d under a punch of radius c: beside it w is a combination of ker and
    // kei with w = d and w' = 0 at c. Its energy is half the force of that ring times d.
    const double bending = 1e-3, kappa = 2e4, c = 20e-3, d = 0.2e-3, unit = std::pow(bending / kappa, 0.25);
    const auto [k0, k1] = kelvin(c / unit);
    // w = Re(f K0): Re(f k0) = d, Re(f k1) = 0.
    const double det = -k0.real() * k1.imag() + k0.imag() * k1.real();
    const std::complex<double> f{-d * k1.imag() / det, -d * k1.real() / det};
    double exact = 0;
    const double dr = 0.1e-3;
    for (double r = c + dr / 2; r < c + 12 * unit; r += dr) {
        const std::complex<double> at = f * kelvin(r / unit)[0];
        const double w = at.real(), bent = -at.imag() / (unit * unit);  // the Laplacian of K0 is i K0
        exact += 0.5 * (bending * bent * bent + kappa * w * w) * 2 * kPi * r * dr;
    }
    // Rings whose distance grows: the clamp's place is known to a part of the first distance.
    const std::uint32_t rows = 97, cols = 65;
    SeamPairs seams;
    for (std::uint32_t i = 0; i < rows; ++i) seams.push_back({i * cols, i * cols + cols - 1});
    const auto ring = [=](double i) { return i == 0 ? c - 1e-4 : c + 1e-4 * (std::pow(1.045, i - 1) - 1) / 0.045; };
    PhysicsOptions options{.material = Material{200, 0.3f, float(bending), float(kappa), 5, 0}};
    options.metres_per_unit = 1;
    options.dt = 1;
    Body body(grid_chart(
                  rows, cols,
                  [=](double i, double j) {
                      const double angle = 2 * kPi * j / (cols - 1);
                      return Point{float(ring(i) * std::cos(angle)), float(ring(i) * std::sin(angle)), 0};
                  },
                  seams),
              options);
    std::vector<Pin> pins;
    const PointView rest = body.state.rest_positions();
    for (std::uint32_t k = 0; k < 2 * cols; ++k)
        if (k % cols != cols - 1) pins.push_back({k, rest[k] - Vec3{0, 0, float(d)}});
    StepOptions o;
    o.cycles = 30;
    o.pins = pins;
    StepReport r;
    for (int k = 0; k < 20; ++k) r = step(body.state, body.physics, o).value();
    EXPECT_NEAR(r.elastic, exact, 0.01 * exact);
}

}  // namespace
}  // namespace dgm::test
