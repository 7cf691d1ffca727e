// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/output_text.cpp
#include <fmt/format.h>

#include "validate/output.h"

namespace dgm::validate {
namespace {
using formats::Finding;
using formats::Severity;

std::string plural(std::size_t count, const char* noun) {
    return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

/// "2 errors, 1 warning, 3 known", or "ok".
std::string counts_text(const Counts& counts) {
    std::string text;
    const auto add = [&](std::size_t number, const std::string& what) {
        if (number > 0) text += (text.empty() ? "" : ", ") + what;
    };
    add(counts.errors, plural(counts.errors, "error"));
    add(counts.warnings, plural(counts.warnings, "warning"));
    add(counts.notes, plural(counts.notes, "note"));
    add(counts.known, fmt::format("{} known", counts.known));
    return text;
}

std::string line_of(const Finding& f, const std::string& file, const char* kind) {
    std::string out = fmt::format("{} {}: {}: ", f.code->id(), kind, file);
    if (!f.place.empty()) out += printable(f.place) + ": ";
    return out + fmt::format("{}{} — {}\n", printable(f.message), figures_text(f), f.code->hint);
}
}  // namespace

Counts& Counts::operator+=(const Counts& other) {
    errors += other.errors;
    warnings += other.warnings;
    notes += other.notes;
    known += other.known;
    return *this;
}

Counts count(const FileValidation& file) {
    Counts counts;
    for (const Finding& f : file.findings)
        (f.severity == Severity::kError     ? counts.errors
         : f.severity == Severity::kWarning ? counts.warnings
                                            : counts.notes) += 1;
    counts.known = file.known.size();
    return counts;
}

std::vector<const Finding*> listed(const FileValidation& file, const OutputOptions& options) {
    const Counts counts = count(file);
    const bool all = counts.all() <= options.max_issues;
    std::size_t errors_left = std::min(counts.errors, options.max_issues);
    std::size_t others_left = options.max_issues - errors_left;
    std::vector<const Finding*> out;
    for (const Finding& f : file.findings) {
        std::size_t& left = f.severity == Severity::kError ? errors_left : others_left;
        if (!all && left == 0) continue;
        if (!all) --left;
        out.push_back(&f);
    }
    return out;
}

const char* severity_name(Severity severity) {
    switch (severity) {
        case Severity::kError:
            return "error";
        case Severity::kWarning:
            return "warning";
        default:
            return "note";
    }
}

std::string figures_text(const Finding& f) {
    if (f.measured && f.limit) return fmt::format(" (measured {:.6g}, limit {:.6g})", *f.measured, *f.limit);
    if (f.measured) return fmt::format(" (measured {:.6g})", *f.measured);
    if (f.limit) return fmt::format(" (limit {:.6g})", *f.limit);
    return {};
}

std::string to_text(const FileValidation& file, const OutputOptions& options) {
    const std::string name = printable(file.path.string());
    const Counts counts = count(file);
    const std::vector<const Finding*> shown = listed(file, options);
    const bool quiet = options.verbosity == Verbosity::kQuiet, verbose = options.verbosity == Verbosity::kVerbose;
    std::string out;
    for (const Finding* f : shown)
        if (!quiet || f->severity == Severity::kError) out += line_of(*f, name, severity_name(f->severity));
    if (verbose)
        for (const Finding& f : file.known) out += line_of(f, name, "known");
    if (shown.size() < counts.all() && (!quiet || counts.errors > options.max_issues))
        out += fmt::format("{}: {} more not listed (--max-issues {})\n", name, counts.all() - shown.size(),
                           options.max_issues);
    if (quiet) return out;
    if (verbose && file.error) {
        const bake::SurfaceError& e = *file.error;
        out += fmt::format("{}: rms {:.6g}, hausdorff {:.6g}, psnr {:.2f} dB, normals {:.3g} degrees, {} samples\n",
                           name, e.rms, e.hausdorff, e.psnr(), e.normal_rms_degrees, e.samples);
        if (file.turned_faces)
            out += fmt::format("{}: {} against the source\n", name, plural(*file.turned_faces, "triangle"));
    }
    std::string verdict = counts_text(counts);
    if (counts.errors == 0) verdict = verdict.empty() ? "ok" : "ok, " + verdict;
    out += fmt::format("{}: {}", name, verdict);
    if (file.charts > 0) out += fmt::format(" ({})", plural(file.charts, "chart"));
    return out + "\n";
}

std::string summary_text(std::span<const FileValidation> files, const OutputOptions& options) {
    if (files.size() < 2 || options.verbosity == Verbosity::kQuiet) return {};
    Counts counts;
    std::size_t failed = 0;
    for (const FileValidation& file : files) {
        counts += count(file);
        if (file.exit_code() != model::ExitCode::kOk) ++failed;
    }
    const std::string details = counts_text(counts);
    return fmt::format("{} files: {} ok, {} failed{}{}\n", files.size(), files.size() - failed, failed,
                       details.empty() ? "" : "; ", details);
}

}  // namespace dgm::validate
