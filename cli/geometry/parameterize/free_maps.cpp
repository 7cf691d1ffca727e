// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/free_maps.cpp
// [Levy 2002] Levy, Petitjean, Ray, Maillot. Least Squares Conformal Maps for Automatic Texture Atlas Generation.
//             SIGGRAPH 2002.
// [Liu 2008]  Liu, Zhang, Xu, Gotsman, Gortler. A Local/Global Approach to Mesh Parameterization. SGP 2008.
// [Peng 2018] Peng, Deng, Zhang, Geng, Qin, Liu. Anderson Acceleration for Geometry Optimization and Physics
//             Simulation. SIGGRAPH 2018.
#include "geometry/parameterize/free_maps.h"

#include <Eigen/Dense>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "geometry/parameterize/rest_shapes.h"
#include "geometry/solve/sparse_cholesky.h"
#include "math/portable.h"

namespace dgm::bake {
namespace {
using SparseMatrix = Eigen::SparseMatrix<double>;

constexpr double kThinnest = 1e-6;          // height over longest edge of a rest shape
constexpr std::size_t kLargeMesh = 50'000;  // vertices from which nested dissection pays for one factorization, too
constexpr int kWindow = 5;                  // earlier steps that Anderson's method combines

[[noreturn]] void fail(const std::string& what) {
    throw model::Error(model::codes::kMapInvalid, what);
}

Ordering ordering_of(const DiskView& disk, bool used_often) {
    return used_often || disk.positions.size() > kLargeMesh ? Ordering::kNestedDissection : Ordering::kMinimumDegree;
}

/// Symmetric matrix of face terms over unknowns; `unknown` < 0 leaves a vertex out. One block of `block` rows each.
class Assembly {
 public:
    Assembly(std::vector<int> unknown, int count, int block, std::size_t faces)
        : unknown_(std::move(unknown)), rows_(count * block), block_(block) {
        entries_.reserve(faces * static_cast<std::size_t>(block == 1 ? 6 : 21));
    }

    /// Adds `value` to the entry of vertices i, j and components p, q; entries above the diagonal are dropped, as each
    /// pair is named both ways.
    void add(std::uint32_t i, int p, std::uint32_t j, int q, double value) {
        if (unknown_[i] < 0 || unknown_[j] < 0) return;
        const int row = unknown_[i] * block_ + p, col = unknown_[j] * block_ + q;
        if (row >= col) entries_.emplace_back(row, col, value);
    }
    [[nodiscard]] SparseMatrix matrix() const {
        SparseMatrix m(rows_, rows_);
        m.setFromTriplets(entries_.begin(), entries_.end());
        return m;
    }
    [[nodiscard]] int unknown(std::uint32_t v) const { return unknown_[v]; }

 private:
    std::vector<int> unknown_;
    int rows_, block_;
    std::vector<Eigen::Triplet<double>> entries_;
};

/// Numbers the vertices that are not fixed.
std::vector<int> number_free(const std::vector<std::uint8_t>& fixed, int& count) {
    std::vector<int> unknown(fixed.size(), -1);
    count = 0;
    for (std::size_t v = 0; v < fixed.size(); ++v)
        if (fixed[v] == 0) unknown[v] = count++;
    return unknown;
}

struct Pins {
    std::uint32_t low = 0, high = 0;
    Vec2d at_low, at_high;
};

/// CGAL's rule (Two_vertices_parameterizer_3), ties included.
Pins choose_pins(const DiskView& disk) {
    Vec3d lo = disk.positions[0], hi = lo;
    for (const Vec3d& p : disk.positions)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], p[k]);
            hi[k] = std::max(hi[k], p[k]);
        }
    const Vec3d size = hi - lo;
    const int shortest = size[0] < size[1] && size[0] < size[2] ? 0 : size[1] < size[0] && size[1] < size[2] ? 1 : 2;
    const int a = shortest == 0 ? 1 : 0, b = shortest == 2 ? 1 : 2;
    // CGAL takes the later of two equal axes, except for (x, y) when z is shortest: there, too, the second.
    const int longest = size[a] > size[b] ? a : b, second = longest == a ? b : a;
    const auto place = [&](const Vec3d& p) {
        const auto along = [&](int axis) { return size[axis] > 0 ? (p[axis] - lo[axis]) / size[axis] : 0.0; };
        return Vec2d{along(longest), along(second)};
    };
    Pins pins;
    pins.at_low = pins.at_high = place(disk.positions[0]);
    for (std::uint32_t v = 1; v < disk.positions.size(); ++v) {
        const Vec2d p = place(disk.positions[v]);
        if (p.x < pins.at_low.x || (p.x == pins.at_low.x && p.y < pins.at_low.y)) {
            pins.low = v;
            pins.at_low = p;
        }
        if (p.x > pins.at_high.x || (p.x == pins.at_high.x && p.y > pins.at_high.y)) {
            pins.high = v;
            pins.at_high = p;
        }
    }
    return pins;
}

/// J = [[a, b], [c, d]] of a face.
struct Jacobian {
    double a, b, c, d;
};

Jacobian jacobian(const RestShape& rest, const Face& f, const double* u, const double* v) {
    Jacobian j{};
    for (std::size_t k = 0; k < 3; ++k) {
        j.a += u[f[k]] * rest.hat[k].x;
        j.b += u[f[k]] * rest.hat[k].y;
        j.c += v[f[k]] * rest.hat[k].x;
        j.d += v[f[k]] * rest.hat[k].y;
    }
    return j;
}

/// The local/global iteration: x holds u of all vertices, then v.
class LocalGlobal {
 public:
    explicit LocalGlobal(const DiskView& disk)
        : faces_(disk.faces), n_(static_cast<Eigen::Index>(disk.positions.size())), rest_(rest_shapes(disk)) {
        for (const RestShape& r : rest_) total_ += r.area;
        // The energy does not change when all vertices move by one vector: the first one stays.
        std::vector<std::uint8_t> fixed(disk.positions.size(), 0);
        fixed[0] = 1;
        int count = 0;
        std::vector<int> unknown = number_free(fixed, count);
        Assembly assembly(std::move(unknown), count, 1, faces_.size());
        for (std::size_t f = 0; f < faces_.size(); ++f)
            for (std::size_t i = 0; i < 3; ++i)
                for (std::size_t j = 0; j < 3; ++j)
                    assembly.add(faces_[f][i], 0, faces_[f][j], 0,
                                 rest_[f].area * dot(rest_[f].hat[i], rest_[f].hat[j]));
        const SparseMatrix matrix = assembly.matrix();
        solver_.analyze(matrix, ordering_of(disk, true));
        if (!solver_.factorize(matrix)) fail("arap: the Laplacian of the surface cannot be factorized");
    }

    /// Energy at x, the best rotation of each face being taken; `right` becomes the right-hand side of the global step.
    double local(const Eigen::VectorXd& x, Eigen::VectorXd& right) const {
        right.setZero(2 * n_);
        double sum = 0;
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            const RestShape& r = rest_[f];
            const Face& face = faces_[f];
            const Jacobian j = jacobian(r, face, x.data(), x.data() + n_);
            const double p = j.a + j.d, q = j.c - j.b, l = std::sqrt(p * p + q * q);
            const double cosine = l > 0 ? p / l : 1, sine = l > 0 ? q / l : 0;
            sum += r.area * (j.a * j.a + j.b * j.b + j.c * j.c + j.d * j.d + 2 - 2 * l);
            for (std::size_t k = 0; k < 3; ++k) {
                right[face[k]] += r.area * (cosine * r.hat[k].x - sine * r.hat[k].y);
                right[n_ + face[k]] += r.area * (sine * r.hat[k].x + cosine * r.hat[k].y);
            }
        }
        return sum / total_;
    }

    /// The map of least energy for the rotations behind `right`, vertex 0 at the origin.
    void global(const Eigen::VectorXd& right, Eigen::VectorXd& x) {
        work_.resize(2 * (n_ - 1));
        work_.head(n_ - 1) = right.segment(1, n_ - 1);
        work_.tail(n_ - 1) = right.segment(n_ + 1, n_ - 1);
        solver_.solve({work_.data(), static_cast<std::size_t>(work_.size())});
        x.resize(2 * n_);
        x[0] = x[n_] = 0;
        x.segment(1, n_ - 1) = work_.head(n_ - 1);
        x.segment(n_ + 1, n_ - 1) = work_.tail(n_ - 1);
    }

 private:
    std::span<const Face> faces_;
    Eigen::Index n_;
    std::vector<RestShape> rest_;
    double total_ = 0;
    SparseCholesky solver_;
    Eigen::VectorXd work_;
};

/// Anderson's extrapolation of a fixed-point iteration x -> g(x) from the last few pairs (x, g).
class Anderson {
 public:
    void restart() {
        count_ = 0;
        next_ = 0;
        has_last_ = false;
    }

    /// @param x  in: the iterate; out: the next one
    void advance(Eigen::VectorXd& x, const Eigen::VectorXd& g) {
        residual_ = g - x;
        if (!has_last_) {
            delta_g_.resize(g.size(), kWindow);
            delta_f_.resize(g.size(), kWindow);
        } else {
            delta_g_.col(next_) = g - last_g_;
            delta_f_.col(next_) = residual_ - last_f_;
            for (int k = 0; k < count_ + (count_ < kWindow ? 1 : 0); ++k)
                gram_(next_, k) = gram_(k, next_) = delta_f_.col(next_).dot(delta_f_.col(k));
            next_ = (next_ + 1) % kWindow;
            count_ = std::min(count_ + 1, kWindow);
        }
        last_g_ = g;
        last_f_ = residual_;
        has_last_ = true;
        x = g;
        if (count_ == 0) return;
        // Least squares by normal equations: five unknowns, a relative shift against dependent columns.
        Eigen::MatrixXd a = gram_.topLeftCorner(count_, count_);
        a.diagonal() *= 1 + 1e-10;
        const Eigen::VectorXd b = delta_f_.leftCols(count_).transpose() * residual_;
        const Eigen::VectorXd theta = a.ldlt().solve(b);
        if (theta.allFinite()) x -= delta_g_.leftCols(count_) * theta;
    }

 private:
    int count_ = 0, next_ = 0;
    bool has_last_ = false;
    Eigen::VectorXd residual_, last_g_, last_f_;
    Eigen::MatrixXd delta_g_, delta_f_;
    Eigen::Matrix<double, kWindow, kWindow> gram_ = Eigen::Matrix<double, kWindow, kWindow>::Zero();
};
}  // namespace

std::vector<RestShape> rest_shapes(const DiskView& disk) {
    std::vector<RestShape> out(disk.faces.size());
    for (std::size_t f = 0; f < out.size(); ++f) {
        const Face& face = disk.faces[f];
        const Vec3d e1 = disk.positions[face[1]] - disk.positions[face[0]];
        const Vec3d e2 = disk.positions[face[2]] - disk.positions[face[0]];
        const double l1 = length(e1), longest = std::max({l1, length(e2), length(e2 - e1)});
        if (!(longest > 0) || !std::isfinite(longest)) fail("face " + std::to_string(f) + " has no extent");
        const double x1 = std::max(l1, kThinnest * longest);
        const double x2 = l1 > 0 ? dot(e1, e2) / l1 : 0;
        const double y2 = std::max(length(cross(e1, e2)) / x1, kThinnest * longest);
        RestShape& r = out[f];
        r.hat[1] = {1 / x1, -x2 / (x1 * y2)};
        r.hat[2] = {0, 1 / y2};
        r.hat[0] = {-r.hat[1].x, -r.hat[1].y - r.hat[2].y};
        r.area = 0.5 * x1 * y2;
    }
    return out;
}

std::vector<Vec2d> lscm_map(const DiskView& disk, LscmWeight weight, const model::Progress& progress) {
    constexpr const char* kStage = "lscm";
    progress.update(kStage, 0);
    const std::size_t n = disk.positions.size();
    const std::vector<RestShape> rest = rest_shapes(disk);
    const Pins pins = choose_pins(disk);
    if (pins.low == pins.high) fail("lscm: the surface has no extent");
    std::vector<Vec2d> uv(n);
    std::vector<std::uint8_t> fixed(n, 0);
    fixed[pins.low] = fixed[pins.high] = 1;
    uv[pins.low] = pins.at_low;
    uv[pins.high] = pins.at_high;
    int count = 0;
    std::vector<int> unknown = number_free(fixed, count);
    Assembly assembly(std::move(unknown), count, 2, disk.faces.size());
    Eigen::VectorXd right = Eigen::VectorXd::Zero(2 * count);
    for (std::size_t f = 0; f < disk.faces.size(); ++f) {
        const Face& face = disk.faces[f];
        const double w = weight == LscmWeight::kArea ? rest[f].area : rest[f].area * rest[f].area;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) {
                // u_i u_j and v_i v_j share the one, u_i v_j and -v_i u_j the other.
                const double even = w * dot(rest[f].hat[i], rest[f].hat[j]);
                const double odd = -w * cross(rest[f].hat[i], rest[f].hat[j]);
                assembly.add(face[i], 0, face[j], 0, even);
                assembly.add(face[i], 1, face[j], 1, even);
                assembly.add(face[i], 0, face[j], 1, odd);
                assembly.add(face[i], 1, face[j], 0, -odd);
                if (const int u = assembly.unknown(face[i]); u >= 0 && fixed[face[j]] != 0) {
                    right[2 * u] -= even * uv[face[j]].x + odd * uv[face[j]].y;
                    right[2 * u + 1] -= even * uv[face[j]].y - odd * uv[face[j]].x;
                }
            }
    }
    if (count > 0) {
        const SparseMatrix matrix = assembly.matrix();
        SparseCholesky solver;
        solver.analyze(matrix, ordering_of(disk, false), 2);
        progress.update(kStage, 0.4);
        if (!solver.factorize(matrix)) fail("lscm: the conformal system cannot be factorized");
        progress.update(kStage, 0.9);
        Eigen::VectorXd x = right;
        solver.solve({x.data(), static_cast<std::size_t>(x.size())});
        // One step of refinement: conformal maps span many powers of ten.
        Eigen::VectorXd residual = right - matrix.selfadjointView<Eigen::Lower>() * x;
        solver.solve({residual.data(), static_cast<std::size_t>(residual.size())});
        if (residual.allFinite()) x += residual;
        for (std::uint32_t v = 0; v < n; ++v)
            if (const int u = assembly.unknown(v); u >= 0) uv[v] = {x[2 * u], x[2 * u + 1]};
    }
    for (const Vec2d& p : uv)
        if (!std::isfinite(p.x) || !std::isfinite(p.y)) fail("lscm: the map is not finite");
    progress.update(kStage, 1);
    return uv;
}

namespace {

/// The border on a circle of the surface's area, by arc length; zero inside.
std::vector<Vec2d> border_on_circle(const DiskView& disk, double area) {
    const std::size_t k = disk.border.size();
    double around = 0, walked = 0;
    const auto edge = [&](std::size_t b) {
        return length(disk.positions[disk.border[(b + 1) % k]] - disk.positions[disk.border[b]]);
    };
    for (std::size_t b = 0; b < k; ++b) around += edge(b);
    const double radius = std::sqrt(area / std::numbers::pi);
    std::vector<Vec2d> uv(disk.positions.size());
    for (std::size_t b = 0; b < k; ++b) {
        const double angle = 2 * std::numbers::pi * walked / around;
        uv[disk.border[b]] = Vec2d{math::cos(angle), math::sin(angle)} * radius;
        walked += edge(b);
    }
    return uv;
}

/// Cotangent weights between the unknowns.
SparseMatrix cotangent_matrix(const DiskView& disk, const std::vector<RestShape>& rest, std::vector<int>& unknown,
                              int count) {
    Assembly assembly(unknown, count, 1, disk.faces.size());
    for (std::size_t f = 0; f < disk.faces.size(); ++f)
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j)
                assembly.add(disk.faces[f][i], 0, disk.faces[f][j], 0,
                             rest[f].area * dot(rest[f].hat[i], rest[f].hat[j]));
    return assembly.matrix();
}

/// Makes the weights positive: off-diagonal entries are clamped to at most -1/100 and the diagonal is their sum, the
/// border's share among it. Returns the right-hand sides.
Eigen::MatrixX2d make_positive(SparseMatrix& matrix, const DiskView& disk, const std::vector<RestShape>& rest,
                               const std::vector<int>& unknown, const std::vector<std::uint8_t>& fixed,
                               const std::vector<Vec2d>& uv) {
    constexpr double kLeast = 0.01, kMost = 100;
    const Eigen::Index count = matrix.rows();
    Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(count, 2);
    Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(count);
    for (int c = 0; c < matrix.outerSize(); ++c)
        for (SparseMatrix::InnerIterator it(matrix, c); it; ++it) {
            if (it.row() == c) continue;
            it.valueRef() = -std::clamp(-it.value(), kLeast, kMost);
            diagonal[c] -= it.value();
            diagonal[it.row()] -= it.value();
        }
    for (std::size_t f = 0; f < disk.faces.size(); ++f)
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) {
                const std::uint32_t v = disk.faces[f][i], w = disk.faces[f][j];
                if (unknown[v] < 0 || fixed[w] == 0) continue;
                const double weight =
                    std::clamp(-rest[f].area * dot(rest[f].hat[i], rest[f].hat[j]), 0.5 * kLeast, 0.5 * kMost);
                diagonal[unknown[v]] += weight;
                right.row(unknown[v]) += weight * Eigen::RowVector2d(uv[w].x, uv[w].y);
            }
    for (int c = 0; c < matrix.outerSize(); ++c) matrix.coeffRef(c, c) = diagonal[c];
    return right;
}

}  // namespace

std::vector<Vec2d> harmonic_disk_map(const DiskView& disk, const model::Progress& progress) {
    progress.update("harmonic start", 0);
    const std::vector<RestShape> rest = rest_shapes(disk);
    double area = 0;
    for (const RestShape& r : rest) area += r.area;
    std::vector<Vec2d> uv = border_on_circle(disk, area);
    std::vector<std::uint8_t> fixed(uv.size(), 0);
    for (const std::uint32_t v : disk.border) fixed[v] = 1;
    int count = 0;
    std::vector<int> unknown = number_free(fixed, count);
    if (count == 0) return uv;
    SparseMatrix matrix = cotangent_matrix(disk, rest, unknown, count);
    Eigen::MatrixX2d right = make_positive(matrix, disk, rest, unknown, fixed, uv);
    SparseCholesky solver;
    solver.analyze(matrix, ordering_of(disk, false));
    if (!solver.factorize(matrix)) fail("the harmonic start cannot be solved");
    solver.solve({right.data(), static_cast<std::size_t>(right.size())});
    for (std::size_t v = 0; v < uv.size(); ++v)
        if (unknown[v] >= 0) uv[v] = {right(unknown[v], 0), right(unknown[v], 1)};
    progress.update("harmonic start", 1);
    return uv;
}

double arap_energy(const DiskView& disk, std::span<const Vec2d> uv) {
    double sum = 0, total = 0;
    const std::vector<RestShape> rest = rest_shapes(disk);
    std::vector<double> u, v;
    for (const Vec2d& p : uv) {
        u.push_back(p.x);
        v.push_back(p.y);
    }
    for (std::size_t f = 0; f < rest.size(); ++f) {
        const Jacobian j = jacobian(rest[f], disk.faces[f], u.data(), v.data());
        sum += rest[f].area *
               (j.a * j.a + j.b * j.b + j.c * j.c + j.d * j.d + 2 - 2 * length(Vec2d{j.a + j.d, j.c - j.b}));
        total += rest[f].area;
    }
    return sum / total;
}

std::vector<Vec2d> arap_map(const DiskView& disk, std::vector<Vec2d> start, const ArapOptions& options,
                            const model::Progress& progress, ArapReport* report) {
    constexpr const char* kStage = "arap";
    constexpr double kIsometric = 1e-26;  // an energy that is rounding alone
    progress.update(kStage, 0);
    const auto n = static_cast<Eigen::Index>(start.size());
    LocalGlobal step(disk);
    Anderson anderson;
    Eigen::VectorXd x(2 * n), g, right, fallback;
    for (Eigen::Index v = 0; v < n; ++v) {
        x[v] = start[static_cast<std::size_t>(v)].x - start[0].x;
        x[n + v] = start[static_cast<std::size_t>(v)].y - start[0].y;
    }
    double energy = step.local(x, right);
    std::size_t k = 0;
    while (k < options.iterations && energy > kIsometric) {
        progress.update(kStage, static_cast<double>(k) / static_cast<double>(options.iterations));
        step.global(right, g);
        ++k;
        fallback = g;
        anderson.advance(x, g);
        double next = step.local(x, right);
        if (!(next < energy)) {  // the extrapolation went astray: the plain step never does
            x = fallback;
            anderson.restart();
            next = step.local(x, right);
        }
        const double gain = energy - next;
        energy = next;
        if (!(gain > options.tolerance * energy)) break;
    }
    if (!x.allFinite()) fail("arap: the map is not finite");
    for (Eigen::Index v = 0; v < n; ++v) start[static_cast<std::size_t>(v)] = {x[v], x[n + v]};
    progress.update(kStage, 1);
    if (report != nullptr) *report = {energy, k};
    return start;
}

}  // namespace dgm::bake
