// SPDX-License-Identifier: MIT
// libdgm/src/contact/contact_resolver.h
// One call of resolve_contact(): contact.cpp finds, projects and restores, contact_bulge.cpp keeps the volume.
#pragma once
#include <dgm/contact.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "contact/contact_impl.h"

namespace dgm::detail {

inline constexpr double kKept = 1e-6;   ///< of the removed volume: the limit of volume_kept
inline constexpr double kAimed = 1e-8;  ///< of the removed volume: an error that is left as it is

/// Six times the volume as a function of the height of the bulge.
struct Cubic {
    double c[3] = {0, 0, 0};
    [[nodiscard]] double operator()(double b) const noexcept { return ((c[2] * b + c[1]) * b + c[0]) * b; }
    [[nodiscard]] double slope(double b) const noexcept { return (3 * c[2] * b + 2 * c[1]) * b + c[0]; }
};

/// Phi: samples beyond the obstacle. Psi: the ring around them.
class Resolver {
 public:
    Resolver(StateImpl& s, ContactImpl& c, const Shape& shape, const ContactOptions& o) noexcept
        : s_(s), c_(c), shape_(shape), o_(o) {}

    ContactReport run() noexcept;

 private:
    // --- Phi ---
    void find_contact() noexcept;
    /// For a plane, sphere or capsule.
    [[nodiscard]] MarkJob mark_job(const Rect& r) noexcept;
    /// The loops over rows can project it, and every sample moves the whole way.
    [[nodiscard]] bool is_simple() const noexcept {
        return (shape_.kind == ObstacleKind::Plane || is_round()) && s_.tables.mask == nullptr && s_.mobility.empty();
    }
    [[nodiscard]] bool is_round() const noexcept {
        return shape_.kind == ObstacleKind::Sphere || shape_.kind == ObstacleKind::Capsule;
    }
    void mark_tile(std::uint32_t tile) noexcept;
    bool mark_sample(std::uint32_t k) noexcept;
    void deepen(double d) noexcept { report_.deepest = std::max(report_.deepest, static_cast<float>(d)); }

    // --- Psi ---
    void size_ring() noexcept;
    void weigh() noexcept;

    // --- volumes, six times what they are ---
    /// Tiles with touched quads, and runs of tiles side by side.
    void list_quads() noexcept;
    /// Tiles whose bits under `mask` are `bits`.
    void collect(Runs& runs, std::uint8_t mask, std::uint8_t bits) noexcept;
    [[nodiscard]] QuadJob quad_job(Rect r) const noexcept {
        r.i1 = std::min(r.i1, s_.tables.rows - 2);
        r.j1 = std::min(r.j1, s_.tables.cols - 2);
        return {r, s_.tables.cols, StateImpl::fixed(s_.now), c_.kind.data(), {0, 0, 0}};
    }
    /// Volume that quads and border faces gained by the call so far.
    [[nodiscard]] double swept(const Rect& r) const noexcept;
    [[nodiscard]] double swept(const Runs& runs) const noexcept;
    [[nodiscard]] double swept_faces() const noexcept;
    /// Corners of a border face, and how they move.
    struct Face {
        Double3 at[3], by[3];
    };
    /// Adds to c[0..2] the volume that a face sweeps by beta, beta^2, beta^3 of its move.
    static void add_face(const Face& f, double* c) noexcept;
    void cubic(const Runs& runs, double* c) const noexcept;
    void cubic_faces(double* c) const noexcept;

    // --- moving ---
    template <class F>
    void each_run(F f) const noexcept {
        for (const Runs* runs : {&c_.inner, &c_.ring, &c_.near})
            for (const Rect& r : *runs) f(r);
    }
    /// Exchanges `now` and the positions that find_contact() left in c_.before() for samples beyond the obstacle.
    void project() noexcept;
    void put(std::uint32_t k, Double3 p) noexcept {
        const Vec3 v = narrow(p);
        s_.now.x[k] = v.x;
        s_.now.y[k] = v.y;
        s_.now.z[k] = v.z;
    }
    /// Distances cost a search.
    [[nodiscard]] bool searches() const noexcept { return shape_.kind == ObstacleKind::Surface; }
    [[nodiscard]] Vec3 projected(std::uint32_t k, Double3 from, const Probe& there) const noexcept;
    template <class F>
    void each_sample(std::uint32_t tile, F f) const noexcept {
        const Rect r = c_.rects[tile];
        for (std::uint32_t i = r.i0; i <= r.i1; ++i)
            for (std::uint32_t k = i * s_.tables.cols + r.j0; k <= i * s_.tables.cols + r.j1; ++k) f(k);
    }

    /// Parts the ring by whether its samples can come to rest on the obstacle.
    void part_ring() noexcept;
    /// The quads at the end of a run reach into the tiles beyond.
    [[nodiscard]] Rect with_corners(const Rect& r) const noexcept {
        return {r.i0, std::min(r.i1 + 1, s_.tables.rows - 1), r.j0, std::min(r.j1 + 1, s_.tables.cols - 1)};
    }
    [[nodiscard]] BulgeJob bulge_job(double beta) const noexcept;
    /// now = clamp(before + beta w n).
    void apply(const Runs& runs, double beta) noexcept;
    /// Keep samples that were bulged by beta out of the obstacle, if the loops do not: one off seams; all copies of the
    /// listed classes, wherever they are.
    void put_back_sample(std::uint32_t k, double beta) noexcept;
    void put_back_tile(std::uint32_t tile, double beta) noexcept;
    void put_back_classes(double beta) noexcept;
    /// Whether sample k of the ring, bulged by beta to `bulged`, is beyond the obstacle, and then where it comes out.
    [[nodiscard]] bool falls_in(std::uint32_t k, double beta, Vec3 bulged, Probe& there) noexcept;
    /// Lists the representatives of the ring's classes in c_.source, which the ring's walk has left.
    void list_classes() noexcept;

    /// Six times the volume it costs to keep the bulge out of a plane. Before anything is bulged.
    [[nodiscard]] double held_back(double beta) const noexcept;
    [[nodiscard]] double held_back(const Rect& r, double beta) const noexcept;
    /// True if held_back() is all that must be measured.
    [[nodiscard]] bool foreseen() const noexcept {
        return shape_.kind == ObstacleKind::Plane && o_.bulge == Bulge::Exact && s_.faces.empty();
    }
    void bulge() noexcept;
    /// From the height to first order to the one that keeps the volume. `all`: volume without the part held back,
    /// `rest`: the part of it that need not be measured.
    void search_height(const Cubic& all, Cubic rest, double first) noexcept;
    [[nodiscard]] double first_height(const Cubic& volume, double first) const noexcept;
    /// Bulges the part near the obstacle and measures it. @return the error of six times the volume.
    [[nodiscard]] double measure_near(double beta, const Cubic& rest) noexcept;
    void take_all_as_near() noexcept;
    /// Bulges all and polishes it. @return whether the volume is kept, or there is no time left.
    bool finish_at(double beta) noexcept;
    /// Bulges all and measures it. @return the error.
    double settle(double beta) noexcept;

    /// For a sample inside the grid and off seams.
    [[nodiscard]] Double3 volume_gradient(std::uint32_t k) const noexcept;
    /// Spends single units in the last place on `left`, a volume. @return the volume still missing.
    double nudge(std::span<const std::uint32_t> samples, double left) noexcept;
    /// Puts a small remaining error on a few samples that are free to move, one after another.
    void polish(double error) noexcept;

    // --- afterwards ---
    /// Plastic: the permanent shape moves as the present one did.
    void keep() noexcept;
    void touch() noexcept;
    ContactReport finish(ContactStatus status) noexcept;

    StateImpl& s_;
    ContactImpl& c_;
    const Shape& shape_;
    const ContactOptions& o_;
    ContactReport report_;
    Surroundings around_;
    double tolerance_ = 0, total_ = 0;
    bool heights_ = false;           ///< c_.square holds heights over the obstacle
    std::uint32_t class_count_ = 0;  ///< of those in c_.source
    double held_ = 0;                ///< volume held back of a bulge of highest_
    double highest_ = 0;             ///< bulge up to which samples outside kTileNear keep clear of the obstacle
    double area_ = 0;                ///< of the contact, by its quads
    double weights_ = 0;             ///< sum over the ring
    double removed_ = 0;             ///< six times the volume
    double sunk_ = 0;                ///< six times what quads that have no corner in the ring gained
};

}  // namespace dgm::detail
