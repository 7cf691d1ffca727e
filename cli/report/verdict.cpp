// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/verdict.cpp
#include "report/verdict.h"

#include <fmt/format.h>

#include <algorithm>

#include "report/html.h"

namespace dgm::report {
namespace {

class Judge {
 public:
    explicit Judge(const bake::BakeReport& report) : report_(report) {}

    Verdict judge() {
        const bake::SurfaceError& e = report_.error;
        for (std::size_t k = 0; k < report_.charts.size(); ++k) about_chart(k);
        for (const std::string& warning : report_.warnings) note(Grade::kLook, warning);
        verdict_.grade = bake::grade_of(report_);
        std::string word(bake::verdict_word(report_));
        word[0] = static_cast<char>(word[0] - 'a' + 'A');
        verdict_.headline = fmt::format("{}: at most {} from the mesh, {} rms.", word,
                                        length_text(e.hausdorff, e.diagonal), length_text(e.rms, e.diagonal));
        std::stable_sort(notes_.begin(), notes_.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
        for (auto& [grade, text] : notes_) verdict_.notes.push_back(std::move(text));
        return std::move(verdict_);
    }

 private:
    void note(Grade grade, std::string text) { notes_.emplace_back(grade, std::move(text)); }
    void about_chart(std::size_t k) {
        const bake::ChartReport& chart = report_.charts[k];
        const std::string where = report_.charts.size() == 1 ? std::string() : fmt::format("chart {}: ", k);
        if (chart.map.flips > 0)
            note(Grade::kBad, where + counted(chart.map.flips, "triangle") + " of the map folded over");
        if (!(chart.seam_gap == 0))
            note(Grade::kBad, where + fmt::format("the seam is open by {}", number_text(chart.seam_gap)));
        if (chart.turned_faces > 0)
            note(bake::has_many_turned(chart) ? Grade::kLook : Grade::kGood,
                 where + counted(chart.turned_faces, "triangle") + " against the source: small creases or spikes");
        if (!bake::keeps_topology(chart))
            note(Grade::kLook, where + fmt::format("it came out with genus {} and {}, the mesh has genus {} and {}",
                                                   chart.map_topology.genus,
                                                   counted(chart.map_topology.boundary_loops, "border loop"),
                                                   chart.source_topology.genus,
                                                   counted(chart.source_topology.boundary_loops, "border loop")));
    }

    const bake::BakeReport& report_;
    Verdict verdict_;
    std::vector<std::pair<Grade, std::string>> notes_;
};

}  // namespace

Verdict verdict_of(const bake::BakeReport& report) {
    return Judge(report).judge();
}

const char* class_of(Grade grade) {
    if (grade == Grade::kGood) return "good";
    return grade == Grade::kLook ? "look" : "bad";
}

}  // namespace dgm::report
