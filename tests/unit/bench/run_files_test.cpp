// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/run_files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/compare.h"
#include "bench/machine_facts.h"
#include "model/error.h"
#include "tables.h"

namespace dgm::bench {
namespace {

Run sample() {
    Run run = test::run_of({{{"a,\"b\"", exactly(0.1), test::times({2, 2, 2})}},
                            {{"</script><b>", exactly(std::nan("")), std::monostate()}},
                            {{"c", exactly(0.2), test::times({5})}}});
    run.findings = {"</script> is only text"};
    return run;
}

TEST(RunFiles, CsvQuotesAndSpreads) {
    const Figure f = test::times({2, 2, 2});
    const std::string csv = to_csv(sample().tables[0]);
    EXPECT_EQ(csv.substr(0, csv.find('\n')), "name,rms,seconds,seconds_low,seconds_high,seconds_n");
    EXPECT_NE(csv.find("\"a,\"\"b\"\"\",0.1,2,"), std::string::npos);
    EXPECT_NE(csv.find("\n</script><b>,,,,,\n"), std::string::npos);
    EXPECT_NE(csv.find("\nc,0.2,5,5,5,1\n"), std::string::npos);
    EXPECT_GT(f.high, 2);
}

TEST(RunFiles, JsonComesBack) {
    const bench::Run run = sample(), back = run_from_json(to_json(run));
    ASSERT_EQ(back.tables.size(), 1U);
    EXPECT_EQ(back.machine, run.machine);
    EXPECT_EQ(to_csv(back.tables[0]), to_csv(run.tables[0]));
    EXPECT_EQ(compare_runs(run, back).size(), 1U) << "a run differs from itself";
}

TEST(RunFiles, OtherJsonIsRefused) {
    for (const char* text : {"", "[]", "{}", "{\"tool\":\"dgm-bench\",\"format\":99}",
                             "{\"tool\":\"dgm-bench\",\"format\":1,\"command\":\"bake\"}"})
        EXPECT_THROW((void)run_from_json(text), model::Error) << text;
}

TEST(RunFiles, PageIsSelfContainedAndWhole) {
    const std::string page = to_html(sample());
    EXPECT_LT(page.size(), std::size_t{2} << 20);
    EXPECT_EQ(page.find("@DATA@"), std::string::npos);
    EXPECT_EQ(page.find(" src="), std::string::npos);
    EXPECT_EQ(page.find("<link rel=\"stylesheet"), std::string::npos);
    // Names cannot end the script that holds them.
    const std::size_t from = page.find("id=\"run\">") + 9, to = page.find("</script>", from);
    const auto data = nlohmann::json::parse(page.substr(from, to - from));
    EXPECT_EQ(data["tables"][0]["rows"][1][0], "</script><b>");
    EXPECT_EQ(data["tables"][0]["plots"][0]["pareto_rows"][""], nlohmann::json::parse("[0]"));
}

TEST(RunFiles, MachineFactsNameNoHost) {
    const Pairs facts = machine_facts();
    char host[256] = {};
    ASSERT_EQ(gethostname(host, sizeof host - 1), 0);
    for (const auto& [key, value] : facts) {
        EXPECT_FALSE(value.empty()) << key;
        EXPECT_NE(value, std::string(host)) << key;
    }
    EXPECT_TRUE(same_hardware(facts, facts));
}

}  // namespace
}  // namespace dgm::bench
