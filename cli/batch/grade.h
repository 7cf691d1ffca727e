// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/grade.h
// A bake judged by its figures: the word that a result line begins with, and the colour of its page.
#pragma once
#include <string_view>

#include "baking/bake_report.h"

namespace dgm::bake {

enum class Grade { kGood, kLook, kBad };

/// kBad: rms beyond 0.5 % or max beyond 5 % of the diagonal, flips, a seam gap, or an error that is not a number.
/// kLook: beyond 0.1 % or 1 %, more than one triangle in 1000 turned, another topology than the source's, or a warning.
/// The limits are where the difference begins to be seen with the object filling the screen (0.1 % is a pixel of a
/// thousand), and where it is another shape.
[[nodiscard]] Grade grade_of(const BakeReport& report);

/// "good", "worth a look", "far from the mesh" or "wrong".
[[nodiscard]] std::string_view verdict_word(const BakeReport& report);

/// More than one triangle in 1000 looks against the source; a few at a sharp edge or a spout nobody sees.
[[nodiscard]] bool has_many_turned(const ChartReport& chart);
[[nodiscard]] bool keeps_topology(const ChartReport& chart);

}  // namespace dgm::bake
