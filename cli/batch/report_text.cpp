// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/report_text.cpp
#include "batch/report_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "baking/option_names.h"
#include "baking/up_to_date.h"
#include "batch/grade.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

std::string plural(std::uint64_t count, std::string_view noun) {
    return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

/// "stretch 257x257", or each kind once where charts differ: "3 charts, stretch 257x257, lscm 65x65".
std::string charts_text(const std::vector<ChartReport>& charts) {
    std::vector<std::string> kinds;
    for (const ChartReport& chart : charts) {
        std::string kind = fmt::format("{} {}x{}", printable(chart.method), chart.rows, chart.cols);
        if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) kinds.push_back(std::move(kind));
    }
    std::string out = charts.size() == 1 ? std::string() : plural(charts.size(), "chart");
    for (const std::string& kind : kinds) out += (out.empty() ? "" : ", ") + kind;
    return out;
}

/// "0.01 % (0.02 units)": % of the diagonal, and the units of the source.
std::string error_text(double value, double diagonal, int digits = 2) {
    return fmt::format("{:.{}g} % ({:.{}g} units)", diagonal > 0 ? 100 * value / diagonal : 0.0, digits, value, digits);
}

/// "good, max 0.05 % (0.1 units), rms 0.01 % (0.02 units)"
std::string verdict_text(const BakeReport& report) {
    const SurfaceError& error = report.error;
    return fmt::format("{}, max {}, rms {}", verdict_word(report), error_text(error.hausdorff, error.diagonal),
                       error_text(error.rms, error.diagonal));
}

struct Faults {
    std::uint64_t flips = 0, turned = 0;
    double seam_gap = 0;
    bool keeps_topology = true;
};

Faults faults_of(const BakeReport& report) {
    Faults out;
    for (const ChartReport& chart : report.charts) {
        out.flips += chart.map.flips;
        out.turned += chart.turned_faces;
        out.seam_gap = std::max(out.seam_gap, chart.seam_gap);
        out.keeps_topology = out.keeps_topology && keeps_topology(chart);
    }
    return out;
}

/// The names of the files, and their bytes together.
std::pair<std::string, std::uint64_t> files_text(const AssetResult& result) {
    std::pair<std::string, std::uint64_t> out;
    for (const OutputFile& file : result.files) {
        out.first += (out.first.empty() ? "" : ", ") + printable(file.path.lexically_normal().string());
        out.second += file.bytes;
    }
    return out;
}

std::vector<std::string> lines_of(std::string_view text) {
    std::vector<std::string> out;
    while (!text.empty()) {
        const std::size_t end = text.find('\n');
        if (const std::string_view line = text.substr(0, end); !line.empty()) out.push_back(printable(line));
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    }
    return out;
}

std::string size_text(const GridTrial& t) {
    return fmt::format("{}x{}", t.rows, t.cols);
}

/// "rms 0.02 (0.01 %)" and what else the trial measured.
std::string trial_text(const GridTrial& t, double diagonal) {
    std::string out;
    if (std::isfinite(t.rms)) out = "rms " + error_text(t.rms, diagonal, 4);
    if (std::isfinite(t.hausdorff)) out += ", max " + error_text(t.hausdorff, diagonal, 4);
    if (t.bytes > 0) out += (out.empty() ? "" : ", ") + bytes_text(t.bytes);
    return out.empty() ? "no map" : out;
}

std::vector<std::string> search_lines(const GridSearch& s, double diagonal) {
    std::vector<std::string> out{"  " + search_story(s, diagonal)};
    for (const GridTrial& t : s.shapes)
        out.push_back(fmt::format("    shape {}: {}, {:.2f} s of CPU, {}", size_text(t), trial_text(t, diagonal),
                                  t.cpu_seconds, printable(t.outcome)));
    for (const GridTrial& t : s.trials)
        out.push_back(fmt::format("    grid {}: {}, {:.2f} s of CPU, {}", size_text(t), trial_text(t, diagonal),
                                  t.cpu_seconds, printable(t.outcome)));
    return out;
}

std::string topology_text(const Topology& t) {
    return fmt::format("{}genus {}, {}", t.oriented ? "" : "one side, ", t.genus,
                       plural(t.boundary_loops, "border loop"));
}

/// "normals 1.2 degrees off (faces 5.1, with bump 0.8)"
std::string normals_text(const SurfaceError& e) {
    std::string out =
        fmt::format("normals {:.3g} degrees off (faces {:.3g}", e.normal_rms_degrees, e.normal_rms_face_degrees);
    if (!std::isnan(e.normal_rms_bump_degrees)) out += fmt::format(", with bump {:.3g}", e.normal_rms_bump_degrees);
    return out + ")";
}

}  // namespace

std::string bytes_text(std::uint64_t bytes) {
    constexpr std::array<std::string_view, 4> kUnits{"kB", "MB", "GB", "TB"};
    if (bytes < 1000) return fmt::format("{} B", bytes);
    double value = static_cast<double>(bytes) / 1000;
    std::size_t unit = 0;
    for (; value >= 999.95 && unit + 1 < kUnits.size(); ++unit) value /= 1000;
    return fmt::format("{:.1f} {}", value, kUnits[unit]);
}

std::string search_story(const GridSearch& s, double diagonal) {
    const std::string answer = fmt::format("{}x{}", s.rows, s.cols);
    constexpr int kDigits = 4;  // neighbours of the ladder differ in the second or third
    std::string out;
    if (s.goal == SearchGoal::kMaxError) {
        const ErrorKind kind = s.kind.value_or(ErrorKind::kRms);
        out = fmt::format("asked for {} {}: {} reaches {}", name_of(kErrorKindNames, kind),
                          error_text(s.asked, diagonal, kDigits), answer, error_text(s.reached, diagonal, kDigits));
        if (s.next)
            out += fmt::format(
                "; the next smaller grid, {}, would have given {}", size_text(*s.next),
                s.next->bytes == 0 && !std::isfinite(s.next->rms)
                    ? "no map"
                    : error_text(kind == ErrorKind::kHausdorff ? s.next->hausdorff : s.next->rms, diagonal, kDigits));
        else
            out += "; there is no smaller grid";
        if (s.asked_bytes > 0) out += fmt::format("; the file may have {}", bytes_text(s.asked_bytes));
    } else if (s.goal == SearchGoal::kBudget) {
        out = fmt::format("asked for at most {}: {}, rms {}", bytes_text(s.asked_bytes), answer,
                          error_text(s.reached, diagonal, kDigits));
        if (s.next)
            out += fmt::format("; the next larger grid, {}, would have taken {}", size_text(*s.next),
                               bytes_text(s.next->bytes));
        else
            out += "; no larger grid is allowed";
    } else {
        out = fmt::format("asked for at most {} samples: {} is the best shape measured", s.asked_samples, answer);
    }
    return out;
}

std::string up_to_date_line(const AssetResult& result) {
    const auto [names, bytes] = files_text(result);
    std::string out = fmt::format("{}: up to date, {}, {}", names, verdict_text(result.report), bytes_text(bytes));
    if (const auto edited = edited_layers(result.report); !edited.empty())
        out += fmt::format(", edited: {}", printable(fmt::format("{}", fmt::join(edited, ", "))));
    return out;
}

std::string result_line(const AssetResult& result) {
    const BakeReport& report = result.report;
    const Faults faults = faults_of(report);
    const auto [names, bytes] = files_text(result);
    std::string out = fmt::format("{}: {}, {}, {}, {:.1f} s", names, verdict_text(report), charts_text(report.charts),
                                  bytes_text(bytes), result.seconds);
    if (faults.flips > 0) out += ", " + plural(faults.flips, "flip");
    if (!(faults.seam_gap == 0)) out += fmt::format(", seam gap {:g}", faults.seam_gap);
    if (!faults.keeps_topology) out += ", another topology than the mesh";
    if (faults.turned > 0) out += ", " + plural(faults.turned, "turned face");
    if (!report.warnings.empty()) out += ", " + plural(report.warnings.size(), "warning");
    return out;
}

std::vector<std::string> detail_lines(const BakeReport& report) {
    const Faults faults = faults_of(report);
    std::vector<std::string> out{fmt::format("  {:.1f} dB, {}, {}, seam gap {:g}", report.error.psnr(),
                                             plural(faults.flips, "flip"), plural(faults.turned, "turned face"),
                                             faults.seam_gap)};
    for (const auto& [kind, count] : report.repairs)
        out.push_back(fmt::format("  repaired: {} {}", count, printable(kind)));
    for (const std::string& remark : report.remarks) out.push_back("  note: " + printable(remark));
    for (const std::string& warning : report.warnings) out.push_back("  warning: " + printable(warning));
    for (std::size_t k = 0; k < report.charts.size(); ++k) {
        const ChartReport& chart = report.charts[k];
        out.push_back(fmt::format("  chart {}: {} {}x{} ({}), {}, {}, {:.1f} dB, stretch {:.3g}, {:.0f} % used", k,
                                  printable(chart.method), chart.rows, chart.cols, printable(chart.domain),
                                  plural(chart.source_faces, "face"), topology_text(chart.source_topology),
                                  chart.error.psnr(), chart.map.stretch_l2, 100 * chart.utilisation));
        out.push_back("    " + normals_text(chart.error));
        if (!(chart.source_topology.genus == chart.map_topology.genus &&
              chart.source_topology.boundary_loops == chart.map_topology.boundary_loops))
            out.push_back("    reconstructed as " + topology_text(chart.map_topology));
        for (const CandidateReport& candidate : chart.candidates)
            out.push_back(fmt::format("    tried {}: {}{:.2f} s of CPU, {}", printable(candidate.method),
                                      candidate.psnr > 0 ? fmt::format("{:.1f} dB, ", candidate.psnr) : std::string(),
                                      candidate.cpu_seconds, printable(candidate.outcome)));
    }
    if (report.search)
        for (const std::string& line : search_lines(*report.search, report.error.diagonal)) out.push_back(line);
    for (const StageTime& time : report.times)
        out.push_back(
            fmt::format("  {}: {:.2f} s, {:.2f} s of CPU", printable(time.stage), time.seconds, time.cpu_seconds));
    if (report.peak_memory_bytes > 0)
        out.push_back(fmt::format("  {:.1f} s of CPU, {} of memory at most", report.cpu_seconds,
                                  bytes_text(report.peak_memory_bytes)));
    return out;
}

std::string failure_story(std::string_view subject, const model::Error& error, std::string_view worker_output) {
    std::string head = "dgm-bake: ";
    if (!subject.empty()) head += printable(subject) + ": ";
    if (!error.stage().empty()) head += printable(error.stage()) + ": ";
    head += error.code().id() + ": ";
    std::string out;
    for (const std::string& line : lines_of(error.what())) out += (out.empty() ? head : "  ") + line + '\n';
    if (out.empty()) out = head + error.code().title + '\n';
    if (!error.place().empty() && error.place() != subject) out += "  at: " + printable(error.place()) + '\n';
    if (error.code().number == model::codes::kWorkerCrashed.number) {
        const std::vector<std::string> said = lines_of(worker_output);
        for (std::size_t k = said.size() - std::min<std::size_t>(said.size(), 3); k < said.size(); ++k)
            out += "  it said: " + said[k].substr(0, 500) + '\n';
    }
    return out + "  next: " + error.hint() + '\n';
}

std::vector<std::string> left_out_lines(const std::vector<LeftOutFile>& files, bool each) {
    std::vector<std::string> out;
    if (each) {
        for (const LeftOutFile& file : files)
            out.push_back(fmt::format("left out: {}: {}", printable(file.path.string()), file.why));
        return out;
    }
    std::map<std::pair<std::string, std::string>, std::uint64_t> kinds;
    for (const LeftOutFile& file : files) ++kinds[{printable(file.path.extension().string()), file.why}];
    for (const auto& [kind, count] : kinds)
        out.push_back(fmt::format("left out: {}: {}", plural(count, kind.first + " file"), kind.second));
    return out;
}

std::vector<std::string> left_over_lines(const std::vector<LeftOver>& files) {
    std::vector<std::string> out;
    out.reserve(files.size() + 1);
    const bool all_stay = std::none_of(files.begin(), files.end(), [](const LeftOver& file) { return file.removed; });
    for (const LeftOver& file : files)
        out.push_back(fmt::format("{}: {}: its mesh {} {}", file.removed ? "removed" : "left over",
                                  printable(file.path.lexically_normal().string()), printable(file.source_name),
                                  file.replacement.empty()
                                      ? "is gone"
                                      : "becomes " + printable(file.replacement.lexically_normal().string()) + " now"));
    if (!files.empty() && all_stay) out.push_back(fmt::format("--prune removes {}", files.size() == 1 ? "it" : "them"));
    return out;
}

std::string summary_line(const std::vector<AssetResult>& results) {
    std::string out = plural(results.size(), "asset") + ":";
    const char* separator = " ";
    for (const Outcome outcome : kOutcomes) {
        const auto count = std::count_if(results.begin(), results.end(),
                                         [outcome](const AssetResult& r) { return r.outcome == outcome; });
        if (count == 0) continue;
        out += fmt::format("{}{} {}", separator, count, name_of(outcome));
        separator = ", ";
    }
    return out;
}

}  // namespace dgm::bake
