// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/output_junit.cpp
#include <fmt/format.h>

#include <array>

#include "model/entities.h"
#include "validate/output.h"

namespace dgm::validate {
namespace {
using formats::Finding;
using formats::Severity;

/// Length of the UTF-8 character at the start of `text`; 0 if it is none, or one that XML 1.0 does not have.
std::size_t xml_character(std::string_view text) {
    const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
    const unsigned first = byte(0);
    if (first < 0x80) return first >= 0x20 && first != 0x7f ? 1 : 0;
    const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
    if (first < 0xc2 || first > 0xf4 || text.size() < length) return 0;
    std::uint32_t point = first & (0xffu >> (length + 1));
    for (std::size_t k = 1; k < length; ++k) {
        if ((byte(k) & 0xc0u) != 0x80) return 0;
        point = point << 6 | (byte(k) & 0x3fu);
    }
    constexpr std::array<std::uint32_t, 5> kShortest{0, 0, 0x80, 0x800, 0x10000};
    const bool surrogate = point >= 0xd800 && point <= 0xdfff;
    return point < kShortest[length] || surrogate || point > 0x10ffff || (point & 0xfffe) == 0xfffe ? 0 : length;
}

std::string escaped(std::string_view text) {
    std::string out;
    while (!text.empty()) {
        const std::size_t length = xml_character(text);
        const char c = text[0];
        if (c == '\n')
            out += "&#10;";
        else if (length == 0)
            out += '?';
        else if (const std::string_view entity = model::entity_of(c); !entity.empty() && c != '\'')
            out += entity;
        else
            out += text.substr(0, length);
        text.remove_prefix(std::max<std::size_t>(length, 1));
    }
    return out;
}

struct Subject {
    const char* name;
    int first_code, last_code;
};
constexpr std::array<Subject, 4> kSubjects{
    {{"file", 5000, 9999}, {"container", 1000, 1999}, {"layers", 2000, 2999}, {"source", 3000, 4999}}};

std::string line_of(const Finding& f) {
    std::string out = fmt::format("{} {}: ", f.code->id(), f.code->name);
    if (!f.place.empty()) out += f.place + ": ";
    return out + fmt::format("{}{} — {}", f.message, figures_text(f), f.code->hint);
}

struct Case {
    std::string text;
    std::size_t failures = 0, errors = 0, skipped = 0;
};

Case test_case(const Subject& subject, const FileValidation& file, const std::vector<const Finding*>& shown,
               std::size_t errors, bool skipped) {
    Case out;
    std::string bad, other;
    const Finding* first = nullptr;
    for (const Finding* f : shown) {
        if (f->code->number < subject.first_code || f->code->number > subject.last_code) continue;
        if (f->severity == Severity::kError) {
            if (first == nullptr) first = f;
            bad += line_of(*f) + "\n";
        } else {
            other += std::string(severity_name(f->severity)) + ": " + line_of(*f) + "\n";
        }
    }
    for (const Finding& f : file.known)
        if (f.code->number >= subject.first_code && f.code->number <= subject.last_code)
            other += "known: " + line_of(f) + "\n";
    out.text = fmt::format("    <testcase classname=\"{}\" name=\"{}\"", escaped(file.path.string()), subject.name);
    if (errors == 0 && other.empty() && !skipped) {
        out.text += "/>\n";
        return out;
    }
    out.text += ">\n";
    if (errors > 0) {
        // "error": the file could not be judged. "failure": it was, and did not pass.
        const bool no_verdict = subject.first_code >= 5000;
        (no_verdict ? out.errors : out.failures) = 1;
        const char* tag = no_verdict ? "error" : "failure";
        out.text += fmt::format("      <{0} type=\"{1}\" message=\"{2}\">{3}</{0}>\n", tag,
                                first == nullptr ? "DGM" : first->code->id(),
                                escaped(first == nullptr ? fmt::format("{} errors, not listed", errors)
                                                         : first->message + figures_text(*first)),
                                escaped(bad));
    } else if (skipped) {
        out.skipped = 1;
        out.text += "      <skipped/>\n";
    }
    if (!other.empty()) out.text += "      <system-out>" + escaped(other) + "</system-out>\n";
    out.text += "    </testcase>\n";
    return out;
}
}  // namespace

std::string to_junit(std::span<const FileValidation> files, const OutputOptions& options) {
    std::string suites;
    std::size_t all_failures = 0, all_errors = 0;
    for (const FileValidation& file : files) {
        const std::vector<const Finding*> shown = listed(file, options);
        std::string cases;
        std::size_t failures = 0, errors = 0, skips = 0;
        for (const Subject& subject : kSubjects) {
            std::size_t found = 0;
            for (const Finding& f : file.findings)
                if (f.severity == Severity::kError && f.code->number >= subject.first_code &&
                    f.code->number <= subject.last_code)
                    ++found;
            const bool skipped = found == 0 && subject.first_code == 3000 && !options.has_source;
            const Case made = test_case(subject, file, shown, found, skipped);
            cases += made.text;
            failures += made.failures;
            errors += made.errors;
            skips += made.skipped;
        }
        suites += fmt::format(
            "  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\">\n{}  </testsuite>\n",
            escaped(file.path.string()), kSubjects.size(), failures, errors, skips, cases);
        all_failures += failures;
        all_errors += errors;
    }
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<testsuites name=\"dgm-validate\" tests=\"{}\" failures=\"{}\" errors=\"{}\">\n{}</testsuites>\n",
        files.size() * kSubjects.size(), all_failures, all_errors, suites);
}

}  // namespace dgm::validate
