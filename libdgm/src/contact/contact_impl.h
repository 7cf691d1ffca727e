// SPDX-License-Identifier: MIT
// libdgm/src/contact/contact_impl.h
// Memory of a ContactSolver, and the steps of a contact.
#pragma once
#include <dgm/contact.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/double3.h"
#include "rows/contact_rows.h"
#include "touch/state_impl.h"

namespace dgm::detail {

inline constexpr std::uint64_t kNoTriangle = ~std::uint64_t{0};

/// All tiles of an obstacle's surface whose boxes meet a box that many searches stay inside of, and the boxes of their
/// quads: found once, used by each search.
struct NearTiles {
    static constexpr std::uint32_t kMost = 32;
    bool wanted = false, listed = false;
    Double3 want[2];  ///< where the next searches are, own frame
    Double3 low, high;
    BoxFrame frame;
    std::uint32_t count = 0, tiles[kMost] = {};
    float boxes[6 * kMost] = {};  ///< of the tiles, as BoxesNearJob::boxes
    float quads[kMost][6 * 64] = {};
};

/// A checked obstacle.
struct Shape {
    ObstacleKind kind = ObstacleKind::Plane;
    Double3 point, normal, end, half;  ///< normal: unit
    double offset = 0;                 ///< plane: normal . point
    double radius = 0;
    Double3 axis[3];  ///< columns of the rotation: own axes in the state's frame
    StateImpl* surface = nullptr;
    double reach = 0;     ///< surface; infinity: none
    double rounding = 0;  ///< surface: of gaps to its samples in float
    bool open = false;
    /// Surface: where the last search ended. The next one mostly ends near by, and is quicker for it; its answer does
    /// not depend on this.
    mutable std::uint64_t hint = kNoTriangle;
    NearTiles* near = nullptr;  ///< surface: or null, then every search starts at the root
    PointView was;              ///< surface: its samples in the step before, in its own frame then; or none
    double share = 1;           ///< of the way from there, which `way_come` asks for
    double ahead = 0;           ///< of that way, still to come; for `probe_underway`

    /// A surface that one may be behind: there distances change sign again.
    [[nodiscard]] bool is_limited() const noexcept {
        return kind == ObstacleKind::Surface && (open || reach < std::numeric_limits<double>::infinity());
    }
};
struct Probe {
    double distance = 0;  ///< negative beyond
    Double3 nearest;
    std::uint32_t facet = kNone;  ///< surface: a triangle whose plane may stand for it near by; kNone: none may
};
/// Checks and refits. @return BadArgument, Unsupported.
[[nodiscard]] DGM_API Result<Shape> make_shape(const Obstacle& obstacle) noexcept;
/// Depends on the point alone: copies of a class get the same bits.
[[nodiscard]] DGM_API Probe probe(const Shape& shape, Double3 point) noexcept;
/// The next searches are in or near a box (local frame).
DGM_API void look_into(const Shape& shape, const Box& box) noexcept;
/// After a search in the box looked into: no part of the surface lies among samples of a row of the grid, so that all
/// are on the same side. @return false where that is not known.
[[nodiscard]] bool is_apart(const Shape& shape, const StateImpl& state, const Rect& samples) noexcept;
/// Distance from the plane of a facet that probe() found near by.
[[nodiscard]] Probe facet_probe(const Shape& shape, std::uint32_t facet, Double3 point) noexcept;
/// Bounds from one search of a surface for points near by: distances change by no more than the ways gone. `way` is
/// what the obstacle has gone since it was first seen, at most.
class Surroundings {
 public:
    /// At least this far before the obstacle; no bound where negative.
    [[nodiscard]] double clearance(const Shape& shape, Double3 point, double way = 0) const noexcept {
        if (shape.kind != ObstacleKind::Surface) return -1;  // quicker asked than remembered
        return before(shape) - gone(shape, point, way);
    }
    /// Of a surface: at most this far before it.
    [[nodiscard]] double at_most(const Shape& shape, Double3 point, double way = 0) const noexcept {
        return before(shape) + gone(shape, point, way);
    }
    void note(Double3 point, double distance, double way = 0) noexcept {
        at_ = point;
        distance_ = distance;
        way_ = way;
    }

 private:
    [[nodiscard]] double before(const Shape& shape) const noexcept {
        return shape.is_limited() ? std::fabs(distance_) - shape.reach : distance_;
    }
    [[nodiscard]] double gone(const Shape& shape, Double3 point, double way) const noexcept {
        const Double3 off = point - at_;
        return (way - way_) + std::sqrt(dot(off, off)) * (1 + 1e-9) + shape.rounding;
    }
    Double3 at_;
    double distance_ = 0, way_ = 0;
};
/// Lower bound of the distance of all points of a box (local frame).
[[nodiscard]] double box_distance(const Shape& shape, const Box& box) noexcept;
inline constexpr std::uint8_t kInside = 1;  ///< marks: beyond the obstacle
inline constexpr std::uint8_t kQueued = 2;  ///< waits in the queue of the ring's walk
inline constexpr std::uint8_t kMember = 4;  ///< moves while the displacement is smoothed
inline constexpr std::uint8_t kMoving = 8;  ///< does so in this round

// Tiles with samples beyond; with samples of the ring; with quads that have one of either, one beyond, or one of the
// ring as a corner; with quads that have a corner in a tile where samples of the ring may come to rest on the obstacle;
// with quads that do, on a plane; whose distances between nodes are filled in.
inline constexpr std::uint8_t kTilePhi = 1, kTilePsi = 2, kTileMoving = 4, kTileSinking = 8, kTileBulging = 16,
                              kTileNear = 32, kTileHeld = 64, kTileSpread = 128;

/// Tiles side by side as one rectangle.
struct Runs {
    Array<Rect> rects;
    std::uint32_t count = 0;
    [[nodiscard]] const Rect* begin() const noexcept { return rects.begin(); }
    [[nodiscard]] const Rect* end() const noexcept { return rects.begin() + count; }
};

struct ContactImpl {
    explicit ContactImpl(const Allocator& a) noexcept : allocator(a) {}
    Allocator allocator;
    std::uint32_t rows = 0, cols = 0, total = 0;
    bool closed = false;
    const ContactRows* rows_of = nullptr;
    Array<std::uint8_t> kind;      ///< of each quad, at its first corner
    Array<std::uint8_t> in_class;  ///< samples that have copies
    Array<std::uint8_t> marks;
    /// Three planes `plane` apart: where samples of touched tiles were; all border samples. Until they are projected,
    /// where those beyond the obstacle will go.
    Array<float> saved;
    std::size_t plane = 0;
    Array<float> weight, square;  ///< 0 and infinity between contacts; square: heights over the obstacle while bulging
    Array<std::uint32_t> source;  ///< place in `rim`; beyond a surface Probe::facet
    Array<std::uint32_t> queue;   ///< of the ring's walk; then Probe::facet of samples in contact or smoothed
    NearTiles near_tiles{};
    Array<Vec3> rim;  ///< where edges cross the obstacle's border
    std::uint32_t rim_count = 0;
    Array<Rect> rects;  ///< of tiles: StateImpl::tile_rect()
    Array<std::uint8_t> tile_bits;
    Array<std::uint32_t> tiles;  ///< listed ones
    std::uint32_t tile_count = 0;
    Array<float> tile_top;  ///< largest weight in each tile of the ring
    Rect tile_range;        ///< holds all listed ones
    Runs inner;             ///< quads that move, but have no corner in the ring
    Runs ring, near;        ///< those that do; of these, apart from them, those of kTileNear
    bool spread = false;    ///< distances of all samples are in `weight`, `square` has those of nodes
    bool border = false;    ///< border samples are in contact or in the ring

    [[nodiscard]] Planes before() noexcept { return {saved.data(), saved.data() + plane, saved.data() + 2 * plane}; }
    void add_tile(std::uint32_t tile, std::uint8_t bit) noexcept {
        if (tile_bits[tile] == 0) tiles[tile_count++] = tile;
        tile_bits[tile] |= bit;
    }
};

/// Calls f(neighbour) for the samples that share an edge with `sample` or a copy of it; along the grid's diagonals
/// none.
template <class F>
void each_neighbour(const StateImpl& s, std::uint32_t sample, F f) noexcept {
    const ChartTables& t = s.tables;
    const auto around = [&](std::uint32_t k) {
        if (k < t.grid) {
            const std::uint32_t i = k / t.cols, j = k % t.cols;
            if (i > 0 && t.on_surface(k - t.cols)) f(k - t.cols);
            if (j > 0 && t.on_surface(k - 1)) f(k - 1);
            if (j + 1 < t.cols && t.on_surface(k + 1)) f(k + 1);
            if (i + 1 < t.rows && t.on_surface(k + t.cols)) f(k + t.cols);
        }
        if (s.face_start.empty()) return;
        for (std::uint32_t e = s.face_start[k]; e < s.face_start[k + 1]; ++e)
            for (std::uint32_t c = 0; c < 3; ++c) {
                const std::uint32_t other = s.faces[3 * std::size_t{s.face_of[e]} + c];
                if (other != k) f(other);
            }
    };
    const std::uint32_t id = s.class_id(sample);
    if (id == kNone) return around(sample);
    for (const std::uint32_t copy : s.members(id)) around(copy);
}

/// Calls f(tile) for the tiles whose boxes, and those of the nodes above them, meet what meets(box) says.
template <class Meets, class F>
void each_tile(const Pyramid& y, Meets meets, F f) noexcept {
    std::uint32_t stack[4 * kMaxLevels], level_of[4 * kMaxLevels], depth = 0;
    stack[depth] = 0;
    level_of[depth++] = y.levels - 1;
    while (depth != 0) {
        const std::uint32_t node = stack[--depth], level = level_of[depth];
        if (!meets(y.boxes[y.start[level] + node])) continue;
        if (level == 0) {
            f(node);
            continue;
        }
        const std::uint32_t r = node / y.cols[level] * 2, c = node % y.cols[level] * 2;
        for (std::uint32_t i = r; i < std::min(r + 2, y.rows[level - 1]); ++i)
            for (std::uint32_t j = c; j < std::min(c + 2, y.cols[level - 1]); ++j) {
                stack[depth] = i * y.cols[level - 1] + j;
                level_of[depth++] = level - 1;
            }
    }
}

/// Mobility of a sample, the same for all copies.
[[nodiscard]] inline float mobility_of(const StateImpl& s, std::uint32_t sample) noexcept {
    const std::uint32_t k = s.representative(sample);
    return s.mobility.empty() || k >= s.tables.grid ? 1.0f : s.mobility[k];
}

/// Open surfaces: averages the displacement of contact and ring with the neighbours', staying out of the obstacle.
void smooth_contact(StateImpl& state, ContactImpl& contact, const Shape& shape, std::uint32_t rounds) noexcept;

/// Squared surface distances from the rim of the marked samples, up to `reach`, into contact.square; lists tiles. On
/// open surfaces only samples within `steps` edges of the contact count: no displacement gets farther.
void grow_ring(const StateImpl& state, ContactImpl& contact, const Shape& shape, double reach,
               std::uint32_t steps) noexcept;

}  // namespace dgm::detail
