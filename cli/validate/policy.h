// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/policy.h
// A project's rules for findings: other severities, and a baseline of known findings.
#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "validate/validation.h"

namespace dgm::validate {

/// Severity of a code whatever the checks say; nothing: the finding is left out.
using SeverityRules = std::map<int, std::optional<formats::Severity>>;

/// Adds "CODE=error|warning|note|off"; later rules win.
/// @throws model::Error kUsage
void add_severity_rule(SeverityRules& rules, std::string_view text);

/// Findings that are known and pass. One is known if file, code and pointer are the same, indices in brackets left
/// aside, since they move with every bake; of n equal ones in the list, n pass.
class Baseline {
 public:
    /// Empty: nothing is known.
    Baseline() = default;
    /// @throws model::Error kBadBaseline, kFileMissing, kReadFailed
    static Baseline read(const std::filesystem::path& path);
    /// Moves known findings from `findings` to `known`.
    void apply(FileValidation& file) const;

 private:
    std::filesystem::path folder_;          // files are named relative to that of the baseline
    std::map<std::string, int> remaining_;  // by key
};

/// JSON for Baseline::read, in the order of the files: all findings, those known already too.
[[nodiscard]] std::string baseline_json(std::span<const FileValidation> files, const std::filesystem::path& path);

/// Sets severities and takes out those that are off.
void apply_rules(const SeverityRules& rules, FileValidation& file);

}  // namespace dgm::validate
