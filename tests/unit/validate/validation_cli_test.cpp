// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/validate/validation_cli_test.cpp
// dgm-validate as a shell sees it: exit code, stdout, stderr.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "dgm/dgm_writer.h"
#include "support/temp_folder.h"
#include "validation_maps.h"

namespace dgm::validate {
namespace {
namespace fs = std::filesystem;

struct Outcome {
    int exit_code = -1;
    std::string out, err;
};

class ValidateCommand : public testing::Test {
 protected:
    void SetUp() override {
        good_ = (folder_ / "good.dgm").string();
        torn_ = (folder_ / "torn.dgm").string();
        model::MapSet maps = test::good_maps();
        formats::write_dgm(maps, good_);
        test::poke<float>(*maps.charts[0].find("geometry"), 3 * (4 * test::kTubeCols + 10), 0.4999f);
        formats::write_dgm(maps, torn_);
    }
    [[nodiscard]] Outcome run(const std::string& arguments, const std::string& redirect = {}) const {
        const fs::path out = folder_ / "out.txt", err = folder_ / "err.txt";
        const std::string to = redirect.empty() ? out.string() : redirect;
        const int status = std::system((DGM_VALIDATE " " + arguments + " >" + to + " 2>" + err.string()).c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(out), text_of(err)};
    }
    static std::string text_of(const fs::path& file) {
        std::ifstream stream(file);
        return {std::istreambuf_iterator<char>(stream), {}};
    }
    const test::TempFolder scratch_;
    const fs::path& folder_ = scratch_.path();
    std::string good_, torn_;
};

TEST_F(ValidateCommand, WorstOfTheFilesDecides) {
    Outcome r = run(good_);
    EXPECT_EQ(r.exit_code, 0);
    EXPECT_EQ(r.out, good_ + ": ok (2 charts)\n");
    r = run("-q " + good_ + " " + torn_);
    EXPECT_EQ(r.exit_code, 3);
    EXPECT_EQ(r.out.rfind("DGM2004 error: " + torn_ +
                              ": /charts/0/geometry: sample (4, 10) differs from its mate, "
                              "sample (4, 0)",
                          0),
              0u)
        << r.out;
    r = run(torn_ + " " + (folder_ / "absent.dgm").string() + " " + good_);
    EXPECT_EQ(r.exit_code, 2);
    EXPECT_NE(r.out.find("DGM5001 error: "), std::string::npos);
    EXPECT_NE(r.out.find(good_ + ": ok"), std::string::npos) << "the files after a bad one are checked too";
    EXPECT_EQ(r.err, "");
}

TEST_F(ValidateCommand, JsonListsTheFilesInOrder) {
    const Outcome r = run("--format json " + torn_ + " " + good_);
    EXPECT_EQ(r.exit_code, 3);
    const auto json = nlohmann::json::parse(r.out);
    const auto& files = json["files"];
    ASSERT_EQ(files.size(), 2u);
    EXPECT_EQ(files[0]["findings"][0]["code"], "DGM2004");
    EXPECT_EQ(files[1]["file"], good_);
    EXPECT_TRUE(files[1]["findings"].empty());
}

TEST_F(ValidateCommand, UsageErrorsAreOne) {
    for (const std::string arguments :
         {"", "--format xml x.dgm", "--format markdown x.dgm", "--explain DGM1003 --format markdown",
          "--severity DGM1=off x.dgm", "--severity DGM2004=loud x.dgm", "--report x.xml x.dgm",
          "--baseline a --write-baseline b x.dgm", "--max-issues -1 x.dgm", "--frob x.dgm", "--max-rms 1% x.dgm",
          "--source x.obj --max-rms wide x.dgm", "--source x.obj --max-rms -1 x.dgm", "--explain DGM9999",
          "-q -v x.dgm"}) {
        const Outcome r = run(arguments);
        EXPECT_EQ(r.exit_code, 1) << arguments;
        EXPECT_EQ(r.out, "") << arguments;
        EXPECT_NE(r.err.find("DGM6001"), std::string::npos) << arguments;
    }
}

TEST_F(ValidateCommand, HelpVersionAndExplain) {
    Outcome r = run("--help");
    EXPECT_EQ(r.exit_code, 0);
    EXPECT_NE(r.out.find("--max-hausdorff"), std::string::npos);
    r = run("-V");
    EXPECT_EQ(r.exit_code, 0);
    EXPECT_EQ(r.out.rfind("dgm-validate ", 0), 0u);
    r = run("--explain SEAM_GAP");
    EXPECT_EQ(r.exit_code, 0);
    EXPECT_EQ(r.out.rfind("DGM2004 SEAM_GAP (layers and their values)\n", 0), 0u);
}

TEST_F(ValidateCommand, SourceAndOutputErrors) {
    Outcome r = run("--source " + (folder_ / "absent.obj").string() + " " + good_);
    EXPECT_EQ(r.exit_code, 2);
    EXPECT_NE(r.out.find("absent.obj: there is no such file"), std::string::npos) << r.out;
    EXPECT_NE(r.out.find(good_ + ": ok"), std::string::npos) << "the file is judged without it";

    // A source that is one triangle, a hundred units from the file's tube.
    std::ofstream(folder_ / "far.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    r = run("-q --source " + (folder_ / "far.obj").string() + " " + good_);
    EXPECT_EQ(r.exit_code, 3);
    EXPECT_NE(r.out.find("DGM4001 error: "), std::string::npos);
    EXPECT_NE(r.out.find("DGM4002 error: "), std::string::npos);

    if (fs::exists("/dev/full")) {
        r = run(good_, "/dev/full");
        EXPECT_EQ(r.exit_code, 2);
        EXPECT_NE(r.err.find("DGM5003"), std::string::npos);
    }
}

}  // namespace
}  // namespace dgm::validate
