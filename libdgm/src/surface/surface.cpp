// SPDX-License-Identifier: MIT
// libdgm/src/surface/surface.cpp
// Builds the welded surface of a chart from its layers.
#include "surface/surface.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "file/validate_impl.h"

namespace dgm::detail {
namespace {

template <class T>
bool copy_in(Array<T>& to, const T* from, std::size_t count, const Allocator& allocator) noexcept {
    if (from == nullptr || count == 0) return true;
    if (!to.allocate(allocator, count)) return false;
    std::memcpy(to.data(), from, count * sizeof(T));
    return true;
}

/// The state keeps its own copy of every table that per-tick code indexes with: the file may change under us.
bool copy_tables(Surface& s, const ChartTables& t) noexcept {
    const Allocator& a = s.allocator;
    const std::size_t border = t.total - t.grid;
    if (!copy_in(s.mask, t.mask, t.grid, a) ||
        !copy_in(s.diagonals, t.diagonals, std::size_t{t.rows - 1} * (t.cols - 1), a) ||
        !copy_in(s.faces, t.faces.data(), t.faces.size(), a) || !copy_in(s.border_uv, t.border_uv, 2 * border, a))
        return false;
    for (std::size_t k = 0; k < t.material.size(); ++k) s.material[k] = load_once(t.material.data() + k);
    s.tables = t;
    s.tables.geometry = s.tables.border = {};
    s.tables.normal = s.tables.border_normal = nullptr;
    s.tables.deformation = s.tables.contact = nullptr;
    s.tables.material = {};
    s.tables.mask = s.mask.data();
    s.tables.diagonals = s.diagonals.data();
    s.tables.border_uv = s.border_uv.data();
    s.tables.faces = {s.faces.data(), s.faces.size()};
    return true;
}

/// Floats from one plane to the next: 448 bytes beyond a multiple of 4096, so that the planes are spread over the
/// page and rows of one plane end on a cache line of their own.
std::uint64_t plane_floats(std::uint64_t total) noexcept {
    return (total + 1023) / 1024 * 1024 + 112;
}

/// Checked before, but the file may have been overwritten since: the kept values are bounded in any case.
bool copy_positions(Surface& s, const ChartTables& t) noexcept {
    s.plane = static_cast<std::size_t>(plane_floats(t.total));
    if (!s.planes.allocate(s.allocator, 16 * std::uint64_t{s.plane})) return false;
    std::size_t next = 0;
    for (Planes* p : {&s.rest, &s.base, &s.now, &s.normal, &s.rest_normal}) {
        p->x = s.planes.data() + next;
        p->y = p->x + s.plane;
        p->z = p->y + s.plane;
        next += 3 * s.plane;
    }
    s.rough = s.planes.data() + next;
    for (std::uint32_t k = 0; k < t.total; ++k) {
        Vec3 p = t.position(k);
        if (!is_place(p)) p = {};  // off the surface
        s.rest.x[k] = p.x;
        s.rest.y[k] = p.y;
        s.rest.z[k] = p.z;
    }
    return true;
}

/// Copies hold the bits of their representative, as in the file that was checked.
void weld_positions(Surface& s) noexcept {
    for (std::uint32_t id = 0; id < s.class_count; ++id)
        for (const std::uint32_t copy : s.members(id)) {
            const Vec3 p = Surface::at(s.rest, s.members(id)[0]);
            s.rest.x[copy] = p.x;
            s.rest.y[copy] = p.y;
            s.rest.z[copy] = p.z;
        }
    std::memcpy(s.base.x, s.rest.x, 3 * s.plane * sizeof(float));
    std::memcpy(s.now.x, s.rest.x, 3 * s.plane * sizeof(float));
}

/// Border faces of each sample, as offsets into one list.
bool index_faces(Surface& s) noexcept {
    if (s.faces.empty()) return true;
    if (!s.face_start.allocate(s.allocator, std::uint64_t{s.total()} + 2) ||
        !s.face_of.allocate(s.allocator, s.faces.size()))
        return false;
    for (const std::uint32_t v : s.faces) ++s.face_start[v + 2];
    for (std::size_t v = 2; v < s.face_start.size(); ++v) s.face_start[v] += s.face_start[v - 1];
    for (std::size_t k = 0; k < s.faces.size(); ++k)
        s.face_of[s.face_start[s.faces[k] + 1]++] = static_cast<std::uint32_t>(k / 3);
    return true;
}

/// The last element of a layer [m][n][width]; nothing is kept if all are 1.
Result<void> copy_share(Surface& s, const float* layer, std::uint64_t offset, std::size_t width,
                        Array<float>& to) noexcept {
    if (layer == nullptr) return {};
    if (!to.allocate(s.allocator, s.tables.grid, 1.0f)) return kNoStateMemory;
    bool all_one = true;
    for (std::size_t k = 0; k < s.tables.grid; ++k) {
        if (!s.tables.on_surface(static_cast<std::uint32_t>(k))) continue;
        const std::size_t at = width * k + width - 1;
        const float v = load_once(layer + at);
        if (!is_behaviour(3, v))
            return Error{ErrorCode::BadValue, offset + 4 * at, "stiffness or mobility is not in 0..1"};
        to[k] = v;
        all_one = all_one && v == 1;
    }
    if (all_one) to = Array<float>{};
    return {};
}

/// Copies of a class take the values of their representative.
void weld_share(const Surface& s, Array<float>& values) noexcept {
    if (values.empty()) return;
    for (std::uint32_t id = 0; id < s.class_count; ++id) {
        const auto members = s.members(id);
        const float v = members[0] < s.tables.grid ? values[members[0]] : 1;
        for (const std::uint32_t copy : members)
            if (copy < s.tables.grid) values[copy] = v;
    }
}

Result<void> copy_behaviour(Surface& s, const ChartTables& t) noexcept {
    if (auto r = copy_share(s, t.deformation, t.deformation_offset, 4, s.stiffness); !r) return r;
    if (auto r = copy_share(s, t.contact, t.contact_offset, 2, s.mobility); !r) return r;
    weld_share(s, s.stiffness);
    weld_share(s, s.mobility);
    return {};
}
}  // namespace

bool is_finite(Vec3 v) noexcept {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool is_place(Vec3 v) noexcept {
    return std::fabs(v.x) <= kMaxCoordinate && std::fabs(v.y) <= kMaxCoordinate && std::fabs(v.z) <= kMaxCoordinate;
}

std::uint64_t surface_bytes(const ChartTables& t) noexcept {
    const std::uint64_t tiles = (std::uint64_t{tile_count(t.rows - 1)} * tile_count(t.cols - 1));
    // A sample: mask, diagonal, ring, stiffness and mobility, class and links, changes.
    return 16 * plane_floats(t.total) * sizeof(float) + std::uint64_t{t.total} * (3 + 8 + 8 + 4) +
           tiles * (4 * sizeof(Box) + 32 + 9 * 8) + 2 * (std::uint64_t{t.rows} + t.cols) * 8 + (t.total - t.grid) +
           t.faces.size() * 40 + t.seams.size() * 80 + (t.reversed != nullptr ? t.total : 0) +
           (t.rows + t.cols) * std::uint64_t{128};
}

Result<void> fill_surface(Surface& s, const ChartTables& t, bool plain_loops) noexcept {
    s.rows_of = &choose_rows(plain_loops);
    // Tables first, values after: the checked values are the kept ones.
    ChartTables own = t;
    if (!copy_tables(s, t)) return kNoStateMemory;
    own.mask = s.tables.mask;
    own.diagonals = s.tables.diagonals;
    own.border_uv = s.tables.border_uv;
    own.faces = s.tables.faces;
    Array<std::uint32_t> seams;
    if (!copy_in(seams, t.seams.data(), t.seams.size(), s.allocator)) return kNoStateMemory;
    own.material = {s.material, t.material.size()};
    own.seams = s.tables.seams = {seams.data(), seams.size()};
    if (auto r = check_values(own, s.allocator); !r) return r;
    if (!copy_positions(s, own) || !index_faces(s)) return kNoStateMemory;
    if (auto r = build_classes(s); !r) return r;
    weld_positions(s);
    if (auto r = build_links(s); !r) return r;
    s.tables.seams = {};
    s.tables.reversed = nullptr;
    if (auto r = copy_behaviour(s, own); !r) return r;
    if (auto r = build_rings(s); !r) return r;
    if (auto r = build_pyramid(s); !r) return r;
    // Distances depend on the rest normals: the same bits whatever the processor.
    const NormalLoops quickest = std::exchange(s.normals_of, kPlainRows.normals);
    update_normals(s);
    std::memcpy(s.rest_normal.x, s.normal.x, 3 * s.plane * sizeof(float));
    s.normals_of = quickest;
    s.all_moved();
    update_normals(s);
    measure_roughness(s);
    s.changes.bring_up();  // all that, before any reader's first look
    for (std::uint32_t k = 0; k < s.total() && s.any_sample == kNone; ++k)
        if (s.usable(k)) s.any_sample = k;
    auto closed = find_rim(s);
    if (!closed) return closed.error();
    s.open_surface = !closed.value();
    // A file may mark copies whose faces do not wind so. Their normals are opposite all the same: a bulge along them
    // would tear the class, and there is no inside to keep the volume of.
    for (std::uint32_t k = 0; k < s.reversed.size(); ++k) s.open_surface = s.open_surface || s.is_reversed(k);
    return {};
}

std::uint32_t Surface::tile_of(std::uint32_t s) const noexcept {
    std::uint32_t i = 0, j = 0;
    if (s < tables.grid) {
        i = s / tables.cols;
        j = s % tables.cols;
    } else {
        const Place p = place(s);  // 0 .. rows - 1, checked
        i = static_cast<std::uint32_t>(p.x);
        j = static_cast<std::uint32_t>(p.y);
    }
    return owner(i, tile_rows) * tile_cols + owner(j, tile_cols);
}

Rect Surface::tile_rect(std::uint32_t tile) const noexcept {
    const std::uint32_t ti = tile / tile_cols, tj = tile % tile_cols;
    return {ti * kTileQuads, ti + 1 == tile_rows ? tables.rows - 1 : ti * kTileQuads + kTileQuads - 1, tj * kTileQuads,
            tj + 1 == tile_cols ? tables.cols - 1 : tj * kTileQuads + kTileQuads - 1};
}

Rect Surface::window(std::uint32_t sample, std::uint32_t b) const noexcept {
    const std::uint32_t i = sample / tables.cols, j = sample % tables.cols, r = b - 1;
    return {i > r ? i - r : 0, std::min(i + r, tables.rows - 1), j > r ? j - r : 0, std::min(j + r, tables.cols - 1)};
}

void Surface::all_moved() noexcept {
    RectList everything;
    everything.add(whole());
    if (total() > tables.grid) {
        everything.add_border(tables.grid);
        everything.add_border(total() - 1);
    }
    changes.note(everything);
    now_boxes.dirty.add(everything);
    base_boxes.dirty.add(everything);
    normal_dirty.add(everything);
}

}  // namespace dgm::detail
