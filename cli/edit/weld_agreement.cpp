// SPDX-License-Identifier: GPL-3.0-or-later
// cli/edit/weld_agreement.cpp
#include "edit/weld_agreement.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "geometry/metrics/bump_normals.h"
#include "model/element.h"
#include "model/layer_names.h"

namespace dgm::edit {
namespace {

/// The lowest grid sample of each grid sample's class; border samples of a free chart join grid samples, too.
std::vector<std::uint32_t> sample_classes(const model::Chart& chart) {
    const std::size_t grid = std::size_t{chart.rows} * chart.cols;
    std::vector<std::uint32_t> out(grid);
    std::iota(out.begin(), out.end(), 0u);
    const model::Layer* seams = chart.find(model::layers::kSeams);
    if (seams == nullptr) return out;
    std::map<std::uint32_t, std::uint32_t> lowest;  // of each representative
    for (std::size_t k = 0; k < seams->bytes.size() / sizeof(std::uint32_t); k += 2) {
        const auto representative = model::element<std::uint32_t>(*seams, k);
        for (const std::uint32_t sample : {representative, model::element<std::uint32_t>(*seams, k + 1)})
            if (sample < grid) out[sample] = lowest.try_emplace(representative, sample).first->second;
    }
    return out;
}

}  // namespace

std::vector<std::uint32_t> seam_classes(const model::Chart& chart, std::uint32_t rows, std::uint32_t cols) {
    if (rows == chart.rows && cols == chart.cols) return sample_classes(chart);
    return bake::texel_classes(chart.rows, chart.cols, rows, cols, sample_classes(chart));
}

SeamSamples samples_with_copies(std::span<const std::uint32_t> classes, std::span<const char> changed) {
    std::vector<char> has_copy(classes.size(), 0);
    for (std::uint32_t s = 0; s < classes.size(); ++s)
        if (classes[s] != s) has_copy[classes[s]] = has_copy[s] = 1;
    SeamSamples out;
    for (std::uint32_t s = 0; s < classes.size(); ++s) {
        if (has_copy[s] == 0) continue;
        out.samples.push_back(s);
        out.classes.push_back(classes[s]);
        out.changed.push_back(changed[s]);
    }
    return out;
}

std::vector<Agreement> agree(std::span<const std::uint32_t> classes, std::span<const char> changed,
                             std::span<const double> numbers, std::uint32_t count, bool averages) {
    struct Sum {
        std::vector<double> value;
        std::uint32_t members = 0;
    };
    std::map<std::uint32_t, Sum> sums;
    const auto number = [&](std::size_t sample, std::uint32_t c) { return numbers[sample * count + c]; };
    for (std::size_t s = 0; s < classes.size(); ++s) {
        if (changed[s] == 0) continue;
        Sum& sum = sums[classes[s]];
        if (sum.members > 0 && !averages) continue;
        if (sum.members++ == 0) sum.value.assign(count, 0.0);
        for (std::uint32_t c = 0; c < count; ++c) sum.value[c] += number(s, c);
    }
    std::vector<Agreement> out;
    for (std::size_t s = 0; s < classes.size(); ++s) {
        const auto found = sums.find(classes[s]);
        if (found == sums.end()) continue;
        Agreement joined{static_cast<std::uint32_t>(s), found->second.value};
        bool differs = false;
        for (std::uint32_t c = 0; c < count; ++c) {
            joined.value[c] /= found->second.members;
            differs = differs || joined.value[c] != number(s, c);
        }
        if (differs) out.push_back(std::move(joined));
    }
    return out;
}

}  // namespace dgm::edit
