// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/side_checks.cpp
#include "validate/side_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <tuple>
#include <vector>

#include "model/codes.h"
#include "model/element.h"
#include "model/octahedral.h"

namespace dgm::validate {
namespace {
using model::element;
using model::Face;
using model::Layer;
using model::Vec3d;
namespace codes = model::codes;

/// An edge of a face between two surface points, the lower one first.
struct Side {
    std::uint32_t low, high;            ///< representatives
    std::uint32_t low_copy, high_copy;  ///< samples as the face names them
    bool forward;                       ///< the face runs from low to high
};

/// Edges of faces with a corner in a weld class, those of one edge of the welded surface side by side.
std::vector<Side> sides_at_seams(const Surface& s) {
    const std::vector<std::uint32_t>& weld = s.reconstruction.weld;
    std::vector<char> in_class(weld.size(), 0);
    for (std::uint32_t v = 0; v < weld.size(); ++v)
        if (weld[v] != v) in_class[v] = in_class[weld[v]] = 1;
    std::vector<Side> out;
    for (const Face& f : s.reconstruction.mesh.faces)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = f[k], b = f[(k + 1) % 3];
            if (!in_class[a] && !in_class[b]) continue;
            const bool forward = weld[a] < weld[b];
            const std::uint32_t low = forward ? a : b, high = forward ? b : a;
            out.push_back({weld[low], weld[high], low, high, forward});
        }
    std::sort(out.begin(), out.end(), [](const Side& a, const Side& b) {
        return std::tie(a.low, a.high, a.low_copy, a.high_copy) < std::tie(b.low, b.high, b.low_copy, b.high_copy);
    });
    return out;
}

std::optional<Vec3d> stored_normal(const Surface& s, std::size_t sample) {
    const bool grid = sample < s.grid();
    const Layer* layer = s.chart.find(grid ? "normal" : "border_normal");
    if (layer == nullptr) return std::nullopt;
    const std::size_t k = 2 * (grid ? sample : sample - s.grid());
    return model::decode_octahedral({element<std::int16_t>(*layer, k), element<std::int16_t>(*layer, k + 1)});
}

}  // namespace

void check_sides(const Surface& s, bool oriented, FindingList& findings) {
    const std::vector<std::uint8_t>& reversed = s.reconstruction.reversed;
    const Layer* layer = s.chart.find("reversed");
    if (layer == nullptr) {
        if (!oriented)
            findings.error(codes::kBadTopology, s.path("geometry"), "neighbouring faces differ in orientation");
        return;
    }
    for (std::size_t k = 0; k < layer->bytes.size(); ++k)
        if (element<std::uint8_t>(*layer, k) > 1) {
            findings.error(codes::kBadReversed, s.path("reversed") + element_text(layer->shape, k),
                           fmt::format("the value is {}, 0 and 1 are possible", element<std::uint8_t>(*layer, k)));
            return;
        }
    const std::vector<Side> sides = sides_at_seams(s);
    std::size_t bad = 0, first = 0, edges = 0;
    for (std::size_t k = 0; k + 1 < sides.size(); ++k) {
        const Side &a = sides[k], &b = sides[k + 1];
        if (a.low != b.low || a.high != b.high) continue;
        ++edges;
        const bool against = a.forward == b.forward;
        const bool told_low = reversed[a.low_copy] != reversed[b.low_copy],
                   told_high = reversed[a.high_copy] != reversed[b.high_copy];
        if ((told_low != against || told_high != against) && bad++ == 0)
            first = told_low != against ? b.low_copy : b.high_copy;
        ++k;  // an edge of more faces is reported with the topology
    }
    if (bad > 0)
        findings.error(
            codes::kBadReversed, s.path("reversed"),
            fmt::format("the faces at {} wind otherwise than the layer says; so they do along {} of {} edges "
                        "at seams",
                        s.sample_text(first), bad, edges),
            {static_cast<double>(bad), 0});
}

bool opposite_normals(const Surface& s, std::size_t a, std::size_t b) {
    constexpr double kRounding = 1e-6;  // of the decoder; codes are 3e-5 apart
    const std::optional<Vec3d> one = stored_normal(s, a), other = stored_normal(s, b);
    return !one || !other || length(*one + *other) < kRounding;
}

}  // namespace dgm::validate
