// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component/component_sizes.cpp
#include "baking/component/component_sizes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace dgm::bake {

GridSize component_size(GridSize full, double area, double largest_area, std::uint32_t least) {
    const double share = largest_area > 0 ? std::sqrt(area / largest_area) : 1.0;
    const auto side = [&](std::uint32_t samples) {
        const auto scaled = 1 + static_cast<std::uint32_t>(std::lround((samples - 1) * share));
        return std::clamp(scaled, std::min(least, samples), samples);
    };
    return {side(full.rows), side(full.cols)};
}

std::vector<GridSize> component_sizes(std::span<const GridSize> full, std::span<const double> areas,
                                      std::size_t largest) {
    constexpr std::uint64_t kMost = 7;               // times the samples of the largest ...
    constexpr std::uint64_t kMostOfSmall = 10;       // ... or so many, as long as that is ...
    constexpr std::uint64_t kFew = 460'000;          // ... this much, which is baked within a minute
    constexpr std::uint64_t kMostOfLeast = 425'000;  // samples, if all grids are the least
    constexpr int kHalvings = 24;
    std::vector<GridSize> out(areas.size());
    const std::uint64_t of_largest = std::uint64_t{full[largest].rows} * full[largest].cols;
    const std::uint64_t most = std::max(kMost * of_largest, std::min(kMostOfSmall * of_largest, kFew));
    const std::uint64_t of_least = std::uint64_t{kLeastSide} * kLeastSide * areas.size();
    const std::uint32_t least = of_least > std::max(most, kMostOfLeast) ? kLeastSideOfMany : kLeastSide;
    const auto samples_at = [&](double share) {  // of the area of all but the largest
        std::uint64_t sum = 0;
        for (std::size_t c = 0; c < areas.size(); ++c) {
            out[c] = component_size(full[c], c == largest ? areas[c] : share * areas[c], areas[largest], least);
            sum += std::uint64_t{out[c].rows} * out[c].cols;
        }
        return sum;
    };
    if (samples_at(1) <= most) return out;
    double low = 0, high = 1;
    for (int k = 0; k < kHalvings; ++k) {
        const double middle = 0.5 * (low + high);
        (samples_at(middle) <= most ? low : high) = middle;
    }
    samples_at(low);
    return out;
}

}  // namespace dgm::bake
