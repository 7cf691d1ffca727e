// SPDX-License-Identifier: MIT
// libdgm/src/contact_resolver.h
// One call of resolve_contact(): contact.cpp finds, projects and restores, contact_bulge.cpp keeps the volume.
#pragma once
#include <dgm/contact.h>

#include <algorithm>
#include <cmath>

#include "contact_impl.h"

namespace dgm::detail {

inline constexpr double kKept = 1e-6;  ///< of the removed volume: what volume_kept says

/// Phi: samples beyond the obstacle. Psi: the ring around them.
class Resolver {
 public:
    Resolver(StateImpl& s, ContactImpl& c, const Shape& shape, const ContactOptions& o) noexcept
        : s_(s), c_(c), shape_(shape), o_(o) {}

    ContactReport run() noexcept;

 private:
    // --- Phi ---
    void find_contact() noexcept;
    [[nodiscard]] PlaneJob plane_job(const Rect& r) noexcept {
        return {r,          s_.tables.cols, s_.now, {shape_.normal.x, shape_.normal.y, shape_.normal.z}, shape_.offset,
                tolerance_, c_.marks.data()};
    }
    [[nodiscard]] bool is_simple(std::uint32_t tile) const noexcept {
        return shape_.kind == ObstacleKind::Plane && s_.tables.mask == nullptr && s_.mobility.empty() &&
               (s_.tile_flags[tile] & kTileSpecial) == 0;
    }
    void mark_tile(std::uint32_t tile) noexcept;
    bool mark_sample(std::uint32_t k) noexcept;
    void deepen(double d) noexcept { report_.deepest = std::max(report_.deepest, static_cast<float>(d)); }

    // --- Psi ---
    void size_ring() noexcept;
    void weigh() noexcept;

    // --- volumes ---
    /// Tiles with touched quads, and runs of tiles side by side.
    void list_quads() noexcept;
    [[nodiscard]] QuadJob quad_job(Rect r) const noexcept {
        r.i1 = std::min(r.i1, s_.tables.rows - 2);
        r.j1 = std::min(r.j1, s_.tables.cols - 2);
        return {r, s_.tables.cols, StateImpl::fixed(s_.now), c_.kind.data(), {origin_.x, origin_.y, origin_.z}};
    }
    /// Six times the volume that touched faces span with the origin.
    [[nodiscard]] double volume() const noexcept { return volume(c_.runs, c_.run_count) + ring_volume(); }
    /// Of quads with a corner in the ring, and of border faces.
    [[nodiscard]] double ring_volume() const noexcept;
    [[nodiscard]] double volume(const Array<Rect>& runs, std::uint32_t count) const noexcept;
    [[nodiscard]] Double3 at(std::uint32_t k) const noexcept { return widen(s_.point(k)) - origin_; }
    [[nodiscard]] Double3 arrow(std::uint32_t k) const noexcept {
        return double{c_.weight[k]} * widen(StateImpl::at(s_.normal, k));
    }
    void cubic(double* c) const noexcept;

    // --- moving ---
    template <class F>
    void each_run(F f) const noexcept {
        for (std::uint32_t k = 0; k < c_.run_count; ++k) f(c_.runs[k]);
        for (std::uint32_t k = 0; k < c_.ring_run_count; ++k) f(c_.ring_runs[k]);
    }
    void save() noexcept;
    void put(std::uint32_t k, Double3 p) noexcept {
        const Vec3 v = narrow(p);
        s_.now.x[k] = v.x;
        s_.now.y[k] = v.y;
        s_.now.z[k] = v.z;
    }
    void project_sample(std::uint32_t k) noexcept;
    template <class F>
    void each_sample(std::uint32_t tile, F f) const noexcept {
        const Rect r = s_.tile_rect(tile);
        for (std::uint32_t i = r.i0; i <= r.i1; ++i)
            for (std::uint32_t k = i * s_.tables.cols + r.j0; k <= i * s_.tables.cols + r.j1; ++k) f(k);
    }
    void project() noexcept;

    /// now = clamp(before + beta w n).
    void apply(double beta) noexcept;

    void bulge() noexcept;
    void finish_bulge(double best, double error) noexcept;
    void settle(double beta, double error) noexcept;

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
    double tolerance_ = 0, total_ = 0;
    Double3 origin_;
    double before_ = 0, projected_ = 0;
    double elsewhere_ = 0;  ///< six times the projected volume of touched quads that have no corner in the ring
};

}  // namespace dgm::detail
