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

}  // namespace

BoxTree::BoxTree(std::span<const Triangle> triangles, std::vector<std::uint32_t> members)
    : members_(std::move(members)) {
    nodes_.push_back({{}, 0, static_cast<std::uint32_t>(members_.size())});
    // Children are appended, so every node is filled when its turn comes.
    for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
        fill(triangles, n);
        const Node node = nodes_[n];
        if (node.is_point || node.end - node.begin <= kLeaf) continue;
        const Vec3d size = node.box.high - node.box.low;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const std::uint32_t middle = (node.begin + node.end) / 2;
        const auto key = [&](std::uint32_t t) {
            const Triangle& q = triangles[t];
            return std::tuple(q.a[axis] + q.b[axis] + q.c[axis], q.face);
        };
        std::nth_element(members_.begin() + node.begin, members_.begin() + middle, members_.begin() + node.end,
                         [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
        nodes_[n].children = static_cast<std::uint32_t>(nodes_.size());
        nodes_.push_back({{}, node.begin, middle});
        nodes_.push_back({{}, middle, node.end});
    }
}

void BoxTree::fill(std::span<const Triangle> triangles, std::uint32_t n) {
    Node& node = nodes_[n];
    node.box = {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
    for (std::uint32_t k = node.begin; k < node.end; ++k) {
        const Triangle& q = triangles[members_[k]];
        for (const Vec3d& corner : {q.a, q.b, q.c}) extend(node.box, corner);
        if (q.face < node.least_face) {
            node.least_face = q.face;
            node.least_triangle = members_[k];
        }
    }
    node.is_point = node.box.low == node.box.high;
}

}  // namespace dgm::bake
