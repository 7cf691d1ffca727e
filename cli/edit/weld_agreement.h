// SPDX-License-Identifier: GPL-3.0-or-later
// cli/edit/weld_agreement.h
// Copies of a seam sample are one point of the surface: after an edit they hold one number.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "model/map_set.h"

namespace dgm::edit {

/// The class of each sample of a layer of rows x cols: the lowest sample that is the same point of the surface, by the
/// chart's seams. In layers of another size than the grid's those are joined that texel_classes() knows.
[[nodiscard]] std::vector<std::uint32_t> seam_classes(const model::Chart& chart, std::uint32_t rows,
                                                      std::uint32_t cols);

/// Samples that have copies, in their order: all others agree with themselves.
struct SeamSamples {
    std::vector<std::uint32_t> samples, classes;
    std::vector<char> changed;
};
[[nodiscard]] SeamSamples samples_with_copies(std::span<const std::uint32_t> classes, std::span<const char> changed);

/// The samples of one class that differ, decided by which of them were changed.
struct Agreement {
    std::uint32_t sample = 0;   ///< gets `value`
    std::vector<double> value;  ///< its numbers
};

/// For each class with a changed sample: the value that all of them get is that of the changed one; of several, their
/// mean if `averages`, else that of the lowest. Returned are the samples whose numbers that changes, in their order.
/// @param numbers  of all samples, `count` each
[[nodiscard]] std::vector<Agreement> agree(std::span<const std::uint32_t> classes, std::span<const char> changed,
                                           std::span<const double> numbers, std::uint32_t count, bool averages);

}  // namespace dgm::edit
