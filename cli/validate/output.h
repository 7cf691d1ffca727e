// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/output.h
// Findings as text for people, JSON for programs, JUnit and SARIF for continuous integration.
#pragma once
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <string_view>

#include "model/error.h"
#include "model/printable.h"
#include "validate/validation.h"

namespace dgm::validate {

using model::printable;

enum class Verbosity { kQuiet, kNormal, kVerbose };

struct OutputOptions {
    Verbosity verbosity = Verbosity::kNormal;
    /// Findings listed of a file, errors before others. Those left out are counted, and decide the exit code as ever.
    std::size_t max_issues = std::numeric_limits<std::size_t>::max();
    std::string version;        ///< of the tool
    std::string homepage;       ///< address of the project, for SARIF; may be empty
    bool has_source = false;    ///< a comparison with a source was asked for
    bool has_baseline = false;  ///< so that findings are either known or new
};

struct Counts {
    std::size_t errors = 0, warnings = 0, notes = 0, known = 0;
    [[nodiscard]] std::size_t all() const { return errors + warnings + notes; }
    Counts& operator+=(const Counts& other);
};
[[nodiscard]] Counts count(const FileValidation& file);

/// Listed findings of a file: at most max_issues in their order, errors before others if not all fit.
[[nodiscard]] std::vector<const formats::Finding*> listed(const FileValidation& file, const OutputOptions& options);

/// One line a finding, `DGM1003 error: FILE: /charts/0/normal: message (measured 3, limit 0) — hint`, then, unless
/// quiet, one line for the file. Quiet lists errors alone; verbose adds the measured error and known findings. Names
/// and messages are made printable (model/printable.h).
[[nodiscard]] std::string to_text(const FileValidation& file, const OutputOptions& options);
/// The last line of several files: "5 files: 3 ok, 2 failed; 4 errors, 1 warning". Empty for one file, or when quiet.
[[nodiscard]] std::string summary_text(std::span<const FileValidation> files, const OutputOptions& options);

/// One object as docs/schemas/validate.schema.json has it. Keys in a fixed order, numbers as short as they read back;
/// ends with a newline.
[[nodiscard]] std::string to_json(std::span<const FileValidation> files, const OutputOptions& options);

/// JUnit XML: a test suite a file, a test case a subject (container, layers, source, file). Errors fail their test
/// case; warnings and notes stand in its output. No times and no hosts.
[[nodiscard]] std::string to_junit(std::span<const FileValidation> files, const OutputOptions& options);

/// SARIF 2.1.0: one run, with the codes as rules. Findings that the baseline knows have the baseline state `unchanged`.
[[nodiscard]] std::string to_sarif(std::span<const FileValidation> files, const OutputOptions& options);

/// "error", "warning", "note"
[[nodiscard]] const char* severity_name(formats::Severity severity);
/// " (measured 3, limit 0)", or the parts of it that there are.
[[nodiscard]] std::string figures_text(const formats::Finding& finding);

}  // namespace dgm::validate
