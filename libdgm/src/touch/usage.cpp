// SPDX-License-Identifier: MIT
// libdgm/src/touch/usage.cpp
// Memory of assets and states.
#include <algorithm>

#include "file/asset_impl.h"
#include "touch/state_impl.h"

namespace dgm {
namespace detail {
namespace {

template <class... Arrays>
std::uint64_t bytes_of(const Arrays&... arrays) noexcept {
    return (std::uint64_t{0} + ... + (std::uint64_t{arrays.size()} * sizeof(*arrays.data())));
}

std::uint64_t patch_bytes(const StateImpl& s) noexcept {
    std::uint64_t bytes = 0;
    for (std::uint32_t k = 0; k < s.patch_count; ++k)
        bytes += bytes_of(s.patches[k].cells, s.patches[k].rows, s.patches[k].weight);
    return bytes;
}

/// Rectangles may overlap: never more than there are.
std::uint32_t samples_in(const StateImpl& s, const RectList& list) noexcept {
    std::uint64_t count = 0;
    for (std::uint32_t k = 0; k < list.count; ++k) count += RectList::area(list.rects[k]);
    count = std::min<std::uint64_t>(count, s.tables.grid);
    if (list.border_low <= list.border_high) count += list.border_high - list.border_low + 1;
    return static_cast<std::uint32_t>(count);
}
}  // namespace
}  // namespace detail

AssetUsage Asset::usage() const noexcept {
    const detail::AssetImpl& a = *impl_;
    return {a.file.bytes().size(), sizeof a + detail::bytes_of(a.charts, a.layers)};
}

StateUsage State::usage() const noexcept {
    const detail::StateImpl& s = *settled();
    const detail::FootprintScratch& f = s.footprint;
    const std::uint64_t bytes =
        sizeof s +
        detail::bytes_of(s.planes, s.mask, s.diagonals, s.ring, s.faces, s.border_uv, s.face_start, s.face_of,
                         s.stiffness, s.mobility, s.class_of, s.class_start, s.class_members, s.reversed, s.link_start,
                         s.links, s.tile_flags, s.tile_list, s.next_tiles, s.tile_border_start, s.tile_border,
                         s.tile_face_start, s.tile_faces, s.tile_link_start, s.tile_links, s.changes.cells,
                         s.changes.blocks, s.changes.bands, s.fading.time, s.fading.left, s.fading.plain.tiles,
                         s.fading.special.tiles, s.now_boxes.boxes, s.base_boxes.boxes, s.walk.slot_of, s.walk.nodes,
                         s.walk.heap, s.walk.visited, f.key, f.weight, f.samples, f.classes, f.class_seen,
                         s.geodesic.triangles, s.geodesic.links, s.geodesic.corners, s.geodesic.windows, s.tools,
                         s.patch_scratch.slot_of, s.patch_scratch.flags, s.press.plane, s.press.forms, s.press.saved) +
        detail::patch_bytes(s);
    detail::RectList active = s.elastic;
    detail::add_fading(s, active);
    return {bytes, s.total(), detail::samples_in(s, active), detail::samples_in(s, s.normal_dirty)};
}

}  // namespace dgm
