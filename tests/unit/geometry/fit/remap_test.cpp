// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/fit/remap_test.cpp
// Error that a fit has left, and maps that give its places more room.
#include "geometry/fit/remap.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <vector>

#include "geometry/fit/fit.h"
#include "geometry/mesh/triangle.h"
#include "support/chart_checks.h"
#include "support/sheet_chart.h"

namespace dgm::bake {
namespace {

constexpr double kLift = 0.01;

bool lies_within(const TriMesh& mesh, std::size_t f, double most) {
    const auto [a, b, c] = mesh.corners(f);
    const Vec3d middle = (a + b + c) / 3;
    return middle.x < most && middle.y < most;
}

/// Error where x and y are below a quarter, and none elsewhere.
ErrorField error_in_a_corner(const SampledChart& chart) {
    const TriMesh& mesh = chart.disk->mesh;
    ErrorField out;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) out.of_faces.push_back(lies_within(mesh, f, 0.25) ? 16.0 : 0.0);
    return out;
}

std::size_t samples_in_the_corner(const SampledChart& chart) {
    std::size_t out = 0;
    for (const Vec3d& p : chart.positions) out += p.x < 0.25 && p.y < 0.25;
    return out;
}

TEST(ErrorField, OfALiftedSheetIsTheSameEverywhere) {
    SampledChart chart = fit_test::flat_chart(9, 8);
    for (Vec3d& p : chart.positions) p.z += kLift;
    const ErrorField field = error_field(chart);
    ASSERT_EQ(field.of_faces.size(), 128U);
    for (const double e : field.of_faces) EXPECT_NEAR(e, 1, 1e-9);
    EXPECT_NEAR(field.worst_share, 4.0 / 64, 0.01) << "a twentieth of 64 cells is four";
}

TEST(ErrorField, OfOneLiftedSampleLiesAroundIt) {
    SampledChart chart = fit_test::flat_chart(9, 8);
    chart.positions[4 * 9 + 4].z += kLift;
    const ErrorField field = error_field(chart);
    const TriMesh& mesh = chart.disk->mesh;
    double sum = 0;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        sum += face_area(mesh.corners(f)) * field.of_faces[f];
        const auto [a, b, c] = mesh.corners(f);
        const Vec3d middle = (a + b + c) / 3;
        const double off = std::max(std::abs(middle.x - 0.5), std::abs(middle.y - 0.5));
        if (off > 0.26) { EXPECT_LT(field.of_faces[f], 1e-20) << f; }
        if (off < 0.12) { EXPECT_GT(field.of_faces[f], 4) << f; }
    }
    EXPECT_NEAR(sum, 1, 1e-9) << "relative to the mean over the area, which is 1";
    EXPECT_NEAR(field.worst_share, 1, 1e-12) << "all of it in the four cells around the sample";
}

TEST(ErrorField, IsEmptyWithoutError) {
    EXPECT_TRUE(error_field(fit_test::flat_chart(9, 8)).of_faces.empty());
}

TEST(ErrorField, SameBitsForAnyNumberOfThreads) {
    const SampledChart chart =
        fit_test::sheet_chart(65, 12, [](double x, double y) { return 0.1 * std::sin(19 * x) * std::cos(23 * y); });
    std::vector<double> first;
    for (const std::size_t threads : {1, 2}) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
        const ErrorField field = error_field(chart);
        if (first.empty()) first = field.of_faces;
        EXPECT_EQ(field.of_faces, first);
    }
}

TEST(Remap, GivesPlacesOfErrorMoreSamples) {
    const SampledChart before = fit_test::flat_chart(33, 16);
    for (const RemapShape shape : {RemapShape::kLevelled, RemapShape::kOwn}) {
        Remap maps(before, Levelling::kCurvature);
        const std::optional<SampledChart> after = maps.propose(error_in_a_corner(before), shape, {});
        ASSERT_TRUE(after);
        ASSERT_NO_FATAL_FAILURE(test::expect_bijective(*after));
        ASSERT_NO_FATAL_FAILURE(test::expect_classes(*after));
        EXPECT_GT(samples_in_the_corner(*after), 1.2 * static_cast<double>(samples_in_the_corner(before)));
        for (std::uint32_t k = 0; k < 33; ++k)
            for (const std::uint32_t border : {k, 32 * 33 + k, 33 * k, 33 * k + 32})
                EXPECT_EQ(after->positions[border], before.positions[border]) << border;
    }
}

TEST(Remap, GoesOnFromWhatWasAccepted) {
    const SampledChart before = fit_test::flat_chart(33, 16);
    const ErrorField left = error_in_a_corner(before);
    Remap maps(before, std::nullopt);
    EXPECT_FALSE(maps.may_be_levelled());
    const std::optional<SampledChart> first = maps.propose(left, RemapShape::kOwn, {});
    const std::optional<SampledChart> again = maps.propose(left, RemapShape::kOwn, {});
    ASSERT_TRUE(first && again);
    EXPECT_EQ(first->uv, again->uv) << "a proposal that was not accepted changes nothing";
    maps.accept();
    const std::optional<SampledChart> second = maps.propose(left, RemapShape::kOwn, {});
    ASSERT_TRUE(second);
    EXPECT_GT(samples_in_the_corner(*second), samples_in_the_corner(*first));
    const std::optional<SampledChart> alone = Remap(*first, std::nullopt).propose(left, RemapShape::kOwn, {});
    ASSERT_TRUE(alone);
    EXPECT_EQ(second->uv, alone->uv) << "the accepted map is where it starts";
}

TEST(Remap, ProposesNothingWithoutError) {
    Remap maps(fit_test::flat_chart(9, 4), Levelling::kDirections);
    EXPECT_FALSE(maps.propose({}, RemapShape::kLevelled, {}));
}

TEST(Remap, LowersTheErrorOfTheNextFit) {
    SampledChart chart = fit_test::rough_corner();
    Remap maps(chart, std::nullopt);
    const double first = fit_chart(chart, l2_fit(), {}).rms;
    const ErrorField left = error_field(chart);
    EXPECT_GT(left.worst_share, 0.5);
    std::optional<SampledChart> next = maps.propose(left, RemapShape::kOwn, {});
    ASSERT_TRUE(next);
    EXPECT_LT(fit_chart(*next, l2_fit(), {}).rms, 0.7 * first);
}

}  // namespace
}  // namespace dgm::bake
