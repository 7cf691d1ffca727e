// SPDX-License-Identifier: GPL-3.0-or-later
// tests/reference/refit.cpp
#include "reference/refit.h"

#include <tbb/parallel_for.h>

#include <Eigen/Sparse>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "geometry/mesh/triangle.h"

namespace dgm::bench {
namespace {
using bake::ClosestPoint;
using bake::ClosestPointIndex;
using bake::SurfaceError;
using model::Face;
using model::TriMesh;
using model::Vec3d;

constexpr std::size_t kPointsOfVertex = 12;  // of the mesh, on the source
constexpr double kDamping = 1e-3;            // of a vertex's own weight
constexpr double kGainOfFlip = 0.98, kUpright = 0.3;
constexpr double kEnough = 0.9975;  // in rms, of a round that is worth another: 0.02 dB
constexpr std::uint64_t kMeasured = 40'000;

struct Point {
    Vec3d at;
    double weight;
};

/// Points spread evenly over each face, at least one, with the area that each stands for.
std::vector<Point> points_of(const TriMesh& mesh, std::size_t wanted) {
    double total = 0;
    std::vector<double> areas;
    for (const Face& f : mesh.faces) {
        areas.push_back(bake::face_area({mesh.positions[f[0]], mesh.positions[f[1]], mesh.positions[f[2]]}));
        total += areas.back();
    }
    std::vector<Point> out;
    for (std::size_t f = 0; f < areas.size(); ++f) {
        const Vec3d &p = mesh.positions[mesh.faces[f][0]], a = mesh.positions[mesh.faces[f][1]] - p,
                    b = mesh.positions[mesh.faces[f][2]] - p;
        const auto count = std::max(1.0, std::round(areas[f] / total * static_cast<double>(wanted)));
        for (double k = 0.5; k < count; ++k) {  // a rank-1 lattice, folded into the triangle
            double u = count > 1 ? k / count : 1.0 / 3,
                   v = count > 1 ? std::fmod(k * 0.7548776662466927, 1.0) : 1.0 / 3;
            if (u + v > 1) {
                u = 1 - u;
                v = 1 - v;
            }
            out.push_back({p + a * u + b * v, areas[f] / count});
        }
    }
    return out;
}

double rms_of(const TriMesh& source, const ClosestPointIndex& index, const TriMesh& mesh,
              SurfaceError* whole = nullptr) {
    bake::SurfaceErrorOptions options;
    options.samples = kMeasured;
    options.source_index = &index;
    const SurfaceError error = bake::measure_surface_error(source, mesh, options);
    if (whole != nullptr) *whole = error;
    return error.rms;
}

std::array<Vec3d, 3> corners(const TriMesh& mesh, const Face& f) {
    return {mesh.positions[f[0]], mesh.positions[f[1]], mesh.positions[f[2]]};
}

Vec3d face_normal(const std::array<Vec3d, 3>& q) {
    return normalized(cross(q[1] - q[0], q[2] - q[0]), Vec3d{});
}

std::vector<char> border_vertices(const TriMesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
    for (const Face& f : mesh.faces)
        for (std::size_t k = 0; k < 3; ++k) ++uses[std::minmax(f[k], f[(k + 1) % 3])];
    std::vector<char> out(mesh.positions.size(), 0);
    for (const auto& [edge, count] : uses)
        if (count == 1) out[edge.first] = out[edge.second] = 1;
    return out;
}

/// Rows  n . (sum of b x step) = n . gap  of least squares, and their normal equations.
class Equations {
 public:
    explicit Equations(const TriMesh& mesh, const std::vector<char>& held)
        : mesh_(mesh), held_(held), right_(Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(held.size()))) {}

    void add(std::uint32_t face, const double (&b)[3], const Vec3d& gap, const Vec3d& otherwise, double weight) {
        const double far = length(gap);
        const Vec3d n = far > 1e-14 ? gap * (1 / far) : otherwise;
        const std::array<double, 3> normal{n.x, n.y, n.z};
        const Face& f = mesh_.faces[face];
        for (std::size_t i = 0; i < 3; ++i) {
            if (held_[f[i]]) continue;
            for (int r = 0; r < 3; ++r) {
                const auto row = static_cast<Eigen::Index>(3 * f[i]) + r;
                right_[row] += weight * b[i] * normal[r] * dot(n, gap);
                for (std::size_t j = 0; j < 3; ++j) {
                    if (held_[f[j]]) continue;
                    for (int c = 0; c < 3; ++c)
                        entries_.emplace_back(row, static_cast<Eigen::Index>(3 * f[j]) + c,
                                              weight * b[i] * b[j] * normal[r] * normal[c]);
                }
            }
        }
    }

    std::vector<Vec3d> solve() {
        const Eigen::Index n = right_.size();
        Eigen::SparseMatrix<double> a(n, n);
        a.setFromTriplets(entries_.begin(), entries_.end());
        for (Eigen::Index v = 0; v < n; v += 3) {
            const double trace = a.coeff(v, v) + a.coeff(v + 1, v + 1) + a.coeff(v + 2, v + 2);
            for (Eigen::Index r = 0; r < 3; ++r) a.coeffRef(v + r, v + r) += kDamping * trace + 1e-300;
        }
        for (Eigen::Index v = 0; v < n; ++v)
            if (held_[static_cast<std::size_t>(v / 3)]) a.coeffRef(v, v) = 1;
        Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper> solver;
        solver.setTolerance(1e-4);
        solver.setMaxIterations(200);
        solver.compute(a);
        const Eigen::VectorXd x = solver.solve(right_);
        std::vector<Vec3d> out;
        for (Eigen::Index v = 0; v < n; v += 3) out.push_back({x[v], x[v + 1], x[v + 2]});
        return out;
    }

 private:
    const TriMesh& mesh_;
    const std::vector<char>& held_;
    std::vector<Eigen::Triplet<double>> entries_;
    Eigen::VectorXd right_;
};

class Refit {
 public:
    Refit(const TriMesh& source, const ClosestPointIndex& index, TriMesh mesh)
        : source_(source), index_(index), points_(points_of(source, kPointsOfVertex * mesh.positions.size())) {
        out_.mesh = std::move(mesh);
        held_ = border_vertices(out_.mesh);
        rms_ = rms_of(source_, index_, out_.mesh, &out_.before);
    }

    Refitted run(int rounds) && {
        for (int round = 0; round < rounds; ++round) {
            const double before = rms_;
            match();
            move();
            match();
            flip();
            if (!(rms_ < kEnough * before)) break;
            ++out_.rounds;
        }
        rms_of(source_, index_, out_.mesh, &out_.after);
        return std::move(out_);
    }

 private:
    void match() {
        const ClosestPointIndex own(out_.mesh.positions, out_.mesh.faces);
        hits_.resize(points_.size());
        tbb::parallel_for(std::size_t{0}, points_.size(), [&](std::size_t k) { hits_[k] = own.query(points_[k].at); });
    }

    /// Points of a face with the share of its area: corners 1/20, edge middles 2/15, centre 9/20, right to degree 3.
    template <class Body>
    static void for_each_node(const Body& body) {
        for (std::size_t k = 0; k < 3; ++k) {
            double corner[3] = {0, 0, 0}, middle[3] = {0, 0, 0};
            corner[k] = 1;
            middle[k] = middle[(k + 1) % 3] = 0.5;
            body(corner, 1.0 / 20);
            body(middle, 2.0 / 15);
        }
        body({1.0 / 3, 1.0 / 3, 1.0 / 3}, 9.0 / 20);
    }

    void move() {
        const TriMesh& mesh = out_.mesh;
        Equations equations(mesh, held_);
        for (std::size_t k = 0; k < points_.size(); ++k) {
            const ClosestPoint& hit = hits_[k];
            if (hit.face == ClosestPointIndex::kNoFace) continue;
            equations.add(hit.face, hit.barycentric, points_[k].at - hit.point,
                          face_normal(corners(mesh, mesh.faces[hit.face])), points_[k].weight);
        }
        for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
            const auto q = corners(mesh, mesh.faces[f]);
            const double area = bake::face_area(q);
            for_each_node([&](const double(&b)[3], double share) {
                const Vec3d at = q[0] * b[0] + q[1] * b[1] + q[2] * b[2];
                const ClosestPoint hit = index_.query(at);
                if (hit.face != ClosestPointIndex::kNoFace)
                    equations.add(f, b, hit.point - at, index_.unit_normal(hit.face), share * area);
            });
        }
        const std::vector<Vec3d> step = equations.solve();
        for (const double share : {1.0, 0.5, 0.25}) {
            TriMesh moved = mesh;
            for (std::size_t v = 0; v < step.size(); ++v) moved.positions[v] += step[v] * share;
            if (inverts(moved)) leave_inverted(moved);
            if (keep_if_better(std::move(moved))) return;
        }
    }

    [[nodiscard]] bool inverts(const TriMesh& moved) const {
        return std::any_of(moved.faces.begin(), moved.faces.end(), [&](const Face& f) { return inverted(moved, f); });
    }
    [[nodiscard]] bool inverted(const TriMesh& moved, const Face& f) const {
        return dot(face_normal(corners(moved, f)), face_normal(corners(out_.mesh, f))) < kUpright;
    }
    /// Vertices of faces that turn stay where they were, until none turns.
    void leave_inverted(TriMesh& moved) const {
        for (bool again = true; again;) {
            again = false;
            for (const Face& f : moved.faces)
                if (inverted(moved, f))
                    for (const std::uint32_t v : f) {
                        again = again || !(moved.positions[v] == out_.mesh.positions[v]);
                        moved.positions[v] = out_.mesh.positions[v];
                    }
        }
    }

    bool keep_if_better(TriMesh mesh) {
        const double rms = rms_of(source_, index_, mesh);
        if (!(rms < rms_)) return false;
        rms_ = rms;
        out_.mesh = std::move(mesh);
        return true;
    }

    /// Squared distances of points to the nearer of two triangles, and of the triangles' centres to the source.
    [[nodiscard]] double cost(const TriMesh& mesh, const std::array<Face, 2>& two,
                              const std::array<const std::vector<std::uint32_t>*, 2>& over) const {
        double sum = 0, both = 0;
        const std::array<std::array<Vec3d, 3>, 2> q{corners(mesh, two[0]), corners(mesh, two[1])};
        for (const auto* list : over)
            for (const std::uint32_t k : *list) {
                std::array<double, 3> b{};
                sum += points_[k].weight * std::min(bake::closest_on_triangle(points_[k].at, q[0], b),
                                                    bake::closest_on_triangle(points_[k].at, q[1], b));
            }
        for (const auto& t : q) {
            const double area = bake::face_area(t);
            both += area;
            for_each_node([&](const double(&b)[3], double share) {
                const double d = index_.query(t[0] * b[0] + t[1] * b[1] + t[2] * b[2]).distance;
                sum += share * area * d * d;
            });
        }
        return both > 0 ? sum : INFINITY;
    }

    void flip() {
        TriMesh mesh = out_.mesh;
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> edges;
        for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
            for (std::size_t k = 0; k < 3; ++k)
                edges[std::minmax(mesh.faces[f][k], mesh.faces[f][(k + 1) % 3])].push_back(f);
        std::vector<std::vector<std::uint32_t>> over(mesh.faces.size());
        for (std::uint32_t k = 0; k < hits_.size(); ++k)
            if (hits_[k].face != ClosestPointIndex::kNoFace) over[hits_[k].face].push_back(k);
        std::vector<char> done(mesh.faces.size(), 0);
        std::map<std::pair<std::uint32_t, std::uint32_t>, char> made;
        int flips = 0;
        for (const auto& [edge, faces] : edges) {
            if (faces.size() != 2 || done[faces[0]] || done[faces[1]]) continue;
            const Face f = mesh.faces[faces[0]], g = mesh.faces[faces[1]];
            std::size_t k = 0;
            while (f[k] == edge.first || f[k] == edge.second) ++k;
            const std::uint32_t c = f[k], a = f[(k + 1) % 3], b = f[(k + 2) % 3], d = g[0] + g[1] + g[2] - a - b;
            const auto across = std::minmax(c, d);
            if (c == d || edges.count(across) != 0 || made.count(across) != 0) continue;
            const std::array<Face, 2> now{f, g}, then{Face{c, a, d}, Face{c, d, b}};
            const Vec3d up = normalized(face_normal(corners(mesh, f)) + face_normal(corners(mesh, g)), Vec3d{});
            if (std::min(dot(up, face_normal(corners(mesh, then[0]))), dot(up, face_normal(corners(mesh, then[1])))) <
                kUpright)
                continue;
            if (!(cost(mesh, then, {&over[faces[0]], &over[faces[1]]}) <
                  kGainOfFlip * cost(mesh, now, {&over[faces[0]], &over[faces[1]]})))
                continue;
            mesh.faces[faces[0]] = then[0];
            mesh.faces[faces[1]] = then[1];
            done[faces[0]] = done[faces[1]] = made[across] = 1;
            ++flips;
        }
        if (flips > 0 && keep_if_better(std::move(mesh))) out_.flips += flips;
    }

    const TriMesh& source_;
    const ClosestPointIndex& index_;
    std::vector<Point> points_;
    std::vector<ClosestPoint> hits_;
    std::vector<char> held_;
    double rms_ = 0;
    Refitted out_;
};

}  // namespace

Refitted refit(const TriMesh& source, const ClosestPointIndex& index, TriMesh mesh, int rounds) {
    return Refit(source, index, std::move(mesh)).run(rounds);
}

}  // namespace dgm::bench
