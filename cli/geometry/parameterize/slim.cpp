// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/slim.cpp
// Projected Newton on separable isotropic energies of the singular values.
//
// [Smith, De Goes, Kim 2019] Analytic Eigensystems for Isotropic Distortion Energies. ACM TOG 38(1).
// [Smith, Schaefer 2015] Bijective Parameterization with Free Boundaries. ACM TOG 34(4).
// [Sander 2001] Sander, Snyder, Gortler, Hoppe. Texture Mapping Progressive Meshes. SIGGRAPH 2001.
#include "geometry/parameterize/slim.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "geometry/metrics/map_metrics.h"
#include "geometry/solve/sparse_cholesky.h"

namespace dgm::bake {
namespace {
using SparseMatrix = Eigen::SparseMatrix<double>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kCollapseShare = 0.9;  // of the step to the first collapse
constexpr double kArmijo = 1e-4;
constexpr int kMaxHalvings = 40;

/// g'(s) = c1 s + c0 + c2 s^-2 + c3 s^-3: the three energies are rows of one family.
struct Density {
    double c1 = 0, c0 = 0, c2 = 0, c3 = 0, constant = 0;

    [[nodiscard]] double value(double s) const {
        return 0.5 * c1 * s * s + c0 * s - c2 / s - 0.5 * c3 / (s * s) + constant;
    }
    [[nodiscard]] double slope(double s) const { return c1 * s + c0 + (c2 + c3 / s) / (s * s); }
    [[nodiscard]] double curvature(double s) const { return c1 - (2 * c2 + 3 * c3 / s) / (s * s * s); }
    /// (g'(s1) - g'(s2)) / (s1 - s2), written out because it cancels where s1 = s2.
    [[nodiscard]] double divided_difference(double s1, double s2) const {
        const double p = s1 * s2;
        return c1 - c2 * (s1 + s2) / (p * p) - c3 * (s1 * s1 + p + s2 * s2) / (p * p * p);
    }
};

Density density_of(const SlimOptions& o) {
    switch (o.energy) {
        case FlipFreeEnergy::kArap:
            return {.c1 = 2, .c0 = -2, .c2 = 2 * o.barrier, .c3 = -2 * o.barrier, .constant = 1 + o.barrier};
        case FlipFreeEnergy::kStretch:
            return {.c1 = 2 * o.stretch_epsilon, .c3 = -2};
        case FlipFreeEnergy::kSymmetricDirichlet:
            break;
    }
    return {.c1 = 1, .c3 = -1};
}

/// A face laid flat: columns of the inverse of its edge matrix, so that F = [x1 - x0, x2 - x0] * inverse.
struct Rest {
    std::array<Vec2d, 3> b;  ///< gradients of the three hat functions: F = sum x_k b_k^T
    double weight = 0;       ///< share of the area
    double inverse_det = 0;  ///< 1 / (2 area)
};

/// F = R(phi) diag(s1, s2) R(theta).
struct SingularValues {
    double s1 = 0, s2 = 0, phi = 0, theta = 0;
};

/// a*d - b*c to nearly full precision (Kahan).
double difference_of_products(double a, double d, double b, double c) {
    const double bc = b * c;
    return std::fma(a, d, -bc) + std::fma(-b, c, bc);
}

double twice_area(const std::vector<Vec2d>& x, const Face& f) {
    const Vec2d e1 = x[f[1]] - x[f[0]], e2 = x[f[2]] - x[f[0]];
    return difference_of_products(e1.x, e2.y, e1.y, e2.x);
}

class Problem {
 public:
    Problem(const DiskView& disk, const SlimOptions& options) : disk_(disk), density_(density_of(options)) {
        std::vector<RestShape> own;
        if (options.rest.empty()) own = rest_shapes(disk);
        const std::span<const RestShape> shapes = options.rest.empty() ? own : options.rest;
        rest_.resize(disk.faces.size());
        for (const RestShape& s : shapes) area_ += s.area;
        for (std::size_t f = 0; f < rest_.size(); ++f) {
            // 1 / (2 area) of the shape itself, which the weight need not be.
            const std::array<Vec2d, 3>& b = shapes[f].hat;
            rest_[f] = {b, shapes[f].area / area_, cross(b[1], b[2])};
        }
    }

    [[nodiscard]] double area() const { return area_; }

    /// Multiplies all rest lengths.
    void scale_rest(double s) {
        for (Rest& r : rest_) {
            for (Vec2d& b : r.b) b = b * (1 / s);
            r.inverse_det /= s * s;
        }
        area_ *= s * s;
    }

    [[nodiscard]] SingularValues singular_values(const std::vector<Vec2d>& x, std::size_t f) const {
        const Face& face = disk_.faces[f];
        const Rest& r = rest_[f];
        const Vec2d e1 = x[face[1]] - x[face[0]], e2 = x[face[2]] - x[face[0]];
        const double a = e1.x * r.b[1].x, b = e1.x * r.b[1].y + e2.x * r.b[2].y;
        const double c = e1.y * r.b[1].x, d = e1.y * r.b[1].y + e2.y * r.b[2].y;
        const double E = 0.5 * (a + d), F = 0.5 * (a - d), G = 0.5 * (c + b), H = 0.5 * (c - b);
        SingularValues out;
        out.s1 = std::hypot(E, H) + std::hypot(F, G);
        // Not the difference of the two: it cancels for needles.
        out.s2 = twice_area(x, face) * r.inverse_det / out.s1;
        const double refl = std::atan2(G, F), rot = std::atan2(H, E);
        out.phi = 0.5 * (rot + refl);
        out.theta = 0.5 * (rot - refl);
        return out;
    }

    [[nodiscard]] double energy(const std::vector<Vec2d>& x) const {
        double sum = 0;
        for (std::size_t f = 0; f < rest_.size(); ++f) {
            const Face& face = disk_.faces[f];
            const Rest& r = rest_[f];
            const Vec2d e1 = x[face[1]] - x[face[0]], e2 = x[face[2]] - x[face[0]];
            const double det = difference_of_products(e1.x, e2.y, e1.y, e2.x) * r.inverse_det;
            if (!(det > 0)) return kInfinity;
            const double a = e1.x * r.b[1].x, b = e1.x * r.b[1].y + e2.x * r.b[2].y;
            const double c = e1.y * r.b[1].x, d = e1.y * r.b[1].y + e2.y * r.b[2].y;
            const double s1 = 0.5 * (std::hypot(a + d, c - b) + std::hypot(a - d, c + b));
            sum += r.weight * (density_.value(s1) + density_.value(det / s1));
        }
        return std::isfinite(sum) ? sum : kInfinity;
    }

    /// Best global factor for the symmetric Dirichlet energy; the other energies take it if it lowers them.
    [[nodiscard]] double best_scale(const std::vector<Vec2d>& x) const {
        double squares = 0, inverses = 0;
        for (std::size_t f = 0; f < rest_.size(); ++f) {
            const SingularValues s = singular_values(x, f);
            squares += rest_[f].weight * (s.s1 * s.s1 + s.s2 * s.s2);
            inverses += rest_[f].weight * (1 / (s.s1 * s.s1) + 1 / (s.s2 * s.s2));
        }
        return std::sqrt(std::sqrt(inverses / squares));
    }

    /// Calls sink(face, gradient of the three corners, modes) with A' already multiplied in; a mode is a vector of six
    /// entries q (x0 y0 x1 y1 x2 y2) such that the projected Hessian is the sum of q q^T.
    template <typename Sink>
    void each_face(const std::vector<Vec2d>& x, const Sink& sink) const {
        for (std::size_t f = 0; f < rest_.size(); ++f) {
            const Rest& r = rest_[f];
            const SingularValues s = singular_values(x, f);
            const double cp = std::cos(s.phi), sp = std::sin(s.phi), ct = std::cos(s.theta), st = std::sin(s.theta);
            // R(phi) M R(theta) b for M = e_i e_j^T: column i of R(phi) times (row j of R(theta)) . b.
            const Vec2d u1{cp, sp}, u2{-sp, cp};
            const double g1 = density_.slope(s.s1), g2 = density_.slope(s.s2);
            const double root_half = std::sqrt(0.5);
            const std::array<double, 4> lambda{density_.curvature(s.s1), density_.curvature(s.s2),
                                               density_.divided_difference(s.s1, s.s2), (g1 + g2) / (s.s1 + s.s2)};
            std::array<double, 6> gradient{};
            std::array<std::array<double, 6>, 4> modes{};
            std::array<double, 4> root{};
            for (std::size_t m = 0; m < 4; ++m) root[m] = std::sqrt(r.weight * std::max(lambda[m], 0.0));
            for (std::size_t k = 0; k < 3; ++k) {
                const double v1 = ct * r.b[k].x - st * r.b[k].y, v2 = st * r.b[k].x + ct * r.b[k].y;
                const Vec2d flip = (u1 * v2 + u2 * v1) * root_half, twist = (u2 * v1 - u1 * v2) * root_half;
                const Vec2d gk = (u1 * (g1 * v1) + u2 * (g2 * v2)) * r.weight;
                gradient[2 * k] = gk.x;
                gradient[2 * k + 1] = gk.y;
                const std::array<Vec2d, 4> d{u1 * v1, u2 * v2, flip, twist};
                for (std::size_t m = 0; m < 4; ++m) {
                    modes[m][2 * k] = root[m] * d[m].x;
                    modes[m][2 * k + 1] = root[m] * d[m].y;
                }
            }
            sink(f, gradient, modes);
        }
    }

    [[nodiscard]] std::span<const Face> faces() const { return disk_.faces; }

 private:
    const DiskView& disk_;
    Density density_;
    std::vector<Rest> rest_;
    double area_ = 0;
};

/// The Newton matrix over the free vertices: lower triangle, pattern and scatter table made once.
class NewtonSystem {
 public:
    NewtonSystem(const DiskView& disk, const std::vector<std::uint8_t>& fixed) : unknown_of_(fixed.size(), -1) {
        const std::span<const Face> faces = disk.faces;
        int unknowns = 0;
        for (std::size_t v = 0; v < fixed.size(); ++v)
            if (fixed[v] == 0) unknown_of_[v] = 2 * unknowns++;
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(faces.size() * 21);
        for (const Face& f : faces)
            for_entries(f, [&](std::size_t, std::size_t, int row, int col) { entries.emplace_back(row, col, 1.0); });
        matrix_.resize(2 * unknowns, 2 * unknowns);
        matrix_.setFromTriplets(entries.begin(), entries.end());
        matrix_.makeCompressed();
        slots_.reserve(faces.size() * 21);
        for (const Face& f : faces)
            for_entries(f, [&](std::size_t, std::size_t, int row, int col) { slots_.push_back(slot(row, col)); });
        if (unknowns > 0) solver_.analyze(matrix_, Ordering::kNestedDissection, 2);
    }

    [[nodiscard]] bool empty() const { return matrix_.rows() == 0; }
    [[nodiscard]] std::size_t factorizations() const { return factorizations_; }

    void assemble(const Problem& problem, const std::vector<Vec2d>& x) {
        double* values = matrix_.valuePtr();
        std::fill_n(values, matrix_.nonZeros(), 0.0);
        gradient_ = Eigen::VectorXd::Zero(matrix_.rows());
        const std::int64_t* next = slots_.data();
        problem.each_face(x, [&](std::size_t f, const std::array<double, 6>& gradient,
                                 const std::array<std::array<double, 6>, 4>& q) {
            const Face& face = problem.faces()[f];
            for (std::size_t k = 0; k < 3; ++k)
                if (const int u = unknown_of_[face[k]]; u >= 0) {
                    gradient_[u] += gradient[2 * k];
                    gradient_[u + 1] += gradient[2 * k + 1];
                }
            for_entries(face, [&](std::size_t i, std::size_t j, int, int) {
                values[*next++] += q[0][i] * q[0][j] + q[1][i] * q[1][j] + q[2][i] * q[2][j] + q[3][i] * q[3][j];
            });
        });
    }

    /// Newton direction, or false if the matrix cannot be factorized. A free border leaves translations and a rotation
    /// undetermined: a relative shift of the diagonal fixes them and does not depend on the scale of any face.
    bool direction(Eigen::VectorXd& d) {
        double shift = 1e-9;
        for (int attempt = 0; attempt < 5; ++attempt, shift *= 100) {
            SparseMatrix shifted = matrix_;
            for (int k = 0; k < shifted.outerSize(); ++k) {
                double& diagonal = shifted.valuePtr()[shifted.outerIndexPtr()[k]];  // lower: first of its column
                diagonal = diagonal > 0 ? diagonal * (1 + shift) : std::numeric_limits<double>::min();
            }
            ++factorizations_;
            if (!solver_.factorize(shifted)) continue;
            d = -gradient_;
            solver_.solve({d.data(), static_cast<std::size_t>(d.size())});
            if (d.allFinite() && d.dot(gradient_) < 0) return true;
        }
        return false;
    }

    [[nodiscard]] double slope(const Eigen::VectorXd& d) const { return d.dot(gradient_); }
    [[nodiscard]] int unknown_of(std::size_t v) const { return unknown_of_[v]; }

 private:
    template <typename Visit>
    void for_entries(const Face& f, const Visit& visit) const {
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t l = 0; l < 3; ++l) {
                const int row = unknown_of_[f[k]], col = unknown_of_[f[l]];
                if (row < 0 || col < 0 || row < col) continue;
                visit(2 * k, 2 * l, row, col);
                visit(2 * k + 1, 2 * l, row + 1, col);
                if (row != col) visit(2 * k, 2 * l + 1, row, col + 1);
                visit(2 * k + 1, 2 * l + 1, row + 1, col + 1);
            }
    }
    [[nodiscard]] std::int64_t slot(int row, int col) const {
        const int* begin = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[col];
        const int* end = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[col + 1];
        return std::lower_bound(begin, end, row) - matrix_.innerIndexPtr();
    }

    std::vector<int> unknown_of_;  // of x; y is the next one; -1 where fixed
    SparseMatrix matrix_;
    std::vector<std::int64_t> slots_;
    SparseCholesky solver_;
    Eigen::VectorXd gradient_;
    std::size_t factorizations_ = 0;
};

/// Smallest t > 0 at which the area of some face moving from x along d is 0; infinity if none.
/// 2A(t) = a + b t + c t^2 with a > 0.
double first_collapse(std::span<const Face> faces, const std::vector<Vec2d>& x, const std::vector<Vec2d>& d) {
    double first = kInfinity;
    for (const Face& f : faces) {
        const Vec2d e1 = x[f[1]] - x[f[0]], e2 = x[f[2]] - x[f[0]];
        const Vec2d d1 = d[f[1]] - d[f[0]], d2 = d[f[2]] - d[f[0]];
        const double a = difference_of_products(e1.x, e2.y, e1.y, e2.x);
        const double b = cross(d1, e2) + cross(e1, d2);
        const double c = difference_of_products(d1.x, d2.y, d1.y, d2.x);
        const double discriminant = difference_of_products(b, b, 4 * a, c);
        if (!(discriminant >= 0)) continue;
        // Citardauq form: with -b the two terms add up for b < 0; for b >= 0 only c < 0 gives a positive root.
        const double root = std::sqrt(discriminant);
        double t = kInfinity;
        if (b < 0) {
            t = 2 * a / (root - b);
        } else if (c < 0) {
            t = (b + root) / (-2 * c);
        }
        if (t > 0) first = std::min(first, t);
    }
    return first;
}

[[noreturn]] void fail(const std::string& what) {
    throw model::Error(model::codes::kMapInvalid, what);
}

void check_sizes(const DiskView& disk, std::size_t points, const SlimOptions& options) {
    if (points != disk.positions.size()) fail("the start map has another number of vertices than the mesh");
    if (!options.rest.empty() && options.rest.size() != disk.faces.size()) fail("not one rest shape per face");
    for (const Face& f : disk.faces)
        for (const std::uint32_t v : f)
            if (v >= points) fail("a face names a vertex that does not exist");
}

double map_area(const DiskView& disk, const std::vector<Vec2d>& x) {
    double sum = 0;
    for (const Face& f : disk.faces) sum += 0.5 * twice_area(x, f);
    return sum;
}
}  // namespace

std::size_t count_not_positive(std::span<const Face> faces, std::span<const Vec2d> uv) {
    std::size_t count = 0;
    for (const Face& f : faces) {
        bool finite = true;
        for (const std::uint32_t v : f) finite = finite && std::isfinite(uv[v].x) && std::isfinite(uv[v].y);
        if (!finite || orient2d(uv[f[0]], uv[f[1]], uv[f[2]]) <= 0) ++count;
    }
    return count;
}

double flip_free_energy(const DiskView& disk, std::span<const Vec2d> uv, const SlimOptions& options,
                        std::vector<Vec2d>* gradient) {
    check_sizes(disk, uv.size(), options);
    const std::vector<Vec2d> x(uv.begin(), uv.end());
    Problem problem(disk, options);
    if (options.border_fixed && options.rest.empty()) problem.scale_rest(std::sqrt(map_area(disk, x) / problem.area()));
    const double energy = problem.energy(x);
    if (gradient != nullptr) {
        gradient->assign(x.size(), Vec2d{});
        if (std::isfinite(energy))
            problem.each_face(x, [&](std::size_t f, const std::array<double, 6>& g, const auto&) {
                for (std::size_t k = 0; k < 3; ++k)
                    (*gradient)[disk.faces[f][k]] = (*gradient)[disk.faces[f][k]] + Vec2d{g[2 * k], g[2 * k + 1]};
            });
    }
    return energy;
}

std::vector<Vec2d> descend_flip_free(const DiskView& disk, std::vector<Vec2d> start, const SlimOptions& options,
                                     const model::Progress& progress, SlimReport* report) {
    constexpr const char* kStage = "flip-free descent";
    progress.update(kStage, 0);
    check_sizes(disk, start.size(), options);
    if (const std::size_t bad = count_not_positive(disk.faces, start); bad > 0)
        fail("the start of the descent has " + std::to_string(bad) + " faces that are not positively oriented");
    for (const Vec2d& p : start)
        if (!std::isfinite(p.x) || !std::isfinite(p.y)) fail("the start of the descent is not finite");

    Problem problem(disk, options);
    std::vector<Vec2d> x = std::move(start);
    if (options.border_fixed && options.rest.empty()) problem.scale_rest(std::sqrt(map_area(disk, x) / problem.area()));
    double energy = problem.energy(x);
    if (!options.border_fixed && options.rest.empty()) {
        const double scale = problem.best_scale(x);
        std::vector<Vec2d> scaled = x;
        for (Vec2d& p : scaled) p = p * scale;
        const double e = problem.energy(scaled);
        if (e < energy && count_not_positive(disk.faces, scaled) == 0) {
            x = std::move(scaled);
            energy = e;
        }
    }
    SlimReport out{.start_energy = energy, .energy = energy};

    std::vector<std::uint8_t> fixed(x.size(), 0);
    if (options.border_fixed)
        for (const std::uint32_t v : disk.border) fixed[v] = 1;
    NewtonSystem system(disk, fixed);
    std::vector<Vec2d> step(x.size()), trial(x.size());
    Eigen::VectorXd d;
    for (std::size_t k = 0; k < options.iterations && !system.empty() && std::isfinite(energy); ++k) {
        progress.update(kStage, static_cast<double>(k) / static_cast<double>(options.iterations));
        system.assemble(problem, x);
        if (!system.direction(d)) break;
        for (std::size_t v = 0; v < x.size(); ++v) {
            const int u = system.unknown_of(v);
            step[v] = u < 0 ? Vec2d{} : Vec2d{d[u], d[u + 1]};
        }
        double t = std::min(1.0, kCollapseShare * first_collapse(disk.faces, x, step));
        const double slope = system.slope(d);
        double lowered = kInfinity;
        for (int halving = 0; halving < kMaxHalvings; ++halving, t *= 0.5) {
            for (std::size_t v = 0; v < x.size(); ++v) trial[v] = x[v] + step[v] * t;
            const double e = problem.energy(trial);
            if (e < energy && e <= energy + kArmijo * t * slope && count_not_positive(disk.faces, trial) == 0) {
                lowered = e;
                break;
            }
        }
        if (!(lowered < energy)) break;
        const double gain = energy - lowered;
        x.swap(trial);
        energy = lowered;
        ++out.iterations;
        if (gain < options.tolerance * std::abs(energy)) break;
    }
    progress.update(kStage, 1);
    out.energy = energy;
    out.factorizations = system.factorizations();
    if (report != nullptr) *report = out;
    return x;
}

}  // namespace dgm::bake
