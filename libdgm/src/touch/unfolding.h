// SPDX-License-Identifier: MIT
// libdgm/src/touch/unfolding.h
// The welded triangles of the rest surface, as ways go over them: which triangle lies beyond an edge, and where.
#pragma once
#include <algorithm>
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
    /// @param per_step  kernel steps to a unit
    Unfolding(const StateImpl& s, float per_step) noexcept
        : s_(s),
          per_step_(per_step),
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
        const float edge2 = dot(edge, edge);
        if (!(edge2 > kThin * dot(third, third))) [[unlikely]]
            return beside_short(at, e);
        const float share = 1 / edge2, along = share * dot(edge, third);
        const float height = share * std::fabs(cross(edge, third));
        return {along * e.x + height * e.y, along * e.y - height * e.x};
    }
    /// Whether an edge is too short, beside another side of its triangle, to tell a direction and a scale.
    [[nodiscard]] static DGM_INLINE bool is_short(Vec2 e, float side2) noexcept { return !(dot(e, e) > kThin * side2); }
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
    static constexpr float kThin = 1e-8f;  ///< squared: of lengths that are carried on, as many digits are right

    /// to_third() of an edge whose length says nothing: by the lengths at rest.
    [[nodiscard]] [[gnu::noinline]] Vec2 beside_short(const Across& at, Vec2 e) const noexcept {
        const Vec3 right = StateImpl::at(s_.rest, at.end(0));
        const Vec3 edge = StateImpl::at(s_.rest, at.end(1)) - right, third = StateImpl::at(s_.rest, at.apex()) - right;
        const float long2 = dgm::dot(third, third), short2 = dgm::dot(edge, edge), e2 = dot(e, e);
        const float along = short2 > 0 ? dgm::dot(edge, third) / std::sqrt(short2) : 0;
        const float height = std::sqrt(std::max(0.0f, long2 - along * along));
        const Vec2 unit = e2 > 0 ? (1 / std::sqrt(e2)) * e : Vec2{1, 0};
        return per_step_ * Vec2{along * unit.x + height * unit.y, along * unit.y - height * unit.x};
    }

    const StateImpl& s_;
    const float per_step_;
    const GeodesicScratch& g_;
    const FlatTriangle* const triangles_;
    const std::uint8_t* const corners_;
    const std::uint32_t cols_;
    const Way strip_;  ///< ways from here on lead into triangles of the strip
};

}  // namespace dgm::detail
