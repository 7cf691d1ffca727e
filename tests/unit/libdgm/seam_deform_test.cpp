// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/seam_deform_test.cpp
// Footprints across seams, against unfoldings written out here: a rigid motion of the index plane per seam.
#include <gtest/gtest.h>

#include <dgm/deform.h>

#include <cmath>
#include <map>
#include <vector>

#include "opened.h"

namespace dgm::test {
namespace {

using Images = std::function<std::vector<std::array<double, 2>>(double i, double j)>;

struct Case {
    const char* name;
    std::uint32_t m, n;
    SeamPairs seams;
    Images images;  ///< every place of (i, j) in the plane in which the window lies
};

/// Expected weight of a sample: eq. 7 at its nearest image inside the window, else 0.
double expected(const Images& images, std::uint32_t i, std::uint32_t j, double ic, double jc, double b, double sigma) {
    double nearest = 1e300;
    for (const auto& [x, y] : images(i, j))
        if (std::fabs(x - ic) < b && std::fabs(y - jc) < b)
            nearest = std::min(nearest, (x - ic) * (x - ic) + (y - jc) * (y - jc));
    return nearest < 1e300 ? std::exp(-nearest / sigma) : 0;
}

/// Presses at every contact given and compares all samples. Displacement 1 along z on a surface with z = 0, so that the
/// z coordinate is the weight.
void check(const Case& c, const std::vector<std::array<std::uint32_t, 2>>& contacts, std::uint32_t b, float sigma) {
    SCOPED_TRACE(c.name);
    const auto flat = [](double i, double j) { return Point{static_cast<float>(i), static_cast<float>(j), 0}; };
    State state = make_state(grid_chart(c.m, c.n, flat, c.seams));
    std::map<std::uint32_t, std::vector<std::uint32_t>> classes;
    for (const auto& [representative, copy] : c.seams) classes[representative].push_back(copy);
    KernelOptions kernel;
    kernel.sigma = sigma;
    kernel.reach = b;
    const DeformTable table = DeformTable::create(kernel).value();
    for (const auto& [ic, jc] : contacts) {
        SCOPED_TRACE("contact " + std::to_string(ic) + " " + std::to_string(jc));
        state.release();
        Touch touch;
        touch.sample = ic * c.n + jc;
        touch.displacement = {0, 0, 1};
        touch.d_max = 1;
        touch.footprint = Footprint::Grid;
        const auto done = deform(state, table, touch);
        ASSERT_TRUE(done.ok()) << done.error().message;
        EXPECT_TRUE(done.value().crossed_seam);
        const PointView p = state.positions();
        // A class may have copies that the window reaches only as another copy: the class has the largest weight.
        std::map<std::uint32_t, double> of_class;
        const auto weight = [&, i0 = ic, j0 = jc](std::uint32_t s) {
            return expected(c.images, s / c.n, s % c.n, i0, j0, b, sigma);
        };
        for (std::uint32_t s = 0; s < c.m * c.n; ++s) of_class[s] = weight(s);
        for (const auto& [representative, copies] : classes) {
            double best = of_class[representative];
            for (const std::uint32_t copy : copies) best = std::max(best, of_class[copy]);
            of_class[representative] = best;
            for (const std::uint32_t copy : copies) of_class[copy] = best;
        }
        for (std::uint32_t s = 0; s < c.m * c.n; ++s)
            ASSERT_NEAR(p.z[s], of_class[s], table.error_bound()) << "sample " << s / c.n << " " << s % c.n;
        for (const auto& [representative, copies] : classes)
            for (const std::uint32_t copy : copies) ASSERT_TRUE(same_bits(p[representative], p[copy])) << copy;
    }
}

TEST(SeamDeform, TubeContinuesOnTheOtherSide) {
    const std::uint32_t m = 33, n = 41;
    check({"tube", m, n, tube_seams(m, n),
           [](double i, double j) {
               return std::vector<std::array<double, 2>>{{i, j}, {i, j - 40}, {i, j + 40}};
           }},
          {{16, 3}, {16, 0}, {16, 40}, {2, 38}, {31, 39}, {0, 0}}, 11, 30);
}

TEST(SeamDeform, FoldTurnsByHalf) {
    const std::uint32_t m = 33, n = 21;
    check({"fold", m, n, fold_seams(m, n),
           [](double i, double j) {
               return std::vector<std::array<double, 2>>{{i, j}, {32 - i, -j}};
           }},
          {{16, 1}, {16, 0}, {14, 2}, {13, 1}, {10, 3}, {25, 0}, {3, 2}}, 8, 20);
}

TEST(SeamDeform, CornerTurnsByAQuarter) {
    const std::uint32_t side = 25;
    check({"corner", side, side, corner_seams(side),
           [](double i, double j) {
               return std::vector<std::array<double, 2>>{{i, j}, {-j, i}, {j, -i}, {-i, -j}};
           }},
          {{3, 10}, {10, 3}, {0, 12}, {12, 0}, {2, 2}, {1, 0}, {4, 6}}, 7, 15);
}

TEST(SeamDeform, OctahedronSides) {
    // Each side is a fold; far from the corners only one of them is in reach.
    const std::uint32_t side = 33;
    const double e = 32;
    check({"octahedron", side, side, octahedral_seams(side),
           [e](double i, double j) {
               return std::vector<std::array<double, 2>>{
                   {i, j}, {-i, e - j}, {2 * e - i, e - j}, {e - i, -j}, {e - i, 2 * e - j}};
           }},
          {{2, 16}, {30, 15}, {16, 1}, {15, 31}, {0, 16}, {1, 12}}, 6, 9);
}

TEST(SeamDeform, CornersOfTheOctahedronAreOnePoint) {
    const std::uint32_t side = 17;
    State state = make_state(grid_chart(side, side, sheet, octahedral_seams(side)));
    KernelOptions kernel;
    kernel.sigma = 4;
    kernel.reach = 5;
    const DeformTable table = DeformTable::create(kernel).value();
    for (std::uint32_t sample = 0; sample < side * side; ++sample) {
        Touch touch;
        touch.sample = sample;
        touch.displacement = {0.25f, -0.5f, 0.75f};
        touch.d_max = 2;
        touch.footprint = Footprint::Grid;
        touch.mode = sample % 3 == 0 ? DeformMode::Plastic : DeformMode::Elastic;
        ASSERT_TRUE(deform(state, table, touch).ok());
        const PointView p = state.positions();
        for (std::uint32_t id = 0; id < state.class_count(); ++id)
            for (const std::uint32_t copy : state.class_members(id))
                ASSERT_TRUE(same_bits(p[copy], p[state.class_members(id)[0]])) << "after contact " << sample;
        if (sample % 5 == 0) state.release();
    }
    // Pressing any corner moves the four quarter disks around it alike: by symmetry the 90-degree corners make a whole
    // turn, so the sample at (1, 1) from each corner has the same weight.
    state.reset();
    Touch touch;
    touch.sample = 0;
    touch.displacement = {0, 0, 1};
    touch.d_max = 1;
    touch.footprint = Footprint::Grid;
    ASSERT_TRUE(deform(state, table, touch).ok());
    const PointView p = state.positions(), rest = state.rest_positions();
    for (const std::uint32_t s : {side + 1, side + 15, 15 * side + 1, 15 * side + 15})
        EXPECT_NEAR(p.z[s] - rest.z[s], std::exp(-2.0 / 4), 1e-6) << s;
}

TEST(SeamDeform, FreeBorderStripMovesWithEq7) {
    const std::uint32_t m = 12, n = 10;
    const auto flat = [](double i, double j) { return Point{static_cast<float>(i), static_cast<float>(j), 0}; };
    const ChartSpec chart = free_chart(m, n, flat);
    State state = make_state(chart);
    KernelOptions kernel;
    kernel.sigma = 5;
    kernel.reach = 4;
    const DeformTable table = DeformTable::create(kernel).value();
    Touch touch;
    touch.sample = 2 * n + 2;
    touch.displacement = {0, 0, 1};
    touch.d_max = 1;
    touch.footprint = Footprint::Grid;
    ASSERT_TRUE(deform(state, table, touch).ok());
    const PointView p = state.positions();
    for (std::uint32_t s = 0; s < state.sample_count(); ++s) {
        const double di = p.x[s] - 2.0, dj = p.y[s] - 2.0;  // the sheet's coordinates are its grid steps
        const bool on = s >= m * n || state.on_surface(s);
        const double want = on && std::fabs(di) < 4 && std::fabs(dj) < 4 ? std::exp(-(di * di + dj * dj) / 5) : 0;
        EXPECT_NEAR(p.z[s], want, 1e-6) << s;
    }
}

TEST(SeamDeform, FreeBorderContinuesAcrossItsSeam) {
    // The side j = 0.5 (border samples 0 .. m-1) glued to j = n - 1.5 (from m + n - 2 on, run the other way): a tube.
    const std::uint32_t m = 14, n = 12, grid = m * n;
    SeamPairs seams;
    for (std::uint32_t k = 0; k < m; ++k) seams.push_back({grid + k, grid + (m - 1) + (n - 1) + (m - 1 - k)});
    const auto flat = [](double i, double j) { return Point{static_cast<float>(i), static_cast<float>(j), 0}; };
    State state = make_state(free_chart(m, n, flat, seams));
    ASSERT_EQ(state.class_count(), m);
    KernelOptions kernel;
    kernel.sigma = 6;
    kernel.reach = 5;
    const DeformTable table = DeformTable::create(kernel).value();
    Touch touch;
    touch.sample = 6 * n + 2;
    touch.displacement = {0, 0, 1};
    touch.d_max = 1;
    touch.footprint = Footprint::Grid;
    const auto done = deform(state, table, touch);
    ASSERT_TRUE(done.ok());
    EXPECT_TRUE(done.value().crossed_seam);
    const PointView p = state.positions();
    const double period = n - 2;  // from j = 0.5 to j = n - 1.5
    for (std::uint32_t i = 1; i + 1 < m; ++i)
        for (std::uint32_t j = 1; j + 1 < n; ++j) {
            const double di = double(i) - 6;
            double nearest = 1e300;
            for (const double dj : {double(j) - 2, double(j) - 2 - period})
                if (std::fabs(di) < 5 && std::fabs(dj) < 5) nearest = std::min(nearest, di * di + dj * dj);
            EXPECT_NEAR(p.z[i * n + j], nearest < 1e300 ? std::exp(-nearest / 6) : 0, 1e-5) << i << " " << j;
        }
    for (const auto& [representative, copy] : seams) EXPECT_TRUE(same_bits(p[representative], p[copy]));
}

/// A soft sample far from every contact makes weights be gathered sample by sample. Elsewhere rows of the table move,
/// which has to give the same bits.
TEST(SeamDeform, RowsAreTheSamplesOneByOne) {
    const std::uint32_t n = 33;
    KernelOptions circle;
    circle.sigma = 14;
    circle.reach = 6;
    KernelOptions ellipse = circle;
    ellipse.shape = KernelShape::Elliptic;
    ellipse.radius_a = 4;
    ellipse.radius_b = 2;
    ellipse.angle = 0.4f;
    for (const SeamPairs& seams : {tube_seams(n, n), fold_seams(n, n), corner_seams(n), octahedral_seams(n)})
        for (const KernelOptions& kernel : {circle, ellipse}) {
            const ChartSpec plain = grid_chart(n, n, sheet, seams);
            ChartSpec soft = plain;
            std::vector<float> layer;
            for (std::uint32_t k = 0; k < n * n; ++k)
                layer.insert(layer.end(), {1, 0, 1, k == n * n / 2 ? 0.5f : 1.0f});
            soft.add("deformation", ElementType::kF32, {n, n, 4}, layer);
            State rows = make_state(plain), samples = make_state(soft);
            const DeformTable table = DeformTable::create(kernel).value();
            int crossed = 0;
            for (std::uint32_t k = 0; k < n; ++k)
                for (const std::uint32_t contact : {k, k * n, k * n + 2, (n - 4) * n + k, k * n + n - 1, 3 * n + k}) {
                    Touch touch;
                    touch.sample = contact;
                    touch.displacement = {0.25f, -0.5f, 0.75f};
                    touch.d_max = 2;
                    touch.footprint = Footprint::Grid;
                    touch.mode = contact % 3 == 0 ? DeformMode::Plastic : DeformMode::Elastic;
                    const DeformReport one = deform(rows, table, touch).value();
                    const DeformReport other = deform(samples, table, touch).value();
                    ASSERT_EQ(one.samples, other.samples) << contact;
                    ASSERT_EQ(one.crossed_seam, other.crossed_seam) << contact;
                    crossed += one.crossed_seam ? 1 : 0;
                    for (std::uint32_t s = 0; s < n * n; ++s)
                        ASSERT_TRUE(same_bits(rows.positions()[s], samples.positions()[s])) << contact << " " << s;
                }
            EXPECT_GT(crossed, 50);
            rows.release();
            samples.release();
            for (std::uint32_t s = 0; s < n * n; ++s)
                ASSERT_TRUE(same_bits(rows.positions()[s], samples.positions()[s])) << s;
        }
}

}  // namespace
}  // namespace dgm::test
