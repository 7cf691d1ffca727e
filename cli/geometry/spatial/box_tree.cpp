// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/spatial/box_tree.cpp
#include "geometry/spatial/box_tree.h"

#include <tuple>
#include <utility>

namespace dgm::bake {
namespace {

using model::Vec3d;

constexpr std::uint32_t kLeaf = 4;  // triangles

void extend(BoxTree::Box& box, const Vec3d& p) {
    for (int k = 0; k < 3; ++k) {
        box.low[k] = std::min(box.low[k], p[k]);
        box.high[k] = std::max(box.high[k], p[k]);
    }
}

/// From the longest edge to the third corner; zero for a triangle without area.
Vec3d height_of(const Triangle& tri) {
    const std::array<Vec3d, 3> corners = from_longest_edge(tri);
    const Vec3d edge = corners[1] - corners[0], to_apex = corners[2] - corners[0];
    const double squared = dot(edge, edge);
    return squared > 0 ? normalized(to_apex - edge * (dot(to_apex, edge) / squared), {}) : Vec3d{};
}

}  // namespace

BoxTree::BoxTree(const Triangles& triangles, std::vector<std::uint32_t> members, Of of) : members_(std::move(members)) {
    nodes_.push_back({{}, 0, static_cast<std::uint32_t>(members_.size())});
    // Children are appended, so every node is filled when its turn comes.
    for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
        fill(triangles, n);
        const Node node = nodes_[n];
        if (of != Of::kCrowd) strips_.push_back(strip_of(triangles, node, of));
        if (node.is_point || node.end - node.begin <= kLeaf) continue;
        const int axis = longest_axis(triangles, node);
        const std::uint32_t middle = (node.begin + node.end) / 2;
        const auto key = [&](std::uint32_t t) {
            const Triangle q = triangles[t];
            return std::tuple(q.a[axis] + q.b[axis] + q.c[axis], q.face);
        };
        std::nth_element(members_.begin() + node.begin, members_.begin() + middle, members_.begin() + node.end,
                         [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
        nodes_[n].children = static_cast<std::uint32_t>(nodes_.size());
        nodes_.push_back({{}, node.begin, middle});
        nodes_.push_back({{}, middle, node.end});
    }
}

void BoxTree::fill(const Triangles& triangles, std::uint32_t n) {
    Node& node = nodes_[n];
    node.box = {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
    for (std::uint32_t k = node.begin; k < node.end; ++k) {
        const Triangle q = triangles[members_[k]];
        for (const Vec3d& corner : {q.a, q.b, q.c}) extend(node.box, corner);
        if (q.face < node.least_face) {
            node.least_face = q.face;
            node.least_triangle = members_[k];
        }
    }
    node.is_point = node.box.low == node.box.high;
}

/// Of the triangles' middles: all needles of a node may be as long as it.
int BoxTree::longest_axis(const Triangles& triangles, const Node& node) const {
    Box middles{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
    for (std::uint32_t k = node.begin; k < node.end; ++k) {
        const Triangle q = triangles[members_[k]];
        extend(middles, q.a + q.b + q.c);
    }
    const Vec3d size = middles.high - middles.low;
    return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
}

BoxTree::Strip BoxTree::strip_of(const Triangles& triangles, const Node& node, Of of) const {
    Vec3d sum;
    for (std::uint32_t k = node.begin; k < node.end; ++k) {
        const Triangle q = triangles[members_[k]];
        const Vec3d way = of == Of::kNeedles ? height_of(q) : normalized(q.normal, {});
        sum += dot(sum, way) < 0 ? -way : way;
    }
    Strip out{normalized(sum, {}), 0, 0};
    if (out.across == Vec3d{}) return out;
    out.low = kInfinity;
    out.high = -kInfinity;
    for (std::uint32_t k = node.begin; k < node.end; ++k) {
        const Triangle q = triangles[members_[k]];
        for (const Vec3d& corner : {q.a, q.b, q.c}) {
            out.low = std::min(out.low, dot(corner, out.across));
            out.high = std::max(out.high, dot(corner, out.across));
        }
    }
    return out;
}

std::vector<std::uint32_t> crossing_facets(const Triangles& triangles, const std::vector<char>& apart) {
    constexpr double kLargeBox = 1.0 / 4096, kManyBoxes = 64, kNeedle = 32;  // needles are taken to pieces
    BoxTree::Box whole{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
    for (const Vec3d& corner : triangles.vertices()) extend(whole, corner);
    std::vector<std::uint32_t> out;
    double boxes = 0;  // in which a point lies on average
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        const Triangle q = triangles[t];
        BoxTree::Box box{q.a, q.a};
        extend(box, q.b);
        extend(box, q.c);
        double share = 1;
        for (int k = 0; k < 3; ++k)
            if (whole.high[k] > whole.low[k]) share *= (box.high[k] - box.low[k]) / (whole.high[k] - whole.low[k]);
        if (apart[t] || !(share > kLargeBox)) continue;
        const std::array<Vec3d, 3> corners = from_longest_edge(q);
        const Vec3d edge = corners[1] - corners[0];
        if (dot(edge, edge) > kNeedle * length(q.normal)) continue;
        boxes += share;
        out.push_back(t);
    }
    if (!(boxes > kManyBoxes)) out.clear();
    return out;
}

}  // namespace dgm::bake
