// SPDX-License-Identifier: MIT
// libdgm/src/surface/surface.h
// The surface of a chart. Coordinates stand in planes (all x, then all y, then all z): deformation and normals stream
// them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include <dgm/grid.h>
#include <dgm/limits.h>
#include <dgm/result.h>

#include "base/inline.h"
#include "base/memory.h"
#include "file/chart_tables.h"
#include "rows/rect_list.h"
#include "rows/rows.h"
#include "surface/changes.h"

namespace dgm::detail {

inline constexpr Error kNoStateMemory{ErrorCode::OutOfMemory, kNoOffset, "no memory for the state"};

struct Box {
    float low[3], high[3];  ///< empty: low = +inf, high = -inf
};

/// From one copy of a seam sample to another: a vector v of the target's chart stands in this chart as
/// (cosine * v.x - sine * v.y, sine * v.x + cosine * v.y).
struct SeamLink {
    std::uint32_t to;
    float cosine, sine;
};

inline constexpr std::uint8_t kTileSpecial = 1;  ///< holds seam samples, a free border or samples off the surface
inline constexpr std::uint8_t kTileListed = 2;   ///< in StateImpl::tile_list; only while one function runs

inline constexpr std::uint8_t kRingCorners = 15;    ///< bit k: corner k of rows.h is in the ring
inline constexpr std::uint8_t kRingIrregular = 16;  ///< normal by ring_normal(): border, seam or free border sample

inline constexpr std::uint8_t kRingRim = 128;  ///< on an open border of the welded surface

inline constexpr std::uint32_t kMaxLevels = 16;  // 8192 leaf tiles a side halve to 1 in 13 steps

/// Boxes over 8 x 8 quads up to one root, over one of the state's shapes.
struct Pyramid {
    Array<Box> boxes;  ///< leaf level first, row-major, up to the root
    std::uint32_t levels = 0;
    std::uint32_t rows[kMaxLevels] = {}, cols[kMaxLevels] = {};
    std::uint32_t start[kMaxLevels] = {};
    ConstPlanes at = {};
    RectList dirty;  ///< moved since the last refit
};

/// The welded surface of one chart: its rest shape, with permanent displacements, and the present one. It does not
/// depend on tools and obstacles.
struct Surface {
    explicit Surface(const Allocator& a) noexcept : allocator(a) {}
    Allocator allocator;
    const RowKernels* rows_of = nullptr;
    NormalLoops normals_of = nullptr;  ///< one for all normals of a state: incremental is full, to the bit
    ChartTables tables;  ///< mask, diagonals, faces and seams point into the arrays below; layer pointers are null
    /// Sixteen planes `plane` floats apart, no two alike modulo 4096 bytes: loads from one must not wait for stores to
    /// another that only look the same to the processor.
    Array<float> planes;
    std::size_t plane = 0;
    Planes rest = {}, base = {}, now = {};  ///< baked, with plastic touches, with elastic ones
    Planes normal = {};                     ///< of `now` but for `normal_dirty`
    Planes rest_normal = {};
    float* rough = nullptr;  ///< mean square of the distances of a sample's rest normal from those of its faces
    float normal_scale = 1;
    float mean_step = 1;
    Array<std::uint8_t> mask, diagonals;
    Array<std::uint8_t> ring;  ///< per grid sample, see kRing*
    bool uniform = false;      ///< every diagonal is 0
    Array<std::uint32_t> faces;
    Array<float> border_uv;
    Array<std::uint32_t> face_start, face_of;  ///< free domain: border faces of each sample
    Array<float> stiffness, mobility;          ///< per grid sample; empty if all are 1
    float material[kMaterialValues] = {};      ///< as limits.h has it; 0, and density 0: not known

    Array<std::uint32_t> class_of, class_start, class_members;
    Array<std::uint32_t> link_start;  ///< by place in class_members
    Array<SeamLink> links;
    std::uint32_t class_count = 0;
    Array<std::uint8_t> reversed;  ///< per sample: its faces wind against those of its representative; empty: nowhere

    std::uint32_t tile_rows = 0, tile_cols = 0;
    Array<std::uint8_t> tile_flags;
    Array<std::uint32_t> tile_list, next_tiles;
    std::uint32_t tile_count_listed = 0;
    Array<std::uint32_t> tile_border_start, tile_border;  ///< border samples of each tile
    /// Border faces by the tile whose leaf holds them, and tiles that hold faces with a corner in this one.
    Array<std::uint32_t> tile_face_start, tile_faces, tile_link_start, tile_links;
    Pyramid now_boxes, base_boxes;
    RectList normal_dirty;             ///< moved since update_normals()
    mutable Changes changes;           ///< of `now` and `normal`, for readers: asking changes nothing else
    std::uint32_t any_sample = kNone;  ///< the first on the surface
    bool any_face = false;             ///< it has a triangle at all
    bool open_surface = true;          ///< some edge of the welded surface has one face, or it has one side

    [[nodiscard]] std::uint32_t total() const noexcept { return tables.total; }
    /// Some window can reach a seam or a free border, so touches need unfolding.
    [[nodiscard]] bool classes_or_border() const noexcept { return class_count != 0 || tables.free_domain; }
    // Always inline: files built for size ask for them in inner loops too.
    [[nodiscard]] DGM_INLINE static Vec3 at(const Planes& p, std::uint32_t s) noexcept {
        return {p.x[s], p.y[s], p.z[s]};
    }
    [[nodiscard]] DGM_INLINE static Vec3 at(const ConstPlanes& p, std::uint32_t s) noexcept {
        return {p.x[s], p.y[s], p.z[s]};
    }
    [[nodiscard]] static ConstPlanes fixed(const Planes& p) noexcept { return {p.x, p.y, p.z}; }
    [[nodiscard]] DGM_INLINE Vec3 point(std::uint32_t s) const noexcept { return at(now, s); }
    [[nodiscard]] bool usable(std::uint32_t s) const noexcept { return s < tables.total && tables.on_surface(s); }
    [[nodiscard]] std::uint32_t class_id(std::uint32_t s) const noexcept {
        return class_of.empty() ? kNone : class_of[s];
    }
    [[nodiscard]] std::span<const std::uint32_t> members(std::uint32_t id) const noexcept {
        return {class_members.data() + class_start[id], class_start[id + 1] - class_start[id]};
    }
    [[nodiscard]] bool is_reversed(std::uint32_t s) const noexcept { return !reversed.empty() && reversed[s] != 0; }
    [[nodiscard]] std::uint32_t representative(std::uint32_t s) const noexcept {
        const std::uint32_t id = class_id(s);
        return id == kNone ? s : class_members[class_start[id]];
    }
    /// (row, column) of a sample in grid steps.
    struct Place {
        float x, y;
    };
    [[nodiscard]] Place place(std::uint32_t s) const noexcept {
        if (s < tables.grid) return {static_cast<float>(s / tables.cols), static_cast<float>(s % tables.cols)};
        const std::size_t b = s - tables.grid;
        return {border_uv[2 * b] * static_cast<float>(tables.rows - 1),
                border_uv[2 * b + 1] * static_cast<float>(tables.cols - 1)};
    }
    /// Leaf tile that owns row (or column) `k`: its quads start there; the last row belongs to the last tile.
    [[nodiscard]] static std::uint32_t owner(std::uint32_t k, std::uint32_t tiles) noexcept {
        const std::uint32_t t = k / kTileQuads;
        return t < tiles ? t : tiles - 1;
    }
    [[nodiscard]] std::uint32_t tile_of(std::uint32_t s) const noexcept;
    /// Its leaf holds border faces.
    [[nodiscard]] bool has_faces(std::uint32_t tile) const noexcept {
        return !tile_face_start.empty() && tile_face_start[tile] != tile_face_start[tile + 1];
    }
    /// Samples a tile owns: 8 x 8, the last row and column with the last tiles.
    [[nodiscard]] Rect tile_rect(std::uint32_t tile) const noexcept;
    /// Window of half size b - 1 around a grid sample, clipped by the grid.
    [[nodiscard]] Rect window(std::uint32_t sample, std::uint32_t b) const noexcept;
    [[nodiscard]] Rect whole() const noexcept { return {0, tables.rows - 1, 0, tables.cols - 1}; }
    /// Code that writes to `now` or `normal` without touch() and update_normals() marks the place, for changed_rows().
    void note(const Rect& r) noexcept { changes.note(r); }
    /// Border samples low .. high.
    void note_border(std::uint32_t low, std::uint32_t high) noexcept { changes.note_border(low, high); }
    /// Marks everything as moved: boxes, normals and changes are made anew.
    void all_moved() noexcept;
    /// Appends a tile to tile_list once.
    void list_tile(std::uint32_t tile) noexcept {
        if ((tile_flags[tile] & kTileListed) != 0) return;
        tile_flags[tile] |= kTileListed;
        tile_list[tile_count_listed++] = tile;
    }
    void end_tile_list() noexcept {
        for (std::uint32_t k = 0; k < tile_count_listed; ++k)
            tile_flags[tile_list[k]] &= static_cast<std::uint8_t>(~kTileListed);
        tile_count_listed = 0;
    }
};

/// Copies the layers that a surface is made of, checks them and welds the seams. @return as State::create().
[[nodiscard]] Result<void> fill_surface(Surface& surface, const ChartTables& tables, bool plain_loops) noexcept;
/// Upper bound of the bytes that it takes.
[[nodiscard]] std::uint64_t surface_bytes(const ChartTables& tables) noexcept;
/// Weld classes from the pairs, then links from the border edges that two mates share. @return OutOfMemory.
[[nodiscard]] Result<void> build_classes(Surface& surface) noexcept;
[[nodiscard]] Result<void> build_links(Surface& surface) noexcept;
/// Tiles, their border samples and boxes. @return OutOfMemory.
[[nodiscard, gnu::cold]] Result<void> build_pyramid(Surface& surface) noexcept;  // cold: built small
/// Brings the boxes of moved samples and of the nodes above them up to date.
void refit(Surface& surface, Pyramid& pyramid) noexcept;

/// Finds the corners in the ring of each sample, and the samples that need ring_normal(). @return OutOfMemory.
[[nodiscard, gnu::cold]] Result<void> build_rings(Surface& surface) noexcept;
/// Mean squared differences of normals from those of the faces around them, at rest.
void measure_roughness(Surface& surface) noexcept;
/// Twice the area vector of the welded ring of a sample, and its slope as in RingJob. Faces at copies that are reversed
/// against `sample` count the other way round, so that such copies get opposite vectors, to the bit.
struct RingForm {
    double sum[6] = {};  ///< area, slope
};
[[nodiscard]] RingForm ring_form(const Surface& surface, const ConstPlanes& shape, const float* weight,
                                 std::uint32_t sample) noexcept;
/// Area-weighted unit normal of a shape over the welded ring; 0 without area.
[[nodiscard]] Vec3 ring_normal(const Surface& surface, const ConstPlanes& shape, std::uint32_t sample) noexcept;
/// Normals of `count` regular samples side by side. @return false if one was left at 0: float would not do.
[[nodiscard]] bool normals_inside(const Surface& surface, const ConstPlanes& shape, std::uint32_t first,
                                  std::uint32_t count, const Planes& to) noexcept;
/// The normal that update_normals() stores for `now`.
[[nodiscard]] Vec3 sample_normal(const Surface& surface, const ConstPlanes& shape, std::uint32_t sample) noexcept;
/// Brings `normal` up to date around moved samples.
void update_normals(Surface& surface) noexcept;

/// Marks samples of open borders (kRingRim). @return whether the welded surface has two faces at every edge;
/// OutOfMemory.
[[nodiscard]] Result<bool> find_rim(Surface& surface) noexcept;

/// Squared distances to samples and to boxes, rounded alike: for a point inside a box each |gap| is at most the
/// sample's |difference|, subtraction, squaring and adding round monotonically, so a box never seems farther than a
/// sample in it, and pruning by `box > best` is exact.
inline float sample_d2(Vec3 p, Vec3 tool) noexcept {
    const float x = p.x - tool.x, y = p.y - tool.y, z = p.z - tool.z;
    return x * x + y * y + z * z;
}
/// Exact nearest sample of a shape by its pyramid (which must be refitted).
struct Best {
    float d2 = __builtin_inff();
    std::uint32_t sample = kNone;
    void offer(float d, std::uint32_t k) noexcept {
        if (d < d2 || (d == d2 && k < sample)) {
            d2 = d;
            sample = k;
        }
    }
};
/// Improves `best`; samples of `except` are left out.
void search_pyramid(const Surface& surface, const Pyramid& pyramid, Vec3 tool, Best& best,
                    const Rect* except = nullptr) noexcept;
[[nodiscard]] DGM_API bool is_finite(Vec3 v) noexcept;
/// No coordinate beyond kMaxCoordinate, none a NaN.
[[nodiscard]] DGM_API bool is_place(Vec3 v) noexcept;

}  // namespace dgm::detail
