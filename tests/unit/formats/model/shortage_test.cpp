// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/model/shortage_test.cpp
#include "model/shortage.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace dgm::model {
namespace {

TEST(Shortage, LibrariesRunShortForNow) {
    EXPECT_EQ(&error_of(std::bad_alloc()).code(), &codes::kSystemBusy);
    const auto system = [](std::errc what) { return error_of(std::system_error(std::make_error_code(what))); };
    EXPECT_EQ(&system(std::errc::resource_unavailable_try_again).code(), &codes::kSystemBusy);
    EXPECT_EQ(&system(std::errc::too_many_files_open).code(), &codes::kSystemBusy);
    EXPECT_EQ(&system(std::errc::invalid_argument).code(), &codes::kInternal);
    const Error other = error_of(std::out_of_range("vector::_M_range_check"));
    EXPECT_EQ(&other.code(), &codes::kInternal);
    EXPECT_STREQ(other.what(), "vector::_M_range_check");
}

TEST(Shortage, InputsAreNotToBlame) {
    for (const Code* code : {&codes::kSystemBusy, &codes::kIoTrouble, &codes::kWorkerMemory, &codes::kReadFailed})
        EXPECT_TRUE(is_shortage(Error(*code, ""))) << code->name;
    EXPECT_FALSE(may_pass(Error(codes::kReadFailed, "")));
    for (const Code* code : {&codes::kMapInvalid, &codes::kGridTooSmall, &codes::kInternal, &codes::kInterrupted})
        EXPECT_FALSE(is_shortage(Error(*code, ""))) << code->name;
}

}  // namespace
}  // namespace dgm::model
