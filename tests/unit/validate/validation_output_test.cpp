// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/validate/validation_output_test.cpp
// Texts and JSON, character by character where other programs read them.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "model/codes.h"
#include "validate/code_pages.h"
#include "validate/output.h"

namespace dgm::validate {
namespace {
using formats::Severity;
namespace codes = model::codes;

FileValidation sample_file() {
    FileValidation file;
    file.path = "a\nb.dgm";
    file.charts = 1;
    file.findings.push_back(
        {&codes::kSeamGap, Severity::kError, "samples differ\x1b[2J", "/charts/0/geometry", 0.25, 0.0});
    file.findings.push_back({&codes::kBadReport, Severity::kWarning, "no report", "/report", {}, {}});
    return file;
}

OutputOptions with(Verbosity verbosity) {
    OutputOptions options;
    options.verbosity = verbosity;
    options.version = "1.2.3";
    return options;
}

TEST(ValidationOutput, Text) {
    const std::string error =
        "DGM2004 error: a\\x0ab.dgm: /charts/0/geometry: samples differ\\x1b[2J (measured 0.25, limit 0) — " +
        std::string(codes::kSeamGap.hint) + "\n";
    const std::string warning =
        "DGM2011 warning: a\\x0ab.dgm: /report: no report — " + std::string(codes::kBadReport.hint) + "\n";
    EXPECT_EQ(to_text(sample_file(), with(Verbosity::kNormal)),
              error + warning + "a\\x0ab.dgm: 1 error, 1 warning (1 chart)\n");
    EXPECT_EQ(to_text(sample_file(), with(Verbosity::kQuiet)), error);
    FileValidation good;
    good.path = "good.dgm";
    good.charts = 3;
    EXPECT_EQ(to_text(good, with(Verbosity::kNormal)), "good.dgm: ok (3 charts)\n");
    EXPECT_EQ(to_text(good, with(Verbosity::kQuiet)), "");
    good.error = bake::SurfaceError{};
    good.error->rms = 0.5;
    good.error->diagonal = 50;
    EXPECT_EQ(to_text(good, with(Verbosity::kVerbose)),
              "good.dgm: rms 0.5, hausdorff 0, psnr 40.00 dB, normals 0 degrees, 0 samples\ngood.dgm: ok (3 charts)\n");
}

TEST(ValidationOutput, JsonKeepsKeyOrderAndShortNumbers) {
    FileValidation file = sample_file();
    file.findings[0].message = "bad byte \xff";
    file.findings[0].measured = 0.1;
    file.error = bake::SurfaceError{};
    file.error->diagonal = 2;
    file.known.push_back({&codes::kBadBounds, Severity::kError, "old", "/charts/0", {}, {}});
    const std::string text = to_json(std::vector{file, FileValidation{}}, with(Verbosity::kNormal));
    EXPECT_NE(text.find("\"measured\": 0.1,\n"), std::string::npos) << text;
    EXPECT_EQ(text.back(), '\n');

    const auto json = nlohmann::ordered_json::parse(text);
    const auto keys = [](const auto& object) {
        std::string list;
        for (const auto& item : object.items()) list += item.key() + " ";
        return list;
    };
    EXPECT_EQ(keys(json), "dgm_validate version exit_code summary files ");
    EXPECT_EQ(json["version"], "1.2.3");
    EXPECT_EQ(json["exit_code"], 3);
    EXPECT_EQ(json["summary"].dump(), R"({"files":2,"failed":1,"errors":1,"warnings":1,"notes":0,"known":1})");
    ASSERT_EQ(json["files"].size(), 2u);
    const auto& first = json["files"][0];
    EXPECT_EQ(keys(first), "file exit_code charts counts not_listed error turned_faces findings ");
    EXPECT_EQ(keys(first["findings"][0]), "code name severity known pointer message measured limit hint ");
    EXPECT_EQ(first["file"], "a\nb.dgm");
    EXPECT_EQ(first["exit_code"], 3);
    EXPECT_EQ(first["error"]["psnr"], 300);
    EXPECT_EQ(first["findings"][0]["code"], "DGM2004");
    EXPECT_EQ(first["findings"][0]["name"], "SEAM_GAP");
    EXPECT_EQ(first["findings"][0]["message"], "bad byte \xef\xbf\xbd");
    EXPECT_TRUE(first["findings"][1]["limit"].is_null());
    EXPECT_EQ(first["findings"][2]["known"], true);
    EXPECT_EQ(json["files"][1]["exit_code"], 0);
    EXPECT_TRUE(json["files"][1]["findings"].empty());
}

TEST(ValidationOutput, ACapHidesLinesButNoErrors) {
    FileValidation file = sample_file();  // an error, then a warning
    for (int k = 0; k < 5; ++k)
        file.findings.push_back({&codes::kBadValue, Severity::kError, "v" + std::to_string(k), "/x", {}, {}});
    OutputOptions options = with(Verbosity::kNormal);
    options.max_issues = 3;
    const auto shown = listed(file, options);
    ASSERT_EQ(shown.size(), 3u);
    for (const formats::Finding* f : shown) EXPECT_EQ(f->severity, Severity::kError);
    EXPECT_EQ(shown[2]->message, "v1");
    const std::string text = to_text(file, options);
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 5);
    EXPECT_NE(text.find("4 more not listed (--max-issues 3)\n"), std::string::npos) << text;
    EXPECT_NE(text.find("6 errors, 1 warning"), std::string::npos) << text;
    options.max_issues = 0;
    EXPECT_TRUE(listed(file, options).empty());
    const auto json = nlohmann::json::parse(to_json(std::vector{file}, options));
    EXPECT_EQ(json["files"][0]["counts"]["errors"], 6);
    EXPECT_EQ(json["files"][0]["not_listed"], 7);
    EXPECT_EQ(json["exit_code"], 3);
    const std::string junit = to_junit(std::vector{file}, options);
    EXPECT_NE(junit.find("failures=\"1\""), std::string::npos) << "layers fail, although nothing is listed\n" << junit;
    options.max_issues = 7;
    EXPECT_EQ(listed(file, options).size(), 7u);
}

TEST(ValidationOutput, Summary) {
    FileValidation good;
    const OutputOptions options = with(Verbosity::kNormal);
    EXPECT_EQ(summary_text(std::vector{good}, options), "");
    EXPECT_EQ(summary_text(std::vector{good, sample_file(), good}, options),
              "3 files: 2 ok, 1 failed; 1 error, 1 warning\n");
    EXPECT_EQ(summary_text(std::vector{good, good}, options), "2 files: 2 ok, 0 failed\n");
}

TEST(ValidationOutput, JunitEscapesWhatXmlCannotHold) {
    FileValidation file = sample_file();
    file.findings[0].message = "<a & \"b\">\x01\xff\xef\xbf\xbe \xc3\xa9";
    file.findings[0].measured = file.findings[0].limit = std::nullopt;
    const std::string junit = to_junit(std::vector{file}, with(Verbosity::kNormal));
    EXPECT_NE(junit.find("message=\"&lt;a &amp; &quot;b&quot;&gt;????? \xc3\xa9\""), std::string::npos) << junit;
    EXPECT_NE(junit.find("<testsuite name=\"a&#10;b.dgm\" tests=\"4\" failures=\"1\" errors=\"0\" skipped=\"1\">"),
              std::string::npos)
        << junit;
}

TEST(ValidationOutput, SarifNamesFilesAndLines) {
    FileValidation file = sample_file();
    file.path = "some dir/\xc3\xa9.dgm";
    file.findings.push_back({&codes::kNoFaces, Severity::kNote, "line", "in/a b.obj:12:7", {}, {}});
    OutputOptions options = with(Verbosity::kNormal);
    const auto json = nlohmann::json::parse(to_sarif(std::vector{file}, options));
    const auto& run = json["runs"][0];
    const auto& results = run["results"];
    ASSERT_EQ(results.size(), 3u);
    EXPECT_EQ(results[0]["locations"][0]["physicalLocation"]["artifactLocation"]["uri"], "some%20dir/%C3%A9.dgm");
    EXPECT_EQ(results[0]["locations"][0]["logicalLocations"][0]["fullyQualifiedName"], "/charts/0/geometry");
    EXPECT_EQ(results[2]["locations"][0]["physicalLocation"]["artifactLocation"]["uri"], "in/a%20b.obj");
    EXPECT_EQ(results[2]["locations"][0]["physicalLocation"]["region"].dump(), R"({"startColumn":7,"startLine":12})");
    EXPECT_EQ(results[0]["locations"][0]["physicalLocation"]["region"].dump(), R"({"startLine":1})");
    EXPECT_EQ(results[2]["level"], "note");
    EXPECT_FALSE(run["tool"]["driver"].contains("informationUri"));
    for (const auto& result : results)
        EXPECT_EQ(run["tool"]["driver"]["rules"][result["ruleIndex"].get<std::size_t>()]["id"], result["ruleId"]);
    EXPECT_FALSE(results[0].contains("baselineState"));
    options.has_baseline = true;
    options.homepage = "https://example.org/dgm";
    const auto again = nlohmann::json::parse(to_sarif(std::vector{file}, options))["runs"][0];
    EXPECT_EQ(again["results"][0]["baselineState"], "new");
    EXPECT_EQ(again["tool"]["driver"]["informationUri"], "https://example.org/dgm");
}

TEST(ValidationOutput, CodesAreFoundByAnyOfTheirNames) {
    for (const char* name : {"DGM1003", "dgm1003", "1003", "HASH_MISMATCH", "DGM1003_HASH_MISMATCH"})
        EXPECT_EQ(find_code(name), &codes::kHashMismatch) << name;
    for (const char* name : {"", "DGM", "100", "DGM10033", "HASH"}) EXPECT_EQ(find_code(name), nullptr) << name;
    EXPECT_EQ(explain(codes::kHashMismatch),
              "DGM1003 HASH_MISMATCH (container and index)\n"
              "  what: stored bytes differ from their hash\n"
              "  why:  a damaged file still opens and still draws, only wrongly\n"
              "  next: the file was changed after the bake: bake it again, or, if you painted its layers, use dgm-edit "
              "--repair\n"
              "  exit: 3\n");
}

TEST(ValidationOutput, EveryCodeSaysWhatWhyAndWhatToDo) {
    for (const model::Code* code : model::codes::kAll)
        for (const char* text : {code->title, code->why, code->hint}) {
            ASSERT_NE(text, nullptr) << code->number;
            const std::string_view view(text);
            EXPECT_GT(view.size(), 8u) << code->number;
            EXPECT_EQ(view.find_first_of("|\n"), std::string_view::npos) << code->number << " breaks the table";
            EXPECT_NE(view.back(), '.') << code->number;
        }
}

/// Numbers are never used twice and stand in the table once.
TEST(ValidationOutput, CodeTableHasNoDoubles) {
    for (const model::Code* a : codes::kAll)
        for (const model::Code* b : codes::kAll) {
            if (a == b) continue;
            EXPECT_NE(a->number, b->number);
            EXPECT_STRNE(a->name, b->name);
        }
    EXPECT_EQ(find_code("4003"), &codes::kSourceDiffers);
    EXPECT_EQ(find_code("2011"), &codes::kBadReport);
}

}  // namespace
}  // namespace dgm::validate
