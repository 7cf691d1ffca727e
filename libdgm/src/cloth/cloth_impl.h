// SPDX-License-Identifier: MIT
// libdgm/src/cloth/cloth_impl.h
// Memory of a Cloth. Lengths are metres, forces newtons; fields hold the same bits at all copies of a class.
#pragma once
#include <dgm/cloth.h>
#include <span>

#include "base/double3.h"
#include "cloth/kernels.h"
#include "contact/scene.h"
#include "touch/state_impl.h"

namespace dgm::detail {

namespace cloth {

inline constexpr std::uint32_t kMostLevels = 16;
inline constexpr Error kNoMemory{ErrorCode::OutOfMemory, kNoOffset, "no memory for the cloth"};

/// Where a sample is in the planes of a level, from that of sample (0, 0) on.
using Spot = std::uint32_t;

/// Bending across a seam: the stencils of a class, of samples on both sides.
struct SeamStencil {
    Spot spot[5];  ///< the sample itself first; then u up, u down, v up, v down
    float weight[2][4];
    float bending, curved[2];
};

/// One stride of the map.
struct Level {
    std::uint32_t rows = 0, cols = 0;
    std::size_t count = 0;  ///< floats from sample (0, 0) to the end of the last row
    Array<float> planes;
    Array<double> places;
    double* at[3] = {};  ///< where samples are
    Sheet on;
    Array<std::uint8_t> touched;
    Array<float> scratch;
    Blocks inverse;
    Field right, residual, way, product, sum;
    float* free = nullptr;        ///< 1, or 0: held, and past the ends of rows
    float* own = nullptr;         ///< 1, at copies 0
    Array<std::uint8_t> clamped;  ///< by sample: held with its neighbour on the finest level, a bit a way
    Array<std::uint32_t> groups;  ///< size of a class, its spots, and so on
    Array<SeamStencil> seams;
    Array<std::uint32_t> row_of, column_of;  ///< on the level before
    std::uint32_t even = 0;                  ///< columns that are at twice their index on the level before
    Array<Taps> to_row, to_column;           ///< by row or column of the level before: how it is interpolated
    Array<Taps> from_rows, from_columns;     ///< the transpose, by row or column here
};

/// A sample and the obstacle that it is nearest to.
struct Contact {
    std::uint32_t sample;
    std::uint32_t obstacle;  ///< place in the scene
    Double3 normal;
    double gap;       ///< at the start of the substep
    double press;     ///< stiffness, N/m
    double bears;     ///< force at the start of the substep, N
    double drag = 0;  ///< stiffness against sliding, N/m
    Double3 pull;     ///< force of friction at its start, N
    Double3 slid;     ///< way along the obstacle before the substep's own solution
};

/// Friction of a sample in the substep before.
struct Rub {
    Vec3 force;           ///< N
    bool sticks = false;  ///< it stayed where it was on the obstacle
};

/// Where a sample was when obstacles were asked last, and how far in front of all of them it was at least.
struct Seen {
    Double3 at;
    double gap = 0;           ///< metres
    std::uint64_t scene = 0;  ///< ClothImpl::scene_number then
    double way = 0;           ///< ClothImpl::scene_way then
};

/// How a tile saw a surface last.
struct TileSeen {
    Surroundings from;        ///< its middle
    std::uint64_t scene = 0;  ///< ClothImpl::scene_number then
};
/// Samples a side of the tiles of contact.
inline constexpr std::uint32_t kTile = 8;

/// Obstacles and tools of a frame.
struct FrameScene : Scene {
    std::uint32_t tool[kMost] = {};  ///< place among the tools, or kNone
    Shape from[kMost];               ///< where they are at the start of the frame
    Shape last[kMost], here[kMost];  ///< at the start and the end of the substep
    bool moves[kMost] = {};          ///< in the frame
    double way[kMost] = {};          ///< of a surface's samples in the frame, at most, metres
};

/// A sample that moves with a tool.
struct Held {
    Spot spot;
    std::uint32_t sample, tool;
    Double3 offset;  ///< metres
};

/// A sample and a triangle of the same cloth, or two edges, that may meet in this substep.
struct Meeting {
    Spot spot[4];  ///< the sample and three corners; the ends of both edges
    float side;    ///< +1 or -1: on which side of the triangle the sample stays; edges: along the product of both
    bool edges;
};

/// Normals of the quads in a tile of 8 x 8: their mean, and the cosine of the widest angle to it.
struct Cone {
    Double3 axis;
    double cosine = -1;
};

/// An edge along a line of the grid, while meetings are looked for.
struct Edge {
    std::uint32_t i[2], j[2];
    Spot spot[2];
    Double3 at[2], low, high;  ///< ends; box of both
};
/// Of a tile.
inline constexpr std::uint32_t kMostEdges = 2 * (kTileQuads + 1) * (kTileQuads + 1);

}  // namespace cloth

struct ClothImpl {
    explicit ClothImpl(const Allocator& a) noexcept : allocator(a) {}
    Allocator allocator;
    ClothOptions options;
    const cloth::Kernels* kernels = nullptr;
    std::uint32_t rows = 0, cols = 0, total = 0, levels = 0;
    double scale = 1;      ///< metres per local unit
    double mean_step = 0;  ///< metres
    cloth::Level level[cloth::kMostLevels];
    float highest = 3.2f;      ///< bound of the eigenvalues of inverse blocks times matrix
    float first_bound = 3.2f;  ///< what it is until a cycle leads uphill

    Array<float> planes;
    Array<double> places;
    double* was[3] = {};  ///< at the start of the substep
    cloth::Field velocity, inertial, correction, way, image, before;
    cloth::Field gradient;  ///< where the finest right side is
    cloth::Field lead;      ///< where the solution leads, `led` times
    double led = 0;
    float* fall = nullptr;           ///< share of gravity that a sample followed in the substep before
    float* pressed = nullptr;        ///< N: force of the contact of the substep before
    float* mobile = nullptr;         ///< 0: the layer `contact` holds it
    float* weight = nullptr;         ///< kg: of the whole class
    float* firm = nullptr;           ///< N/m: stiffness of contacts
    Array<std::uint32_t> next_copy;  ///< by sample: the next one of its class, a ring; itself if there is none
    bool held_anew = true;  ///< samples are held that were free when coarse levels got `free`, or the other way round
    Array<std::uint8_t> was_pinned;  ///< by sample, in the frame before
    Array<std::uint8_t> pinned;      ///< by sample, while a frame runs
    Array<cloth::Contact> contacts;
    Array<cloth::Rub> rubs;             ///< by sample
    Array<cloth::Seen> seen;            ///< by sample
    Array<cloth::TileSeen> tiles_seen;  ///< by surface and tile
    std::size_t tile_count = 0;         ///< of contact
    Array<std::uint8_t> tiles_met;      ///< 1: obstacles were near in the substep before; samples may bear forces
    std::uint64_t scene_number = 1;     ///< another one whenever an obstacle comes, goes, bends or jumps
    double scene_way = 0;               ///< metres that obstacles have gone, at most, since the program began
    Array<NearTiles> near_tiles;        ///< of the first surfaces among the obstacles
    std::uint32_t contact_count = 0;
    cloth::FrameScene scene;
    Scene before_scene;  ///< of the frame before
    Array<cloth::Held> held;
    std::uint32_t held_count = 0;
    std::uint64_t holding = 0;  ///< bit by tool number
    Vec3 tool_before[Scene::kMost];
    std::uint64_t known = 0;  ///< tools whose place before is known
    Array<cloth::Meeting> meetings;
    std::uint32_t meeting_count = 0;
    Array<cloth::Edge> edges;                         ///< of two tiles
    Array<cloth::Cone> cones;                         ///< by tile
    double stiff = 0;                                 ///< J: twice the energy of a unit strain everywhere
    double elastic = 0, kinetic = 0, moment[3] = {};  ///< J, J, kg m: at the end of the frame before

    [[nodiscard]] cloth::Level& fine() noexcept { return level[0]; }
    [[nodiscard]] const cloth::Level& fine() const noexcept { return level[0]; }
    [[nodiscard]] cloth::Spot spot_of(std::uint32_t sample) const noexcept {
        return sample / cols * static_cast<std::uint32_t>(level[0].on.pitch) + sample % cols;
    }
    [[nodiscard]] Double3 place(cloth::Spot k) const noexcept {
        return {level[0].at[0][k], level[0].at[1][k], level[0].at[2][k]};
    }
};

namespace cloth {

[[nodiscard]] inline Double3 at(const Field& f, Spot k) noexcept {
    return {double{f.p[0][k]}, double{f.p[1][k]}, double{f.p[2][k]}};
}
inline void put(const Field& f, Spot k, Double3 v) noexcept {
    f.p[0][k] = static_cast<float>(v.x);
    f.p[1][k] = static_cast<float>(v.y);
    f.p[2][k] = static_cast<float>(v.z);
}
template <class F>
void each_copy(const ClothImpl& c, std::uint32_t sample, F f) noexcept {
    std::uint32_t k = sample;
    do {
        f(k);
        k = c.next_copy[k];
    } while (k != sample);
}

/// Planes and rest shapes of all strides. @return OutOfMemory.
[[nodiscard]] Result<void> build_model(ClothImpl& c, const StateImpl& s) noexcept;
/// Every copy gets the sum over its class, in each of the rows.
void sum_classes(const Level& l, std::span<float* const> rows) noexcept;
/// gradient = slope of membrane and bending at level[0].at, and of by_dt2 mass |inertial|^2 / 2. @return energy of the
/// first two; inertia: mass |inertial|^2
double evaluate(ClothImpl& c, float by_dt2 = 0, double* inertia = nullptr) noexcept;
/// The energies, `by` times the solution further.
[[nodiscard]] double energy_ahead(const ClothImpl& c, double by, double& inertia) noexcept;
/// to = matrix from, summed over classes.
void apply(const ClothImpl& c, const Level& l, const Field& from, const Field& to, float by_dt2) noexcept;
/// Coarse shapes, contacts and diagonal blocks of the matrix at level[0].at; there right = - gradient in its place, and
/// what the smoother begins with. @return right . right
double prepare(ClothImpl& c, float by_dt2, std::uint32_t levels) noexcept;
/// lead, led = what conjugate gradients find for `gradient` (negative right side). @return residual left over that at
/// the start, 0 .. 1
double solve(ClothImpl& c, float by_dt2, std::uint32_t levels, std::uint32_t cycles) noexcept;

/// Lists contacts at level[0].at with what is in the scene `here`, with stiffness and friction, and marks them on the
/// sheet.
void find_contacts(ClothImpl& c, double h, double friction) noexcept;
/// Adds their slope to `gradient`. @return their energy
double press(ClothImpl& c) noexcept;
/// Their energy where the solution, times `by`, has been added.
[[nodiscard]] double pressed_energy(const ClothImpl& c, double by) noexcept;
/// Notes the forces that the solution left.
void end_contacts(ClothImpl& c, std::span<StepTool> answers, double friction, double share) noexcept;
/// Moves samples that are still beyond out of obstacles.
void push_out(ClothImpl& c) noexcept;

/// Lists samples and triangles of the cloth that may meet within `reach` metres.
void find_meetings(ClothImpl& c, const StateImpl& s, double reach) noexcept;
/// Moves them apart. @return how many
std::uint32_t keep_apart(ClothImpl& c, double friction) noexcept;

}  // namespace cloth
}  // namespace dgm::detail
