// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/page/markup_test.cpp
#include "page/markup.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <string>

namespace dgm::page {
namespace {

std::span<const std::byte> bytes(std::string_view text) {
    return std::as_bytes(std::span(text));
}

TEST(Markup, Base64OfRfc4648) {
    const std::pair<const char*, const char*> known[] = {{"", ""},
                                                         {"f", "Zg=="},
                                                         {"fo", "Zm8="},
                                                         {"foo", "Zm9v"},
                                                         {"foob", "Zm9vYg=="},
                                                         {"fooba", "Zm9vYmE="},
                                                         {"foobar", "Zm9vYmFy"},
                                                         {"\xff\xfe", "//4="}};
    for (const auto& [text, coded] : known) EXPECT_EQ(base64(bytes(text)), coded);
}

TEST(Markup, DeflatedComesBack) {
    const std::string text(100000, 'x');
    const std::string small = deflated(bytes(text));
    EXPECT_LT(small.size(), 300U);
    std::string back(text.size(), '\0');
    uLongf size = back.size();
    ASSERT_EQ(uncompress(reinterpret_cast<Bytef*>(back.data()), &size, reinterpret_cast<const Bytef*>(small.data()),
                         small.size()),
              Z_OK);
    EXPECT_EQ(back, text);
}

TEST(Markup, NamesStayNames) {
    EXPECT_EQ(attribute_text("a<b>&\"'"), "a&lt;b&gt;&amp;&quot;&#39;");
    EXPECT_EQ(attribute_text("M\xc3\xa4gen \xf0\x9f\xab\x80"), "M\xc3\xa4gen \xf0\x9f\xab\x80");
    // A lone byte, an overlong form, half a surrogate pair, a cut character, control characters.
    EXPECT_EQ(attribute_text("\xff"), "?");
    EXPECT_EQ(attribute_text("\xc0\xaf"), "??");
    EXPECT_EQ(attribute_text("\xed\xa0\x80"), "???");
    EXPECT_EQ(attribute_text("x\xe2\x82"), "x??");
    EXPECT_EQ(attribute_text("a\nb\x7f"), "a?b?");
}

}  // namespace
}  // namespace dgm::page
