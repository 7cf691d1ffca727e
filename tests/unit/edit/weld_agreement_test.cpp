// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/edit/weld_agreement_test.cpp
#include "edit/weld_agreement.h"

#include <gtest/gtest.h>

#include <vector>

#include "unit/render/sample_chart.h"

namespace dgm::edit {
namespace {

/// Samples 0, 2 and 3 are one point; 1 is alone.
const std::vector<std::uint32_t> kClasses{0, 1, 0, 0};

std::vector<std::pair<std::uint32_t, double>> agreed(const std::vector<char>& changed,
                                                     const std::vector<double>& numbers, bool averages = true) {
    std::vector<std::pair<std::uint32_t, double>> out;
    for (const Agreement& a : agree(kClasses, changed, numbers, 1, averages)) out.emplace_back(a.sample, a.value[0]);
    return out;
}

using Expected = std::vector<std::pair<std::uint32_t, double>>;

TEST(WeldAgreement, ThePaintedCopyWins) {
    EXPECT_EQ(agreed({0, 0, 1, 0}, {1, 1, 0.25, 1}), (Expected{{0, 0.25}, {3, 0.25}}));
}

TEST(WeldAgreement, SeveralPaintedCopiesThatAgreeWinTogether) {
    EXPECT_EQ(agreed({1, 0, 1, 0}, {0.1f, 1, 0.1f, 1}), (Expected{{3, 0.1f}}));
}

TEST(WeldAgreement, SeveralThatDifferGiveTheirMean) {
    EXPECT_EQ(agreed({1, 0, 1, 0}, {0, 1, 0.5, 1}), (Expected{{0, 0.25}, {2, 0.25}, {3, 0.25}}));
}

TEST(WeldAgreement, LabelsAreNotAveraged) {
    EXPECT_EQ(agreed({1, 0, 1, 0}, {7, 1, 4, 1}, false), (Expected{{2, 7}, {3, 7}}));
}

TEST(WeldAgreement, WhatNobodyPaintedStays) {
    EXPECT_EQ(agreed({0, 1, 0, 0}, {1, 9, 2, 3}), Expected{});
}

TEST(WeldAgreement, AllNumbersOfASampleGoTogether) {
    const std::vector<double> numbers{1, 2, 0, 0, 5, 6, 1, 2};
    const auto found = agree(kClasses, std::vector<char>{0, 0, 1, 0}, numbers, 2, true);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].sample, 0u);
    EXPECT_EQ(found[0].value, (std::vector<double>{5, 6}));
    EXPECT_EQ(found[1].sample, 3u);
}

TEST(WeldAgreement, OnlySamplesWithCopiesAreLookedAt) {
    const SeamSamples found =
        samples_with_copies(std::vector<std::uint32_t>{0, 1, 0, 3, 3}, std::vector<char>{0, 1, 1, 0, 1});
    EXPECT_EQ(found.samples, (std::vector<std::uint32_t>{0, 2, 3, 4}));
    EXPECT_EQ(found.classes, (std::vector<std::uint32_t>{0, 0, 3, 3}));
    EXPECT_EQ(found.changed, (std::vector<char>{0, 1, 0, 1}));
}

TEST(WeldAgreement, ClassesAreThoseOfTheSeams) {
    constexpr std::uint32_t m = 5, n = 7;
    const model::Chart chart = test::torus_chart(m, n);
    const std::vector<std::uint32_t> classes = seam_classes(chart, m, n);
    for (std::uint32_t i = 0; i < m; ++i)
        for (std::uint32_t j = 0; j < n; ++j)
            EXPECT_EQ(classes[i * n + j], i % (m - 1) * n + j % (n - 1)) << i << ' ' << j;
    // Between samples, too.
    const std::uint32_t rows = 2 * (m - 1) + 1, cols = 2 * (n - 1) + 1;
    const std::vector<std::uint32_t> texels = seam_classes(chart, rows, cols);
    for (std::uint32_t i = 0; i < rows; ++i)
        for (std::uint32_t j = 0; j < cols; ++j)
            EXPECT_EQ(texels[i * cols + j], i % (rows - 1) * cols + j % (cols - 1)) << i << ' ' << j;
}

}  // namespace
}  // namespace dgm::edit
