// SPDX-License-Identifier: MIT
// libdgm/src/physics/compliance_impl.h
// What a Compliance hands from the thread of the physics to the haptic loop, and memory of both sides.
#pragma once
#include <dgm/compliance.h>

#include <atomic>

#include "physics/physics_impl.h"

namespace dgm::detail {

namespace physics {

inline constexpr std::uint32_t kMostColumns = 32, kMostNear = 128, kMostTools = 8, kSlots = 3;

enum class Held : std::uint32_t { Away = 0, Touch = 1, Grasp = 2 };

/// The body near one tool. Metres and newtons; places from `origin` on.
struct Local {
    std::uint64_t frame;
    double origin[3];  ///< of the tool, local units
    double scale;      ///< metres per local unit
    Held held;
    std::uint32_t near, columns;
    float radius;
    // Samples near the tool.
    float place[3][kMostNear];  ///< before the step
    float way[3][kMostNear];    ///< d_ref
    float weight[kMostNear];    ///< share of its column's force
    std::uint32_t column[kMostNear];
    // Columns.
    float force[kMostColumns];                      ///< f_ref
    float multiplier[kMostColumns];                 ///< at the start of the step
    float give[kMostColumns];                       ///< 1 / stiffness of the contact, m/N
    float response[3][kMostColumns][kMostColumns];  ///< [axis][of a force on][how the mean of this one moves], m/N
    // A grasp: force = pull + stiffness * way of the tool.
    float pull[3], stiffness[9];
};
static_assert(std::is_trivially_copyable_v<Local> && sizeof(Local) % sizeof(std::uint64_t) == 0);

using Word = std::size_t;
inline constexpr std::size_t kLocalWords = sizeof(Local) / sizeof(Word);

/// A column that was computed: the whole body's answer to a force on the group around `sample`.
struct Column {
    std::uint32_t sample = kNone;
    std::uint64_t used = 0, renewed = 0;  ///< frames
};

}  // namespace physics

struct ComplianceImpl {
    explicit ComplianceImpl(const Allocator& a) noexcept : allocator(a) {}
    Allocator allocator;
    ComplianceOptions options;
    std::uint32_t rows = 0, cols = 0, total = 0, known = 0;  ///< known: columns kept of a tool
    std::size_t plane = 0;                                   ///< floats of a plane
    Array<float> fields;                                     ///< of columns, by tool; then d_ref of each
    Array<physics::Column> columns;
    physics::Local local{};  ///< being made
    Array<physics::Word> words;
    Array<std::uint64_t> sequence;  ///< by tool and slot; odd while it is written
    std::uint64_t frame = 0;
    std::atomic<std::uint64_t> newest{0};

    [[nodiscard]] physics::Field field(std::uint32_t tool, std::uint32_t k) noexcept {
        physics::Field f;
        for (std::size_t c = 0; c < 3; ++c)
            f.p[c] = fields.data() + ((std::size_t{tool} * (known + 1) + k) * 3 + c) * plane;
        return f;
    }
    [[nodiscard]] physics::Column* columns_of(std::uint32_t tool) noexcept {
        return columns.data() + std::size_t{tool} * known;
    }
    [[nodiscard]] std::size_t slot(std::uint32_t tool, std::uint64_t frame_number) const noexcept {
        return std::size_t{tool} * physics::kSlots + static_cast<std::size_t>(frame_number % physics::kSlots);
    }
};

struct ReaderImpl {
    explicit ReaderImpl(const Allocator& a) noexcept : allocator(a) {}
    Allocator allocator;
    ComplianceImpl* from = nullptr;
    std::uint32_t tools = 0, fade = 0;
    double damper = 0;  ///< N/m: a tick's way times this is the strongest damping
    struct Felt {
        physics::Local local[2];
        int now = 0;
        float force[physics::kMostColumns] = {};  ///< of the tick before
        Double3 jump;                             ///< of the force at the last change of frames
        std::uint32_t left = 0;                   ///< ticks until it is gone
        // What the passivity observer knows.
        bool engaged = false;  ///< in the tick before
        Vec3 position;         ///< there
        Double3 answered;      ///< there
        double energy = 0;     ///< J, that the body has got from the tool
    };
    Array<Felt> felt;
};

namespace physics {
/// Hands out `c.local` as the newest frame of a tool; frames begin with begin_frame() and end with end_frame().
void hand_out_local(ComplianceImpl& c, std::uint32_t tool) noexcept;
}  // namespace physics
}  // namespace dgm::detail
