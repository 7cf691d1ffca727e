// SPDX-License-Identifier: MIT
// libdgm/src/touch/unfolding.h
// The welded triangles of the rest surface, as ways go over them: which triangle lies beyond an edge, and where.
#pragma once
#include <cmath>

#include "touch/geodesic.h"
#include "touch/state_impl.h"
#include "touch/window_queue.h"

namespace dgm::detail {

/// The triangle that a way leads into.
struct Across {
    const Steps* steps;
    const std::uint32_t* corners;  ///< of a strip's triangle, else null
    std::uint32_t quad;
    Way way;
    bool loose;  ///< ways on have to be looked up
    [[nodiscard]] DGM_INLINE std::uint32_t sample(std::int32_t step) const noexcept {
        return corners == nullptr ? quad + static_cast<std::uint32_t>(step) : corners[step];
    }
    [[nodiscard]] DGM_INLINE std::uint32_t apex() const noexcept { return sample(steps->apex); }
    [[nodiscard]] DGM_INLINE std::uint32_t end(int hand) const noexcept { return sample(steps->end[hand]); }
    [[nodiscard]] DGM_INLINE Way out(int hand) const noexcept { return way + static_cast<Way>(steps->out[hand]); }
    [[nodiscard]] DGM_INLINE Way own(int hand) const noexcept { return way + static_cast<Way>(steps->own[hand]); }
};

class Unfolding {
 public:
    explicit Unfolding(const StateImpl& s) noexcept
        : s_(s),
          g_(s.geodesic),
          triangles_(g_.triangles.data()),
          corners_(g_.corners.data()),
          cols_(s.tables.cols),
          strip_(2 * g_.strip) {}

    /// Representative of a sample.
    [[nodiscard]] DGM_INLINE std::uint32_t corner(std::uint32_t sample) const noexcept {
        return (corners_[sample] & kCornerClass) == 0 ? sample : s_.representative(sample);
    }
    [[nodiscard]] DGM_INLINE Across across(Way way) const noexcept {
        const std::uint32_t quad = (way >> 4) - cols_;
        if (way >= strip_) [[unlikely]]
            return {&g_.strip_steps[way >> 1 & 7][way & 1], s_.faces.data() + 3 * std::size_t{(way - strip_) >> 4},
                    quad, way, true};
        const std::uint8_t flags = corners_[quad];
        return {&g_.steps[flags & kCornerDiagonal][way >> 1 & 7][way & 1], nullptr, quad, way,
                (flags & kCornerLoose) != 0};
    }
    [[nodiscard]] DGM_INLINE FlatTriangle flat(const Across& at) const noexcept {
        return triangles_[2 * (at.way >> 4) + static_cast<std::uint32_t>(at.steps->half)];
    }
    /// From the right end of the edge e to the third corner of the triangle beyond.
    [[nodiscard]] DGM_INLINE Vec2 to_third(const Across& at, Vec2 e) const noexcept {
        const FlatTriangle z = flat(at);
        const Steps& s = *at.steps;
        const Vec2 edge{s.edge[0] + s.edge[1] * z.x, s.edge[1] * z.y};
        const Vec2 third{s.third[0] + s.third[1] * z.x, s.third[1] * z.y};
        const float share = 1 / dot(edge, edge), along = share * dot(edge, third);
        const float height = share * std::fabs(cross(edge, third));
        return {along * e.x + height * e.y, along * e.y - height * e.x};
    }
    /// Visits the ways on across an edge of a loose triangle: those that are linked, or else the one on the grid.
    template <class Visit>
    void each_beyond(const Across& at, int hand, Visit visit) const noexcept {
        const std::uint32_t own = at.own(hand) >> 1;
        const SideLink* link = link_of(own);
        if (link == nullptr) return visit(at.out(hand));
        Way turned = at.own(hand) & 1;
        for (int k = 0; link != nullptr && link->to != own && k < kMostBeyond; ++k) {
            turned ^= link->turned ? 1u : 0u;
            visit(2 * link->to + turned);
            link = link_of(link->to);
        }
    }
    template <class Visit>
    void each_copy(std::uint32_t v, Visit visit) const noexcept {
        if ((corners_[v] & kCornerClass) == 0) return visit(v);
        for (const std::uint32_t copy : s_.members(s_.class_id(v))) visit(copy);
    }
    /// Visits the triangles at v, by the ways in that have v at their right: two each.
    template <class Visit>
    void each_triangle_at(std::uint32_t v, Visit visit) const noexcept {
        const ChartTables& t = s_.tables;
        each_copy(v, [&](std::uint32_t sample) {
            const auto look = [&](std::uint32_t side) {
                for (const Way way : {2 * side, 2 * side + 1}) {
                    const Across at = across(way);
                    if (at.end(0) == sample && !std::isinf(flat(at).x)) visit(at);
                }
            };
            if (sample < t.grid) {
                const std::uint32_t i = sample / cols_, j = sample % cols_;
                for (std::uint32_t qi = i == 0 ? 0 : i - 1; qi <= i && qi + 1 < t.rows; ++qi)
                    for (std::uint32_t qj = j == 0 ? 0 : j - 1; qj <= j && qj + 1 < cols_; ++qj)
                        for (std::uint32_t k = 0; k < 6; ++k) look(8 * (qi * cols_ + qj + cols_) + k);
            }
            if (s_.face_start.empty()) return;
            for (std::uint32_t k = s_.face_start[sample]; k < s_.face_start[sample + 1]; ++k)
                for (std::uint32_t side = 0; side < 3; ++side) look(g_.strip + 8 * s_.face_of[k] + side);
        });
    }

 private:
    [[nodiscard]] const SideLink* link_of(std::uint32_t side) const noexcept {
        const auto last = static_cast<std::uint32_t>(g_.links.size() - 1);
        for (std::uint32_t k = g_.hash(side);; k = (k + 1) & last) {
            const SideLink& link = g_.links[k];
            if (link.from == side) return &link;
            if (link.from == kNone) return nullptr;
        }
    }

    static constexpr int kMostBeyond = 8;  ///< triangles at one edge

    const StateImpl& s_;
    const GeodesicScratch& g_;
    const FlatTriangle* const triangles_;
    const std::uint8_t* const corners_;
    const std::uint32_t cols_;
    const Way strip_;  ///< ways from here on lead into triangles of the strip
};

}  // namespace dgm::detail
