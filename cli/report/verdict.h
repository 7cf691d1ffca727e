// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/verdict.h
// A bake judged in plain words: what an artist reads first.
#pragma once
#include <string>
#include <vector>

#include "baking/bake_report.h"

namespace dgm::report {

enum class Grade { kGood, kLook, kBad };

struct Verdict {
    Grade grade = Grade::kGood;
    std::string headline;            ///< one sentence with the figures
    std::vector<std::string> notes;  ///< what else to know, worst first
};

/// kBad: rms beyond 0.5 % or max beyond 5 % of the diagonal, flips, a seam gap, or an error that is not a number.
/// kLook: beyond 0.1 % or 1 %, more than one triangle in 1000 turned, another topology than the source's, or a warning.
/// The limits are where the difference begins to be seen with the object filling the screen (0.1 % is a pixel of a
/// thousand), and where it is another shape.
[[nodiscard]] Verdict verdict_of(const bake::BakeReport& report);

/// "good", "look", "bad": the class in style.css.
[[nodiscard]] const char* class_of(Grade grade);

}  // namespace dgm::report
