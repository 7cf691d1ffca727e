// SPDX-License-Identifier: GPL-3.0-or-later
#include "report/report_files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "report/page_job.h"

namespace dgm::report {
namespace {

TEST(ReportFiles, PageNamesAreSafeAndDiffer) {
    EXPECT_EQ(page_name("stomach.obj"), "stomach.obj");
    const std::string deep = page_name("organs/liver.obj"), flat = page_name("organs_liver.obj");
    EXPECT_TRUE(deep.starts_with("organs_liver.obj-")) << deep;
    EXPECT_EQ(flat, "organs_liver.obj");
    EXPECT_EQ(page_name("../../etc/passwd").find('/'), std::string::npos);
    EXPECT_FALSE(page_name("../x").starts_with('.'));
    EXPECT_NE(page_name("a b.obj"), page_name("a_b.obj"));
    EXPECT_NE(page_name("a b.obj"), page_name("a?b.obj"));
    EXPECT_LT(page_name(std::string(5000, 'x')).size(), 140U);
}

TEST(ReportFiles, AHeadIsBelievedWithinBounds) {
    const std::filesystem::path page =
        std::filesystem::temp_directory_path() / ("dgm_head_" + std::to_string(getpid()) + ".html");
    const auto head_of = [&](const std::string& text) {
        std::ofstream(page, std::ios::binary) << text;
        return read_page_head(page);
    };
    PageHead head = head_of(
        "<meta name=\"dgm-page\" content=\"12ab\">\n<meta name=\"dgm-thumbnail\" "
        "content=\"data:image/jpeg;base64,/9j/\">\n<meta name=\"dgm-error-thumbnail\" content=\"http://x\">");
    EXPECT_EQ(head.key, "12ab");
    EXPECT_EQ(head.thumbnail, "data:image/jpeg;base64,/9j/");
    EXPECT_EQ(head.error_thumbnail, "");
    head = head_of("<meta name=\"dgm-thumbnail\" content=\"data:image/jpeg;base64," + std::string(30'000, 'A') + "\">");
    EXPECT_EQ(head.thumbnail, "");
    EXPECT_EQ(head_of("<meta name=\"dgm-page\" content=\"12").key, "");
    std::filesystem::remove(page);
    EXPECT_EQ(read_page_head(page).key, "");
}

TEST(ReportFiles, JobsTravelWhole) {
    PageJob job;
    job.page = {{{"name", "a</b>"}}, "in/a \xff.obj", "out/a.dgm", "dgm-bake 'a \xff.obj'", "12ab", "../index.html"};
    job.output = "out/assets/.a.tmp";
    job.memory_bytes = 1 << 30;
    job.threads = 2;
    const PageJob back = decode_page_job(encode(job));
    EXPECT_EQ(back.page.asset, job.page.asset);
    EXPECT_EQ(back.page.source, job.page.source);
    EXPECT_EQ(back.page.command, job.page.command);
    EXPECT_EQ(back.page.key, job.page.key);
    EXPECT_EQ(back.page.index_link, job.page.index_link);
    EXPECT_EQ(back.output, job.output);
    EXPECT_EQ(back.memory_bytes, job.memory_bytes);
    EXPECT_EQ(back.threads, job.threads);
    EXPECT_ANY_THROW((void)decode_page_job("{}"));
    EXPECT_ANY_THROW((void)decode_page_job("{\"page\":{},\"memory_bytes\":1,\"threads\":1}"));
}

}  // namespace
}  // namespace dgm::report
