// SPDX-License-Identifier: MIT
// libdgm/src/surface/nearest.cpp
// The nearest sample of a shape, by its pyramid.
#include <algorithm>
#include <cmath>

#include "surface/descent.h"

namespace dgm::detail {
namespace {

float box_d2(const Box& box, Vec3 tool) noexcept {
    const float x = std::max(std::max(box.low[0] - tool.x, tool.x - box.high[0]), 0.0f);
    const float y = std::max(std::max(box.low[1] - tool.y, tool.y - box.high[1]), 0.0f);
    const float z = std::max(std::max(box.low[2] - tool.z, tool.z - box.high[2]), 0.0f);
    return x * x + y * y + z * z;
}

/// The tile's own samples.
void search_leaf(const Surface& s, const ConstPlanes& p, std::uint32_t tile, Vec3 tool, const Rect* except,
                 Best& best) noexcept {
    const ChartTables& t = s.tables;
    const Rect r = s.tile_rect(tile);
    const auto search = [&](const Rect& part) {
        if (part.empty()) return;
        if (t.mask == nullptr)
            return s.rows_of->nearest({part, t.cols, p, {tool.x, tool.y, tool.z}}, best.d2, best.sample);
        for (std::uint32_t i = part.i0; i <= part.i1; ++i)
            for (std::uint32_t k = i * t.cols + part.j0; k <= i * t.cols + part.j1; ++k)
                if (t.on_surface(k)) best.offer(sample_d2(Surface::at(p, k), tool), k);
    };
    if (except == nullptr || !except->meets(r)) {
        search(r);
    } else {
        const Rect& e = *except;
        const std::uint32_t i0 = std::max(r.i0, e.i0), i1 = std::min(r.i1, e.i1);
        if (r.i0 < e.i0) search({r.i0, e.i0 - 1, r.j0, r.j1});
        if (e.i1 < r.i1) search({e.i1 + 1, r.i1, r.j0, r.j1});
        if (r.j0 < e.j0) search({i0, i1, r.j0, e.j0 - 1});
        if (e.j1 < r.j1) search({i0, i1, e.j1 + 1, r.j1});
    }
    for (std::uint32_t b = s.tile_border_start[tile]; b < s.tile_border_start[tile + 1]; ++b)
        best.offer(sample_d2(Surface::at(p, s.tile_border[b]), tool), s.tile_border[b]);
}
}  // namespace

void search_pyramid(const Surface& s, const Pyramid& p, Vec3 tool, Best& best, const Rect* except) noexcept {
    descend(
        p, [&](const Box& box) { return box_d2(box, tool); }, [&](float d2) { return d2 > best.d2; },
        [&](std::uint32_t tile) { search_leaf(s, p.at, tile, tool, except, best); });
}

}  // namespace dgm::detail
