// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/verdict.cpp
#include "report/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/html.h"

namespace dgm::report {
namespace {

/// One triangle in so many: a few at a sharp edge or a spout nobody sees.
constexpr std::uint64_t kManyTurned = 1000;

std::uint64_t chart_triangles(const bake::ChartReport& chart) {
    return static_cast<std::uint64_t>(2.0 * chart.rows * chart.cols * chart.utilisation);
}

class Judge {
 public:
    explicit Judge(const bake::BakeReport& report) : report_(report) {}

    Verdict judge() {
        const bake::SurfaceError& e = report_.error;
        const double rms = 100 * e.rms / e.diagonal, worst = 100 * e.hausdorff / e.diagonal;
        if (!std::isfinite(rms) || !std::isfinite(worst)) raise(Grade::kBad);
        if (rms > 0.5 || worst > 5) raise(Grade::kBad);
        if (rms > 0.1 || worst > 1) raise(Grade::kLook);
        for (std::size_t k = 0; k < report_.charts.size(); ++k) about_chart(k);
        for (const std::string& warning : report_.warnings) note(Grade::kLook, warning);
        const std::string figures = fmt::format("at most {} from the mesh, {} rms",
                                                length_text(e.hausdorff, e.diagonal), length_text(e.rms, e.diagonal));
        const bool far = rms > 0.5 || worst > 5;
        if (verdict_.grade == Grade::kGood)
            verdict_.headline = "Good: " + figures + ".";
        else if (verdict_.grade == Grade::kLook)
            verdict_.headline = "Worth a look: " + figures + ".";
        else
            verdict_.headline = (far ? "Far from the mesh: " : "Wrong: ") + figures + ".";
        std::stable_sort(notes_.begin(), notes_.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
        for (auto& [grade, text] : notes_) verdict_.notes.push_back(std::move(text));
        return std::move(verdict_);
    }

 private:
    void raise(Grade grade) { verdict_.grade = std::max(verdict_.grade, grade); }
    void note(Grade grade, std::string text) {
        raise(grade);
        notes_.emplace_back(grade, std::move(text));
    }
    void about_chart(std::size_t k) {
        const bake::ChartReport& chart = report_.charts[k];
        const std::string where = report_.charts.size() == 1 ? std::string() : fmt::format("chart {}: ", k);
        if (chart.map.flips > 0)
            note(Grade::kBad, where + counted(chart.map.flips, "triangle") + " of the map folded over");
        if (!(chart.seam_gap == 0))
            note(Grade::kBad, where + fmt::format("the seam is open by {}", number_text(chart.seam_gap)));
        if (chart.turned_faces > 0)
            note(chart.turned_faces * kManyTurned > chart_triangles(chart) ? Grade::kLook : Grade::kGood,
                 where + counted(chart.turned_faces, "triangle") + " against the source: small creases or spikes");
        if (chart.source_topology.genus != chart.map_topology.genus ||
            chart.source_topology.boundary_loops != chart.map_topology.boundary_loops)
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
