// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/opened.h
#pragma once
#include <gtest/gtest.h>

#include <dgm/asset.h>
#include <dgm/deform.h>
#include <dgm/state.h>

#include "dgm_builder.h"

namespace dgm::test {

/// An asset over bytes it keeps.
struct Opened {
    Bytes bytes;
    Asset asset;
    explicit Opened(Image image, const OpenOptions& options = {})
        : bytes(std::move(image.bytes)), asset(Asset::open_memory(bytes, options).value()) {}
    [[nodiscard]] Chart chart(std::uint32_t k = 0) const { return asset.chart(k).value(); }
};

inline State make_state(const ChartSpec& chart, std::uint32_t max_reach = 65) {
    StateOptions options;
    options.max_reach = max_reach;
    auto state = State::create(Opened(build({chart})).chart(), options);
    EXPECT_TRUE(state.ok()) << state.error().message;
    return std::move(state).value();
}

inline DeformTable make_table(float sigma, std::uint32_t reach, KernelEnd end = KernelEnd::Printed) {
    KernelOptions options;
    options.sigma = sigma;
    options.reach = reach;
    options.end = end;
    return DeformTable::create(options).value();
}

inline bool same_bits(Vec3 a, Vec3 b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

}  // namespace dgm::test
