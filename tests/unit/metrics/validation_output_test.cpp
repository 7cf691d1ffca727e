// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/metrics/validation_output_test.cpp
// Texts and JSON, character by character where other programs read them.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "model/codes.h"
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

TEST(ValidationOutput, Text) {
    const std::string error =
        "DGM2004 error: a?b.dgm: /charts/0/geometry: samples differ?[2J (measured 0.25, limit 0) — " +
        std::string(codes::kSeamGap.hint) + "\n";
    const std::string warning =
        "DGM2011 warning: a?b.dgm: /report: no report — " + std::string(codes::kBadReport.hint) + "\n";
    EXPECT_EQ(to_text(sample_file(), Verbosity::kNormal), error + warning + "a?b.dgm: 1 error, 1 warning (1 chart)\n");
    EXPECT_EQ(to_text(sample_file(), Verbosity::kQuiet), error);
    FileValidation good;
    good.path = "good.dgm";
    good.charts = 3;
    EXPECT_EQ(to_text(good, Verbosity::kNormal), "good.dgm: ok (3 charts)\n");
    EXPECT_EQ(to_text(good, Verbosity::kQuiet), "");
    good.error = bake::SurfaceError{};
    good.error->rms = 0.5;
    good.error->diagonal = 50;
    EXPECT_EQ(to_text(good, Verbosity::kVerbose),
              "good.dgm: rms 0.5, hausdorff 0, psnr 40.00 dB, normals 0 degrees, 0 samples\ngood.dgm: ok (3 charts)\n");
}

TEST(ValidationOutput, JsonKeepsKeyOrderAndShortNumbers) {
    FileValidation file = sample_file();
    file.findings[0].message = "bad byte \xff";
    file.findings[0].measured = 0.1;
    file.error = bake::SurfaceError{};
    file.error->diagonal = 2;
    const std::string text = to_json(std::vector{file, FileValidation{}});
    EXPECT_NE(text.find("\"measured\": 0.1,\n"), std::string::npos) << text;
    EXPECT_EQ(text.back(), '\n');

    const auto json = nlohmann::ordered_json::parse(text);
    ASSERT_EQ(json.size(), 2u);
    const auto keys = [](const auto& object) {
        std::string list;
        for (const auto& item : object.items()) list += item.key() + " ";
        return list;
    };
    EXPECT_EQ(keys(json[0]), "file exit_code charts error turned_faces findings ");
    EXPECT_EQ(keys(json[0]["findings"][0]), "code name severity place message measured limit hint ");
    EXPECT_EQ(json[0]["file"], "a\nb.dgm");
    EXPECT_EQ(json[0]["exit_code"], 3);
    EXPECT_EQ(json[0]["error"]["psnr"], 300);
    EXPECT_EQ(json[0]["findings"][0]["code"], "DGM2004");
    EXPECT_EQ(json[0]["findings"][0]["name"], "SEAM_GAP");
    EXPECT_EQ(json[0]["findings"][0]["message"], "bad byte \xef\xbf\xbd");
    EXPECT_TRUE(json[0]["findings"][1]["limit"].is_null());
    EXPECT_EQ(json[1]["exit_code"], 0);
    EXPECT_TRUE(json[1]["findings"].empty());
}

TEST(ValidationOutput, CodesAreFoundByAnyOfTheirNames) {
    for (const char* name : {"DGM1003", "dgm1003", "1003", "HASH_MISMATCH", "DGM1003_HASH_MISMATCH"})
        EXPECT_EQ(find_code(name), &codes::kHashMismatch) << name;
    for (const char* name : {"", "DGM", "100", "DGM10033", "HASH"}) EXPECT_EQ(find_code(name), nullptr) << name;
    EXPECT_EQ(explain(codes::kHashMismatch),
              "DGM1003 HASH_MISMATCH\n  stored bytes differ from their hash\n  hint: the file "
              "was damaged after the bake; bake it again\n  exit code: 3\n");
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
