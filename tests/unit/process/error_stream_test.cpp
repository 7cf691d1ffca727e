// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/process/error_stream_test.cpp
#include "process/error_stream.h"

#include <gtest/gtest.h>

#include "model/codes.h"

namespace dgm::bake {
namespace {

TEST(ErrorStream, AnErrorComesBackWhole) {
    const std::string bytes =
        encode_error(model::Error(model::codes::kNoFaces, "no \xff faces", "a.obj:3:1").with_hint("look"));
    try {
        throw_sent_error(bytes);
        FAIL();
    } catch (const model::Error& error) {
        EXPECT_EQ(&error.code(), &model::codes::kNoFaces);
        EXPECT_STREQ(error.what(), "no \xff faces");
        EXPECT_EQ(error.place(), "a.obj:3:1");
        EXPECT_STREQ(error.hint(), "look");
    }
}

TEST(ErrorStream, OtherMessagesAreNone) {
    for (const char* other : {"", "M", "XE", "H."}) EXPECT_NO_THROW(throw_sent_error(other)) << other;
}

TEST(ErrorStream, DamagedOnesAreErrorsToo) {
    const std::string bytes = encode_error(model::Error(model::codes::kNoFaces, "no faces", "a.obj"));
    for (std::size_t size = 1; size < bytes.size(); ++size)
        EXPECT_THROW(throw_sent_error(std::string_view(bytes).substr(0, size)), model::Error) << size;
    std::string unknown = bytes;
    unknown[1] = unknown[2] = '\x7f';
    try {
        throw_sent_error(unknown);
        FAIL();
    } catch (const model::Error& error) { EXPECT_EQ(&error.code(), &model::codes::kInternal); }
}

}  // namespace
}  // namespace dgm::bake
