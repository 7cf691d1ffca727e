// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/output.cpp
#include "validate/output.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "model/codes.h"

namespace dgm::validate {
namespace {
using formats::Finding;
using formats::Severity;
using nlohmann::ordered_json;

const char* severity_name(Severity severity) {
    return severity == Severity::kError ? "error" : "warning";
}

/// Names inside a file are a stranger's: they must not move the cursor of who reads about them.
std::string printable(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    return out;
}

std::string figures_text(const Finding& f) {
    if (f.measured && f.limit) return fmt::format(" (measured {:.6g}, limit {:.6g})", *f.measured, *f.limit);
    if (f.measured) return fmt::format(" (measured {:.6g})", *f.measured);
    if (f.limit) return fmt::format(" (limit {:.6g})", *f.limit);
    return {};
}

std::string plural(std::size_t count, const char* noun) {
    return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

ordered_json finding_json(const Finding& f) {
    const auto number = [](const std::optional<double>& x) { return x ? ordered_json(*x) : ordered_json(nullptr); };
    return {{"code", f.code->id()},     {"name", f.code->name}, {"severity", severity_name(f.severity)},
            {"place", f.place},         {"message", f.message}, {"measured", number(f.measured)},
            {"limit", number(f.limit)}, {"hint", f.code->hint}};
}

ordered_json error_json(const bake::SurfaceError& e) {
    return {{"rms", e.rms},           {"hausdorff", e.hausdorff}, {"normal_rms_degrees", e.normal_rms_degrees},
            {"diagonal", e.diagonal}, {"psnr", e.psnr()},         {"samples", e.samples}};
}

std::string upper_case(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    return out;
}
}  // namespace

std::string to_text(const FileValidation& file, Verbosity verbosity) {
    const std::string name = printable(file.path.string());
    std::string out;
    std::size_t errors = 0, warnings = 0;
    for (const Finding& f : file.findings) {
        (f.severity == Severity::kError ? errors : warnings) += 1;
        if (verbosity == Verbosity::kQuiet && f.severity != Severity::kError) continue;
        out += fmt::format("{} {}: {}: ", f.code->id(), severity_name(f.severity), name);
        if (!f.place.empty()) out += printable(f.place) + ": ";
        out += fmt::format("{}{} — {}\n", printable(f.message), figures_text(f), f.code->hint);
    }
    if (verbosity == Verbosity::kQuiet) return out;
    if (verbosity == Verbosity::kVerbose && file.error) {
        const bake::SurfaceError& e = *file.error;
        out += fmt::format("{}: rms {:.6g}, hausdorff {:.6g}, psnr {:.2f} dB, normals {:.3g} degrees, {} samples\n",
                           name, e.rms, e.hausdorff, e.psnr(), e.normal_rms_degrees, e.samples);
        if (file.turned_faces)
            out += fmt::format("{}: {} against the source\n", name, plural(*file.turned_faces, "triangle"));
    }
    std::string verdict = errors > 0 ? plural(errors, "error") : "ok";
    if (warnings > 0) verdict += ", " + plural(warnings, "warning");
    out += fmt::format("{}: {}", name, verdict);
    if (file.charts > 0) out += fmt::format(" ({})", plural(file.charts, "chart"));
    return out + "\n";
}

std::string to_json(std::span<const FileValidation> files) {
    ordered_json array = ordered_json::array();
    for (const FileValidation& file : files) {
        ordered_json findings = ordered_json::array();
        for (const Finding& f : file.findings) findings.push_back(finding_json(f));
        array.push_back({{"file", file.path.string()},
                         {"exit_code", static_cast<int>(file.exit_code())},
                         {"charts", file.charts},
                         {"error", file.error ? error_json(*file.error) : ordered_json(nullptr)},
                         {"turned_faces", file.turned_faces ? ordered_json(*file.turned_faces) : ordered_json(nullptr)},
                         {"findings", std::move(findings)}});
    }
    return array.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

const model::Code* find_code(std::string_view name) {
    const std::string wanted = upper_case(name);
    for (const model::Code* code : model::codes::kAll)
        if (wanted == code->id() || wanted == std::to_string(code->number) || wanted == code->name ||
            wanted == code->id() + "_" + code->name)
            return code;
    return nullptr;
}

std::string explain(const model::Code& code) {
    return fmt::format("{} {}\n  {}\n  hint: {}\n  exit code: {}\n", code.id(), code.name, code.title, code.hint,
                       static_cast<int>(code.exit));
}

}  // namespace dgm::validate
