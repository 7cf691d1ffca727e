// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/implicit_surface.cpp
// [Gibson 1998] Gibson. Constrained elastic surface nets. MICCAI 1998.
// Our choice: instead of elastic constraints, a vertex is pulled towards its neighbours' mean and then stepped back to
// the zero set along the gradient, so only tangential motion remains and the triangles even out.
#include "implicit_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace dgm::samples {
namespace {
using model::Vec3d;

constexpr double kDifference = 1e-3;  // step of the central differences, in centimetres
constexpr int kSmoothingRounds = 12;
constexpr std::uint32_t kNone = 0xffffffffU;

Vec3d gradient(const Field& f, const Vec3d& p) {
    const double h = kDifference;
    return Vec3d{f({p.x + h, p.y, p.z}) - f({p.x - h, p.y, p.z}), f({p.x, p.y + h, p.z}) - f({p.x, p.y - h, p.z}),
                 f({p.x, p.y, p.z + h}) - f({p.x, p.y, p.z - h})} /
           (2 * h);
}

Vec3d project(const Field& f, Vec3d p, int steps, double reach) {
    for (int k = 0; k < steps; ++k) {
        const Vec3d g = gradient(f, p);
        const double slope = std::max(dot(g, g), 0.05);
        p -= g * std::clamp(f(p) / slope, -reach, reach);
    }
    return p;
}

/// Lattice values, and the one net vertex of each cell the surface passes through.
class SurfaceNet {
 public:
    SurfaceNet(const Field& field, const Lattice& lattice) : lattice_(lattice) {
        for (int k = 0; k < 3; ++k)
            n_[k] = static_cast<int>(std::ceil((lattice.high[k] - lattice.low[k]) / lattice.cell)) + 1;
        value_.resize(static_cast<std::size_t>(n_[0]) * n_[1] * n_[2]);
        cell_vertex_.assign(value_.size(), kNone);
        visit([&](int x, int y, int z) { value_[index(x, y, z)] = field(node(x, y, z)); }, 0);
        visit([&](int x, int y, int z) { add_vertex(x, y, z); }, 1);
        visit([&](int x, int y, int z) { add_quads(x, y, z); }, 1);
    }
    std::vector<Vec3d> positions;
    std::vector<std::array<std::uint32_t, 4>> quads;

 private:
    template <class Fn>
    void visit(Fn&& fn, int margin) const {
        for (int z = 0; z < n_[2] - margin; ++z)
            for (int y = 0; y < n_[1] - margin; ++y)
                for (int x = 0; x < n_[0] - margin; ++x) fn(x, y, z);
    }
    [[nodiscard]] std::size_t index(int x, int y, int z) const {
        return (static_cast<std::size_t>(z) * n_[1] + static_cast<std::size_t>(y)) * n_[0] +
               static_cast<std::size_t>(x);
    }
    [[nodiscard]] Vec3d node(int x, int y, int z) const {
        return lattice_.low + Vec3d{x * 1.0, y * 1.0, z * 1.0} * lattice_.cell;
    }

    void add_vertex(int x, int y, int z) {
        Vec3d sum;
        int crossings = 0;
        const auto edge = [&](std::array<int, 3> a, int axis) {
            std::array<int, 3> b = a;
            ++b[static_cast<std::size_t>(axis)];
            const double va = value_[index(a[0], a[1], a[2])], vb = value_[index(b[0], b[1], b[2])];
            if ((va < 0) == (vb < 0)) return;
            const Vec3d pa = node(a[0], a[1], a[2]);
            sum += pa + (node(b[0], b[1], b[2]) - pa) * (va / (va - vb));
            ++crossings;
        };
        for (int s = 0; s < 2; ++s)
            for (int t = 0; t < 2; ++t) {
                edge({x, y + s, z + t}, 0);
                edge({x + s, y, z + t}, 1);
                edge({x + s, y + t, z}, 2);
            }
        if (crossings == 0) return;
        cell_vertex_[index(x, y, z)] = static_cast<std::uint32_t>(positions.size());
        positions.push_back(sum / crossings);
    }

    // One quad for each lattice edge out of (x, y, z) that the surface crosses, around the four cells of that edge.
    void add_quads(int x, int y, int z) {
        const std::array<int, 3> at{x, y, z};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
            std::array<int, 3> far = at;
            ++far[axis];
            const bool inside = value_[index(x, y, z)] < 0;
            if (at[u] == 0 || at[v] == 0 || inside == (value_[index(far[0], far[1], far[2])] < 0)) continue;
            std::array<std::uint32_t, 4> quad{};
            constexpr std::array<std::array<int, 2>, 4> kAround{{{-1, -1}, {0, -1}, {0, 0}, {-1, 0}}};
            for (std::size_t k = 0; k < 4; ++k) {
                std::array<int, 3> c = at;
                c[u] += kAround[k][0];
                c[v] += kAround[k][1];
                quad[k] = cell_vertex_[index(c[0], c[1], c[2])];
            }
            if (!inside) std::reverse(quad.begin(), quad.end());
            quads.push_back(quad);
        }
    }

    Lattice lattice_;
    std::array<int, 3> n_{};
    std::vector<double> value_;
    std::vector<std::uint32_t> cell_vertex_;
};

void even_out(const Field& field, SurfaceNet& net, double cell) {
    for (int round = 0; round < kSmoothingRounds; ++round) {
        std::vector<Vec3d> sum(net.positions.size());
        std::vector<int> count(net.positions.size());
        for (const auto& q : net.quads)
            for (std::size_t k = 0; k < 4; ++k) {  // each edge is met from both its quads, so each counts twice
                sum[q[k]] += net.positions[q[(k + 1) % 4]] + net.positions[q[(k + 3) % 4]];
                count[q[k]] += 2;
            }
        for (std::size_t v = 0; v < net.positions.size(); ++v) {
            const Vec3d p = net.positions[v] * 0.4 + sum[v] * (0.6 / count[v]);
            net.positions[v] = project(field, p, round + 1 == kSmoothingRounds ? 4 : 1, 0.5 * cell);
        }
    }
}
}  // namespace

Vec3d field_normal(const Field& field, const Vec3d& p) {
    return normalized(gradient(field, p));
}

double smooth_min(double a, double b, double k) {
    const double h = std::max(k - std::abs(a - b), 0.0) / k;
    return std::min(a, b) - h * h * k / 4;
}

PolyMesh mesh_zero_set(const Field& field, const Lattice& lattice) {
    SurfaceNet net(field, lattice);
    even_out(field, net, lattice.cell);
    PolyMesh mesh;
    mesh.positions = net.positions;
    quantise(mesh);
    const auto add = [&mesh](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        Polygon p;
        p.vertex = {a, b, c, 0};
        p.n = 3;
        mesh.polygons.push_back(p);
    };
    for (const auto& q : net.quads) {
        const auto span = [&](int a, int b) {
            return length(mesh.positions[q[static_cast<std::size_t>(a)]] -
                          mesh.positions[q[static_cast<std::size_t>(b)]]);
        };
        if (span(0, 2) <= span(1, 3)) {
            add(q[0], q[1], q[2]);
            add(q[0], q[2], q[3]);
        } else {
            add(q[0], q[1], q[3]);
            add(q[1], q[2], q[3]);
        }
    }
    return mesh;
}

}  // namespace dgm::samples
