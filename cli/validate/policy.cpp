// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/policy.cpp
#include "validate/policy.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "files/regular_file.h"
#include "model/codes.h"
#include "validate/code_pages.h"

namespace dgm::validate {
namespace {
namespace codes = model::codes;
namespace fs = std::filesystem;
using formats::Finding;
using formats::Severity;
using nlohmann::json;
using nlohmann::ordered_json;

constexpr int kBaselineVersion = 1;

/// A pointer without "[3][4]".
std::string without_indices(std::string_view pointer) {
    std::string out;
    bool inside = false;
    for (const char c : pointer) {
        if (c == '[') inside = true;
        if (!inside) out += c;
        if (c == ']') inside = false;
    }
    return out;
}

/// The file as seen from the folder, so that a baseline holds wherever the project is checked out.
std::string name_from(const fs::path& folder, const fs::path& file) {
    std::error_code error;
    const fs::path whole = fs::absolute(file, error).lexically_normal();
    const fs::path relative = whole.lexically_relative(folder);
    return (relative.empty() ? whole : relative).generic_string();
}

fs::path folder_of(const fs::path& baseline) {
    std::error_code error;
    return fs::absolute(baseline, error).lexically_normal().parent_path();
}

std::string key_of(const std::string& file, const std::string& code, std::string_view pointer) {
    return file + '\n' + code + '\n' + without_indices(pointer);
}
}  // namespace

void add_severity_rule(SeverityRules& rules, std::string_view text) {
    const std::size_t equals = text.find('=');
    const std::string_view level = equals == std::string_view::npos ? "" : text.substr(equals + 1);
    const model::Code* code = find_code(text.substr(0, equals));
    if (code == nullptr)
        throw model::Error(codes::kUsage, "--severity: there is no code `" + std::string(text.substr(0, equals)) + "`");
    std::optional<Severity>& rule = rules[code->number];
    if (level == "error")
        rule = Severity::kError;
    else if (level == "warning")
        rule = Severity::kWarning;
    else if (level == "note")
        rule = Severity::kNote;
    else if (level == "off")
        rule = std::nullopt;
    else
        throw model::Error(codes::kUsage,
                           "--severity: `" + std::string(text) + "` is not CODE=error, warning, note or off");
}

void apply_rules(const SeverityRules& rules, FileValidation& file) {
    if (rules.empty()) return;
    std::vector<Finding> kept;
    for (Finding& finding : file.findings) {
        const auto rule = rules.find(finding.code->number);
        if (rule != rules.end() && !rule->second) continue;
        if (rule != rules.end()) finding.severity = *rule->second;
        kept.push_back(std::move(finding));
    }
    file.findings = std::move(kept);
}

Baseline Baseline::read(const fs::path& path) {
    constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30;
    const std::string text = formats::read_small_file(path, kMostBytes);
    const json parsed = json::parse(text, nullptr, false);
    const auto refuse = [&](const std::string& what) { throw model::Error(codes::kBadBaseline, what, path.string()); };
    if (!parsed.is_object() || !parsed.contains("dgm_validate_baseline")) refuse("not a baseline of dgm-validate");
    if (parsed["dgm_validate_baseline"] != kBaselineVersion) refuse("a baseline of another version");
    if (!parsed.contains("findings") || !parsed["findings"].is_array()) refuse("it has no list of findings");
    Baseline baseline;
    baseline.folder_ = folder_of(path);
    for (const json& entry : parsed["findings"]) {
        for (const char* key : {"file", "code", "pointer"})
            if (!entry.is_object() || !entry.contains(key) || !entry[key].is_string())
                refuse(fmt::format("a finding has no {}", key));
        ++baseline.remaining_[key_of(entry["file"], entry["code"], entry["pointer"].get<std::string>())];
    }
    return baseline;
}

void Baseline::apply(FileValidation& file) const {
    if (remaining_.empty()) return;
    std::map<std::string, int> used;  // each file is judged alone: two threads may call at once
    const std::string name = name_from(folder_, file.path);
    std::vector<Finding> fresh;
    for (Finding& finding : file.findings) {
        const std::string key = key_of(name, finding.code->id(), finding.place);
        const auto known = remaining_.find(key);
        if (known != remaining_.end() && used[key]++ < known->second)
            file.known.push_back(std::move(finding));
        else
            fresh.push_back(std::move(finding));
    }
    file.findings = std::move(fresh);
}

std::string baseline_json(std::span<const FileValidation> files, const fs::path& path) {
    ordered_json findings = ordered_json::array();
    const fs::path folder = folder_of(path);
    for (const FileValidation& file : files)
        for (const auto* list : {&file.findings, &file.known})
            for (const Finding& f : *list)
                findings.push_back({{"file", name_from(folder, file.path)},
                                    {"code", f.code->id()},
                                    {"pointer", f.place},
                                    {"message", f.message}});
    const ordered_json whole{{"dgm_validate_baseline", kBaselineVersion}, {"findings", std::move(findings)}};
    return whole.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace dgm::validate
