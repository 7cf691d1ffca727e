// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/physics_peers_xpbd.cpp
// Springs by extended position-based dynamics [Macklin, Müller, Chentanez 2016], as an engineer would write it: floats
// in arrays, edges in the order of their samples, sweeps always the same way (others pump energy), multipliers kept
// over the iterations of a step, so that many of them are the implicit step; on request the volume as one more
// constraint.
#include <algorithm>
#include <set>

#include "physics_peers.h"

namespace dgm::bench {

Springs make_springs(const PhysicsMap& map, const Material& material, double reach) {
    const State state = map.state();
    Springs s;
    s.node_of.assign(state.sample_count(), 0);
    std::vector<std::uint32_t> corners(value_of(mesh_counts(state)).indices);
    (void)value_of(reconstruct(state, {}, corners));
    const PointView rest = state.rest_positions();
    std::vector<std::uint32_t> node(state.sample_count(), kNone);
    for (std::uint32_t k = 0; k < state.sample_count(); ++k) {
        const std::uint32_t id = state.class_of(k), first = id == kNone ? k : state.class_members(id)[0];
        if (node[first] == kNone) {
            node[first] = static_cast<std::uint32_t>(s.rest.size());
            const Vec3 p = rest[first];
            s.rest.push_back({map.metres() * double{p.x}, map.metres() * double{p.y}, map.metres() * double{p.z}});
            s.sample_of.push_back(first);
        }
        s.node_of[k] = node[first];
    }
    s.mass.assign(s.rest.size(), 0);
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (std::size_t k = 0; k < corners.size(); k += 3) {
        const std::array<std::uint32_t, 3> f{s.node_of[corners[k]], s.node_of[corners[k + 1]],
                                             s.node_of[corners[k + 2]]};
        if (f[0] == f[1] || f[1] == f[2] || f[2] == f[0]) continue;
        s.faces.push_back(f);
        Point u, v;
        for (std::size_t c = 0; c < 3; ++c) {
            u[c] = s.rest[f[1]][c] - s.rest[f[0]][c];
            v[c] = s.rest[f[2]][c] - s.rest[f[0]][c];
        }
        const double area =
            0.5 * std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
        for (std::size_t c = 0; c < 3; ++c) {
            s.mass[f[c]] += area * double{material.density} / 3;
            edges.insert(std::minmax(f[c], f[(c + 1) % 3]));
        }
    }
    s.edges.assign(edges.begin(), edges.end());
    s.stiffness = 0.8660254037844386 * double{material.membrane};  // of a lattice of equilateral triangles
    const Point& top = s.rest[s.node_of[map.top()]];
    for (std::size_t k = 0; k < s.rest.size(); ++k)
        if (std::hypot(s.rest[k][0] - top[0], s.rest[k][1] - top[1], s.rest[k][2] - top[2]) < reach) s.mass[k] = 0;
    return s;
}

double volume_of(const Springs& s, const Points& at) {
    double sum = 0;
    for (const auto& f : s.faces) {
        const Point &a = at[f[0]], &b = at[f[1]], &c = at[f[2]];
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
               a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum / 6;
}

namespace {
class Xpbd final : public Solver {
 public:
    Xpbd(const Springs& s, double dt, bool volume) : springs_(s), dt_(static_cast<float>(dt)), keeps_volume_(volume) {
        for (const Point& p : s.rest) now_.push_back({float(p[0]), float(p[1]), float(p[2])});
        speed_.assign(now_.size(), {});
        before_ = now_;
        gradient_.assign(now_.size(), {});
        for (const double m : s.mass) inverse_.push_back(m > 0 ? float(1 / m) : 0.0F);
        for (const auto& [a, b] : s.edges) {
            const V w = now_[a] - now_[b];
            edges_.push_back({a, b, std::sqrt(dot(w, w)), 0, inverse_[a] + inverse_[b]});
        }
        rest_volume_ = volume_now();
    }
    void step(const Point& offset, std::uint32_t effort) override {
        before_ = now_;
        for (std::size_t k = 0; k < now_.size(); ++k) {
            if (inverse_[k] > 0)
                now_[k] = now_[k] + dt_ * speed_[k];
            else
                now_[k] = {float(springs_.rest[k][0] + offset[0]), float(springs_.rest[k][1] + offset[1]),
                           float(springs_.rest[k][2] + offset[2])};
        }
        for (Edge& e : edges_) e.multiplier = 0;
        const float compliance = static_cast<float>(1 / (springs_.stiffness * double{dt_} * double{dt_}));
        for (std::uint32_t k = 0; k < effort; ++k) {
            sweep(compliance);
            if (keeps_volume_) restore_volume();
        }
        for (std::size_t k = 0; k < now_.size(); ++k) speed_[k] = (1 / dt_) * (now_[k] - before_[k]);
    }
    [[nodiscard]] Points points() const override {
        Points out;
        for (const V& v : now_) out.push_back({v.x, v.y, v.z});
        return out;
    }

 private:
    using V = Vec3;
    struct Edge {
        std::uint32_t a, b;
        float rest, multiplier, mobility;
    };
    void sweep(float compliance) {
        for (Edge& e : edges_) {
            const V way = now_[e.a] - now_[e.b];
            const float length = std::sqrt(dot(way, way));
            if (!(e.mobility > 0) || !(length > 0)) continue;
            const float change = (e.rest - length - compliance * e.multiplier) / (e.mobility + compliance);
            e.multiplier += change;
            const V push = (change / length) * way;
            now_[e.a] = now_[e.a] + inverse_[e.a] * push;
            now_[e.b] = now_[e.b] - inverse_[e.b] * push;
        }
    }
    static V cross(V a, V b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
    [[nodiscard]] float volume_now() const {
        double sum = 0;
        for (const auto& f : springs_.faces) sum += double{dot(now_[f[0]], cross(now_[f[1]], now_[f[2]]))};
        return static_cast<float>(sum / 6);
    }
    void restore_volume() {
        std::fill(gradient_.begin(), gradient_.end(), V{});
        double sum = 0;
        for (const auto& f : springs_.faces) {
            const V &a = now_[f[0]], &b = now_[f[1]], &c = now_[f[2]], bc = cross(b, c);
            sum += double{dot(a, bc)};
            gradient_[f[0]] = gradient_[f[0]] + bc;
            gradient_[f[1]] = gradient_[f[1]] + cross(c, a);
            gradient_[f[2]] = gradient_[f[2]] + cross(a, b);
        }
        double slope = 0;
        for (std::size_t k = 0; k < now_.size(); ++k)
            slope += double{inverse_[k]} * double{dot(gradient_[k], gradient_[k])};
        const auto by = static_cast<float>(6 * (6 * double{rest_volume_} - sum) / 6 / slope);
        for (std::size_t k = 0; k < now_.size(); ++k) now_[k] = now_[k] + by * inverse_[k] * gradient_[k];
    }
    const Springs& springs_;
    float dt_, rest_volume_ = 0;
    bool keeps_volume_;
    std::vector<V> now_, before_, speed_, gradient_;
    std::vector<float> inverse_;
    std::vector<Edge> edges_;
};
}  // namespace

std::unique_ptr<Solver> make_xpbd(const PhysicsMap&, const Springs& s, double dt) {
    return std::make_unique<Xpbd>(s, dt, false);
}
std::unique_ptr<Solver> make_xpbd_with_volume(const PhysicsMap&, const Springs& s, double dt) {
    return std::make_unique<Xpbd>(s, dt, true);
}

}  // namespace dgm::bench
