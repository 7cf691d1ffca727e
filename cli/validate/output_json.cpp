// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/output_json.cpp
#include <nlohmann/json.hpp>

#include "validate/output.h"
#include "validate/run.h"

namespace dgm::validate {
namespace {
using formats::Finding;
using nlohmann::ordered_json;

constexpr int kJsonVersion = 1;

ordered_json number(const std::optional<double>& value) {
    return value ? ordered_json(*value) : ordered_json(nullptr);
}

ordered_json finding_json(const Finding& f, bool known) {
    return {{"code", f.code->id()},
            {"name", f.code->name},
            {"severity", severity_name(f.severity)},
            {"known", known},
            {"pointer", f.place},
            {"message", f.message},
            {"measured", number(f.measured)},
            {"limit", number(f.limit)},
            {"hint", f.code->hint}};
}

ordered_json error_json(const bake::SurfaceError& e) {
    return {{"rms", e.rms},           {"hausdorff", e.hausdorff}, {"normal_rms_degrees", e.normal_rms_degrees},
            {"diagonal", e.diagonal}, {"psnr", e.psnr()},         {"samples", e.samples}};
}

ordered_json counts_json(const Counts& counts) {
    return {{"errors", counts.errors}, {"warnings", counts.warnings}, {"notes", counts.notes}, {"known", counts.known}};
}

ordered_json file_json(const FileValidation& file, const OutputOptions& options) {
    ordered_json findings = ordered_json::array();
    const std::vector<const Finding*> shown = listed(file, options);
    for (const Finding* f : shown) findings.push_back(finding_json(*f, false));
    for (const Finding& f : file.known) findings.push_back(finding_json(f, true));
    const Counts counts = count(file);
    return {{"file", file.path.string()},
            {"exit_code", static_cast<int>(file.exit_code())},
            {"charts", file.charts},
            {"counts", counts_json(counts)},
            {"not_listed", counts.all() - shown.size()},
            {"error", file.error ? error_json(*file.error) : ordered_json(nullptr)},
            {"turned_faces", file.turned_faces ? ordered_json(*file.turned_faces) : ordered_json(nullptr)},
            {"findings", std::move(findings)}};
}
}  // namespace

std::string to_json(std::span<const FileValidation> files, const OutputOptions& options) {
    ordered_json array = ordered_json::array();
    Counts counts;
    std::size_t failed = 0;
    model::ExitCode worst = model::ExitCode::kOk;
    for (const FileValidation& file : files) {
        array.push_back(file_json(file, options));
        counts += count(file);
        worst = model::worse(worst, file.exit_code());
        if (file.exit_code() != model::ExitCode::kOk) ++failed;
    }
    const ordered_json whole{{"dgm_validate", kJsonVersion},
                             {"version", options.version},
                             {"exit_code", static_cast<int>(worst)},
                             {"summary",
                              {{"files", files.size()},
                               {"failed", failed},
                               {"errors", counts.errors},
                               {"warnings", counts.warnings},
                               {"notes", counts.notes},
                               {"known", counts.known}}},
                             {"files", std::move(array)}};
    return whole.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace dgm::validate
