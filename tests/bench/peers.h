// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/peers.h
// The alternative that an engineer would write: a triangle mesh with a brush, its vertices found by a kd-tree over the
// rest pose or by looking at all of them; nearest vertex, hit, force, Gaussian brush, normals of the touched part.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <nanoflann.hpp>

namespace dgm::bench {

using Vec = std::array<float, 3>;
inline Vec operator-(const Vec& a, const Vec& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline float dot(const Vec& a, const Vec& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

struct Mesh {
    std::vector<Vec> rest, now, normal;
    std::vector<std::array<std::uint32_t, 3>> faces;
    std::vector<std::uint32_t> face_start, face_of;  // faces of each vertex

    Mesh(std::uint32_t n, std::vector<Vec> points) : Mesh(std::move(points), grid_faces(n)) {}
    Mesh(std::vector<Vec> points, std::vector<std::array<std::uint32_t, 3>> triangles)
        : rest(std::move(points)), now(rest), normal(rest.size()), faces(std::move(triangles)) {
        face_start.assign(rest.size() + 1, 0);
        for (const auto& f : faces)
            for (const std::uint32_t v : f) ++face_start[v + 1];
        for (std::size_t v = 1; v < face_start.size(); ++v) face_start[v] += face_start[v - 1];
        face_of.resize(3 * faces.size());
        std::vector<std::uint32_t> at(face_start.begin(), face_start.end() - 1);
        for (std::uint32_t f = 0; f < faces.size(); ++f)
            for (const std::uint32_t v : faces[f]) face_of[at[v]++] = f;
        for (std::uint32_t v = 0; v < rest.size(); ++v) update_normal(v);
    }
    static std::vector<std::array<std::uint32_t, 3>> grid_faces(std::uint32_t n) {
        std::vector<std::array<std::uint32_t, 3>> out;
        for (std::uint32_t i = 0; i + 1 < n; ++i)
            for (std::uint32_t j = 0; j + 1 < n; ++j) {
                const std::uint32_t a = i * n + j, b = a + n, c = b + 1, d = a + 1;
                out.push_back({a, b, c});
                out.push_back({a, c, d});
            }
        return out;
    }
    void update_normal(std::uint32_t v) {
        Vec sum{};
        for (std::uint32_t k = face_start[v]; k < face_start[v + 1]; ++k) {
            const auto& f = faces[face_of[k]];
            const Vec e = now[f[1]] - now[f[0]], g = now[f[2]] - now[f[0]];
            sum[0] += e[1] * g[2] - e[2] * g[1];
            sum[1] += e[2] * g[0] - e[0] * g[2];
            sum[2] += e[0] * g[1] - e[1] * g[0];
        }
        const float inverse = 1 / std::sqrt(dot(sum, sum));
        normal[v] = {sum[0] * inverse, sum[1] * inverse, sum[2] * inverse};
    }
    // nanoflann's view of the rest pose
    [[nodiscard]] std::size_t kdtree_get_point_count() const { return rest.size(); }
    [[nodiscard]] float kdtree_get_pt(std::size_t k, std::size_t axis) const { return rest[k][axis]; }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
        return false;
    }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Mesh>, Mesh, 3>;

class Brush {
 public:
    Brush(Mesh& mesh, bool use_tree, float sigma, float radius)
        : mesh_(mesh), tree_(3, mesh), use_tree_(use_tree), sigma_(sigma), radius_(radius) {
        tree_.buildIndex();
        stamps_.assign(mesh.rest.size(), 0);
    }
    /// @return force along z, so that nothing is optimised away
    float tick(const Vec& tool) {
        stale_.clear();
        ++stamp_;
        for (const auto& [v, d2] : touched_) {
            mesh_.now[v] = mesh_.rest[v];
            stale_around(v);
        }
        std::uint32_t nearest = 0;
        float best = 1e30f;
        if (use_tree_) {
            tree_.knnSearch(tool.data(), 1, &nearest, &best);
        } else {
            for (std::uint32_t v = 0; v < mesh_.rest.size(); ++v) {
                const Vec d = mesh_.rest[v] - tool;
                if (dot(d, d) < best) {
                    best = dot(d, d);
                    nearest = v;
                }
            }
        }
        const Vec at = mesh_.rest[nearest], d = tool - at;
        const bool hit = dot(d, mesh_.normal[nearest]) < 0;
        const float share = std::clamp(d[2] / 4, -1.0f, 1.0f);
        touched_.clear();
        pressed_ += hit ? 1 : 0;
        if (hit) {
            if (use_tree_) {
                tree_.radiusSearch(at.data(), radius_ * radius_, touched_, nanoflann::SearchParams(32, 0, false));
            } else {
                for (std::uint32_t v = 0; v < mesh_.rest.size(); ++v) {
                    const Vec e = mesh_.rest[v] - at;
                    if (dot(e, e) < radius_ * radius_) touched_.emplace_back(v, dot(e, e));
                }
            }
            for (const auto& [v, d2] : touched_) {
                const float w = std::exp(-d2 / sigma_);
                for (int a = 0; a < 3; ++a) mesh_.now[v][a] += w * d[a];
            }
        }
        for (const auto& [v, d2] : touched_) stale_around(v);
        for (const std::uint32_t v : stale_) mesh_.update_normal(v);
        return hit ? -share * share * share : 0;
    }

    [[nodiscard]] long pressed() const { return pressed_; }  ///< ticks that found the tool below the surface

 private:
    long pressed_ = 0;
    /// A vertex that moved and its neighbours need new normals, each once.
    void stale_around(std::uint32_t v) {
        for (std::uint32_t k = mesh_.face_start[v]; k < mesh_.face_start[v + 1]; ++k)
            for (const std::uint32_t c : mesh_.faces[mesh_.face_of[k]])
                if (stamps_[c] != stamp_) {
                    stamps_[c] = stamp_;
                    stale_.push_back(c);
                }
    }

    Mesh& mesh_;
    Tree tree_;
    bool use_tree_;
    float sigma_, radius_;
    std::vector<std::pair<std::uint32_t, float>> touched_;
    std::vector<std::uint32_t> stale_, stamps_;
    std::uint32_t stamp_ = 0;
};

}  // namespace dgm::bench
