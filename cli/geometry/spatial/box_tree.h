// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/spatial/box_tree.h
// A hierarchy of double-precision boxes over triangles that lie close together, or that are needles.
//
// Embree's boxes are floats: of triangles within 1e-6 diagonals of each other a distant query would look at each, and a
// map that crowds its samples at one place has thousands of them. Doubles tell them apart, and triangles that are one
// and the same point need one look in all. Where needles lie side by side in no direction of an axis, as in the fan of
// a polygon with 100 000 corners in line, all boxes overlap: there each node has a strip, too, at right angles to them.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/spatial/triangles.h"

namespace dgm::bake {

class BoxTree {
 public:
    /// Facets: large ones that cross the axes, whose boxes are nearly empty.
    enum class Of { kCrowd, kNeedles, kFacets };
    struct Box {
        model::Vec3d low, high;
    };

    /// @param triangles  read here only
    /// @param members    indices into `triangles`, at least one
    BoxTree(const Triangles& triangles, std::vector<std::uint32_t> members, Of of);

    [[nodiscard]] const Box& bounds() const { return nodes_.front().box; }

    /// Calls visit(triangle) for every triangle that may be nearer to p than `nearest`, or as near with a lower face;
    /// `visit` brings `nearest` up to date. Nearer boxes come first.
    /// @param reach  largest coordinate of p, at least 1: rounding is relative to it
    template <class Visit>
    void search(const model::Vec3d& p, double reach, const Nearest& nearest, Visit visit) const {
        constexpr double kRounding = 1e-15;  // of a difference of coordinates, and of what follows from it
        std::array<std::uint32_t, kDeepest> stack{};
        std::size_t count = 0;
        stack[count++] = 0;
        while (count > 0) {
            const std::uint32_t n = stack[--count];
            const Node& node = nodes_[n];
            const double squared = squared_distance(node.box, p);
            if (node.is_point) {
                if (squared < nearest.squared || (squared == nearest.squared && node.least_face < nearest.face))
                    visit(node.least_triangle);
                continue;
            }
            const double reached = std::sqrt(nearest.squared) + kRounding * reach;
            if (squared > reached * reached * (1 + kRounding)) continue;
            if (!strips_.empty() && strips_[n].is_farther(p, reach, nearest.squared)) continue;
            if (node.children == 0) {
                for (std::uint32_t k = node.begin; k < node.end; ++k) visit(members_[k]);
                continue;
            }
            const bool second_first = estimate(node.children + 1, p) < estimate(node.children, p);
            stack[count++] = node.children + (second_first ? 0 : 1);
            stack[count++] = node.children + (second_first ? 1 : 0);
        }
    }

 private:
    static constexpr std::size_t kDeepest = 72;  // halves of 2^32 members, twice

    struct Node {
        Box box;
        std::uint32_t begin = 0, end = 0, children = 0;  // the first of two; 0: a leaf
        std::uint32_t least_face = kNoTriangle, least_triangle = kNoTriangle;
        bool is_point = false;
    };

    /// Where the corners of a node lie along a direction.
    struct Strip {
        model::Vec3d across;  ///< unit, at right angles to the mean needle or facet; zero if there is none
        double low = 0, high = 0;

        /// How far p lies beside it; negative inside.
        [[nodiscard]] double gap(const model::Vec3d& p) const {
            const double at = dot(p, across);
            return std::max(low - at, at - high);
        }
        /// True only if every triangle of the node is farther from p than sqrt(squared).
        [[nodiscard]] bool is_farther(const model::Vec3d& p, double reach, double squared) const {
            constexpr double kStripRounding = 1e-14;
            const double least = gap(p) - kStripRounding * reach;
            return least > 0 && least * least > squared;
        }
    };

    static double squared_distance(const Box& box, const model::Vec3d& p) {
        model::Vec3d d;
        for (int k = 0; k < 3; ++k) d[k] = p[k] - std::clamp(p[k], box.low[k], box.high[k]);
        return dot(d, d);
    }
    /// Orders children alone; boxes of needles side by side are all equally near.
    [[nodiscard]] double estimate(std::uint32_t node, const model::Vec3d& p) const {
        const double squared = squared_distance(nodes_[node].box, p);
        if (strips_.empty()) return squared;
        const double gap = strips_[node].gap(p);
        return gap > 0 ? std::max(squared, gap * gap) : squared;
    }
    void fill(const Triangles& triangles, std::uint32_t node);
    [[nodiscard]] Strip strip_of(const Triangles& triangles, const Node& node, Of of) const;
    [[nodiscard]] int longest_axis(const Triangles& triangles, const Node& node) const;

    std::vector<std::uint32_t> members_;
    std::vector<Node> nodes_;
    std::vector<Strip> strips_;  ///< one a node for needles and facets, else none
};

/// Triangles whose boxes share much of the whole's, if a point lies in so many of them that a hierarchy of boxes would
/// look at most for each point: pages that meet at a spine, beams across a hall. Else none.
/// @param apart  marks those that are left out
[[nodiscard]] std::vector<std::uint32_t> crossing_facets(const Triangles& triangles, const std::vector<char>& apart);

}  // namespace dgm::bake
