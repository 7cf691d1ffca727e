// SPDX-License-Identifier: GPL-3.0-or-later
#include "report/html.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

namespace dgm::report {
namespace {

TEST(Html, NothingOfATextBecomesMarkup) {
    EXPECT_EQ(escaped("<script>alert('x & \"y\"')</script>"),
              "&lt;script&gt;alert(&#39;x &amp; &quot;y&quot;&#39;)&lt;/script&gt;");
    EXPECT_EQ(escaped("a\x1b[2J\tb\nc\x7f"), "a\\x1b[2J\\x09b\nc\\x7f");
    EXPECT_EQ(escaped("Magen \xc3\xa4\xff.obj"), "Magen \xc3\xa4\xef\xbf\xbd.obj");
}

TEST(Html, JsonCannotEndItsScript) {
    const nlohmann::json value{{"</script><!--", "<b>&\u2028 \xc3\xa4"}};
    const std::string text = script_json(value);
    EXPECT_EQ(text.find_first_of("<>&"), std::string::npos) << text;
    for (const char c : text) EXPECT_LT(static_cast<unsigned char>(c), 0x80);
    EXPECT_EQ(nlohmann::json::parse(text), value);
}

TEST(Html, LinksHoldAnyName) {
    EXPECT_EQ(link_segment("a b#1%?\xc3\xa4.html"), "a%20b%231%25%3F%C3%A4.html");
}

TEST(Html, AttributesKeepPages) {
    EXPECT_EQ(attribute_value("<a href=\"x&amp;y\">'\n"), "<a href=&quot;x&amp;amp;y&quot;>'\n");
}

TEST(Html, PicturesAreWhatTheirTypeSays) {
    formats::Image noise{64, 64, {}};
    std::uint32_t state = 1;
    for (int k = 0; k < 64 * 64; ++k) {
        state = state * 1664525 + 1013904223;
        noise.pixels.push_back(
            {static_cast<std::uint8_t>(state >> 24), static_cast<std::uint8_t>(state >> 16), 0, 255});
    }
    EXPECT_TRUE(photo_uri(noise, 80).starts_with("data:image/jpeg;base64,/9j/"));  // FF D8 FF
    EXPECT_TRUE(picture_uri(noise, 1'000'000).starts_with("data:image/png;base64,iVBORw0KGgo"));
    EXPECT_TRUE(picture_uri(noise, 100).starts_with("data:image/jpeg;base64,"));
    EXPECT_EQ(photo_uri(noise, 80), photo_uri(noise, 80));
}

TEST(Html, Numbers) {
    EXPECT_EQ(number_text(0.0123456), "0.0123");
    EXPECT_EQ(number_text(std::numeric_limits<double>::quiet_NaN()), "unknown");
    EXPECT_EQ(length_text(0.5, 200), "0.5 (0.25 %)");
    EXPECT_EQ(length_text(0.5, 0), "0.5");
    EXPECT_EQ(counted(1, "chart"), "1 chart");
    EXPECT_EQ(counted(0, "chart"), "0 charts");
}

}  // namespace
}  // namespace dgm::report
