// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/page/page_bare_test.cpp
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "model/codes.h"
#include "model/error.h"
#include "page/page_file.h"

namespace dgm::page {
namespace {

TEST(PageWithoutModule, IsRefusedWithWhatToInstall) {
    EXPECT_FALSE(can_make_pages());
    try {
        static_cast<void>(page_file({}, {}, "never-written.dgm"));
        FAIL() << "a page without a runtime";
    } catch (const model::Error& error) {
        EXPECT_EQ(&error.code(), &model::codes::kUnsupported);
        EXPECT_NE(std::string(error.hint()).find("-DDGM_PAGE=ON"), std::string::npos);
    }
    EXPECT_FALSE(std::filesystem::exists("never-written.dgm"));
}

}  // namespace
}  // namespace dgm::page
