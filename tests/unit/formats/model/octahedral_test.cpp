// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/model/octahedral_test.cpp
#include <gtest/gtest.h>

#include <limits>

#include "model/octahedral.h"
#include "unit/formats/test_maps.h"

namespace {

using dgm::model::decode_octahedral;
using dgm::model::encode_octahedral;
using dgm::model::OctahedralCode;
using dgm::model::Vec3d;

TEST(Octahedral, AxesAreExact) {
    EXPECT_EQ(encode_octahedral({0, 0, 1}), (OctahedralCode{0, 0}));
    EXPECT_EQ(encode_octahedral({1, 0, 0}), (OctahedralCode{32767, 0}));
    EXPECT_EQ(encode_octahedral({0, -1, 0}), (OctahedralCode{0, -32767}));
    EXPECT_EQ(encode_octahedral({0, 0, -1}), (OctahedralCode{32767, 32767}));
    for (const Vec3d& n : {Vec3d{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}})
        EXPECT_EQ(decode_octahedral(encode_octahedral(n)), n);
}

TEST(Octahedral, ErrorIsBelowFourThousandthsOfADegree) {
    // One step of the square is 1/32767; folding and normalising stretch it by at most sqrt(3), half a step each way.
    dgm::test::Random random(1);
    for (int k = 0; k < 200'000; ++k) {
        const Vec3d n = normalized(Vec3d{random.unit() - 0.5, random.unit() - 0.5, random.unit() - 0.5});
        const Vec3d d = decode_octahedral(encode_octahedral(n));
        EXPECT_NEAR(length(d), 1, 1e-6);
        ASSERT_LT(length(cross(n, d)), 4e-3 * 3.14159265358979 / 180) << n.x << " " << n.y << " " << n.z;
        ASSERT_GT(dot(n, d), 0);
    }
}

TEST(Octahedral, CodesSurviveDecodingAndEncoding) {
    dgm::test::Random random(2);
    const auto check = [](int u, int v) {
        const OctahedralCode code{static_cast<std::int16_t>(u), static_cast<std::int16_t>(v)};
        const Vec3d n = decode_octahedral(code);
        const OctahedralCode again = encode_octahedral(n);
        ASSERT_EQ(encode_octahedral(decode_octahedral(again)), again) << u << " " << v;
        ASSERT_LT(length(decode_octahedral(again) - n), 1e-6) << u << " " << v;
        // Inside the border no two codes share a direction.
        if (std::abs(u) < 32767 && std::abs(v) < 32767) { ASSERT_EQ(again, code); }
    };
    for (int k = 0; k < 300'000; ++k)
        check(static_cast<int>(random.below(65536)) - 32768, static_cast<int>(random.below(65536)) - 32768);
    for (int k = -32768; k < 32768; ++k)
        for (const int edge : {-32768, -32767, -32766, -1, 0, 1, 32766, 32767}) {
            check(k, edge);
            check(edge, k);
        }
    for (int k = -32767; k <= 32767; ++k) check(k, 32767 - std::abs(k));  // the equator
}

TEST(Octahedral, LengthDoesNotMatterAndNonsenseIsUp) {
    const OctahedralCode code = encode_octahedral({1, -2, -3});
    EXPECT_EQ(encode_octahedral({1e300, -2e300, -3e300}), code);
    EXPECT_EQ(encode_octahedral({1e-300, -2e-300, -3e-300}), code);
    EXPECT_EQ(encode_octahedral({0, 0, 0}), (OctahedralCode{0, 0}));
    EXPECT_EQ(encode_octahedral({std::numeric_limits<double>::quiet_NaN(), 0, 1}), (OctahedralCode{0, 0}));
    EXPECT_EQ(encode_octahedral({std::numeric_limits<double>::infinity(), 0, 1}), (OctahedralCode{0, 0}));
}

}  // namespace
