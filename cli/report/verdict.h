// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/verdict.h
// A bake judged in plain words: what an artist reads first.
#pragma once
#include <string>
#include <vector>

#include "baking/bake_report.h"
#include "batch/grade.h"

namespace dgm::report {

using bake::Grade;

struct Verdict {
    Grade grade = Grade::kGood;
    std::string headline;            ///< one sentence with the figures
    std::vector<std::string> notes;  ///< what else to know, worst first
};

/// The grade is bake::grade_of().
[[nodiscard]] Verdict verdict_of(const bake::BakeReport& report);

/// "good", "look", "bad": the class in style.css.
[[nodiscard]] const char* class_of(Grade grade);

}  // namespace dgm::report
