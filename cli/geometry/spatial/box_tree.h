// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/spatial/box_tree.h
// A hierarchy of double-precision boxes over triangles that lie close together.
//
// Embree's boxes are floats: of triangles within 1e-6 diagonals of each other a distant query would look at each, and a
// map that crowds its samples at one place has thousands of them. Doubles tell them apart, and triangles that are one
// and the same point need one look in all.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/spatial/triangle_distance.h"

namespace dgm::bake {

class BoxTree {
 public:
    struct Box {
        model::Vec3d low, high;
    };

    /// @param members  indices into `triangles`; read here only
    BoxTree(std::span<const Triangle> triangles, std::vector<std::uint32_t> members);

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
            const Node& node = nodes_[stack[--count]];
            const double squared = squared_distance(node.box, p);
            if (node.is_point) {
                if (squared < nearest.squared || (squared == nearest.squared && node.least_face < nearest.face))
                    visit(node.least_triangle);
                continue;
            }
            const double reached = std::sqrt(nearest.squared) + kRounding * reach;
            if (squared > reached * reached * (1 + kRounding)) continue;
            if (node.children == 0) {
                for (std::uint32_t k = node.begin; k < node.end; ++k) visit(members_[k]);
                continue;
            }
            const bool second_first =
                squared_distance(nodes_[node.children + 1].box, p) < squared_distance(nodes_[node.children].box, p);
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

    static double squared_distance(const Box& box, const model::Vec3d& p) {
        model::Vec3d d;
        for (int k = 0; k < 3; ++k) d[k] = p[k] - std::clamp(p[k], box.low[k], box.high[k]);
        return dot(d, d);
    }
    void fill(std::span<const Triangle> triangles, std::uint32_t node);

    std::vector<std::uint32_t> members_;
    std::vector<Node> nodes_;
};

}  // namespace dgm::bake
