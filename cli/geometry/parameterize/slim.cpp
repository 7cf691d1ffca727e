// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/slim.cpp
// Projected Newton on separable isotropic energies of the singular values.
//
// [Smith, Schaefer 2015] Bijective Parameterization with Free Boundaries. ACM TOG 34(4).
#include "geometry/parameterize/slim.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "geometry/metrics/map_metrics.h"
#include "geometry/parameterize/flip_free_problem.h"
#include "geometry/solve/sparse_cholesky.h"
#include "math/portable.h"

namespace dgm::bake {
namespace {
using SparseMatrix = Eigen::SparseMatrix<double>;

using Stiffness = std::vector<double>;

constexpr const char* kStage = "flip-free descent";
constexpr double kCollapseShare = 0.9;  // of the step to the first collapse
constexpr double kArmijo = 1e-4;
constexpr int kMaxHalvings = 40;
constexpr double kLongestStep = 64;  // times the Newton step
constexpr double kTooShort = 0.2;    // of the Newton step: faces that collapse before are held
// Nested dissection pays where a large or a middling matrix is factorized often; measured on four meshes.
constexpr std::size_t kLarge = 50'000, kSmall = 5'000;  // vertices
constexpr std::size_t kFew = 8;                         // steps
constexpr int kHolds = 4;                               // factorizations a step at most on that account

/// The Newton matrix over the free vertices: lower triangle, pattern and scatter table made once.
class NewtonSystem {
 public:
    NewtonSystem(const DiskView& disk, const std::vector<std::uint8_t>& fixed, Ordering ordering)
        : unknown_of_(fixed.size(), -1) {
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
        if (unknowns > 0) solver_.analyze(matrix_, ordering, 2);
    }

    [[nodiscard]] bool empty() const { return matrix_.rows() == 0; }
    [[nodiscard]] std::size_t factorizations() const { return factorizations_; }

    /// @param stiffness  factor of each face's Hessian
    void assemble(const Problem& problem, const std::vector<Vec2d>& x, const Stiffness& stiffness) {
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
                values[*next++] +=
                    stiffness[f] * (q[0][i] * q[0][j] + q[1][i] * q[1][j] + q[2][i] * q[2][j] + q[3][i] * q[3][j]);
            });
        });
    }

    /// Newton direction, or false if the matrix cannot be factorized. A free border leaves translations and a rotation
    /// undetermined: a relative shift of the diagonal fixes them and does not depend on the scale of any face.
    bool find_direction() {
        const auto diagonal = [&](Eigen::Index k) -> double& {
            return matrix_.valuePtr()[matrix_.outerIndexPtr()[k]];  // lower: first of its column
        };
        diagonal_.resize(static_cast<std::size_t>(matrix_.outerSize()));
        for (Eigen::Index k = 0; k < matrix_.outerSize(); ++k) diagonal_[static_cast<std::size_t>(k)] = diagonal(k);
        double shift = 1e-9;
        for (int attempt = 0; attempt < 5; ++attempt, shift *= 100) {
            for (Eigen::Index k = 0; k < matrix_.outerSize(); ++k) {
                const double own = diagonal_[static_cast<std::size_t>(k)];
                diagonal(k) = own > 0 ? own * (1 + shift) : std::numeric_limits<double>::min();
            }
            ++factorizations_;
            if (!solver_.factorize(matrix_)) continue;
            direction_ = -gradient_;
            solver_.solve({direction_.data(), static_cast<std::size_t>(direction_.size())});
            if (direction_.allFinite() && slope() < 0) return true;
        }
        return false;
    }

    [[nodiscard]] double slope() const { return direction_.dot(gradient_); }
    [[nodiscard]] Vec2d direction(std::size_t v) const {
        const int u = unknown_of_[v];
        return u < 0 ? Vec2d{} : Vec2d{direction_[u], direction_[u + 1]};
    }

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
    std::vector<double> diagonal_;  // of the matrix, unshifted
    Eigen::VectorXd gradient_, direction_;
    std::size_t factorizations_ = 0;
};

/// Smallest t > 0 at which the area of face f moving from x along d is 0; infinity if there is none.
/// 2A(t) = a + b t + c t^2 with a > 0.
double collapse_of(const Face& f, const std::vector<Vec2d>& x, const std::vector<Vec2d>& d) {
    const Vec2d e1 = x[f[1]] - x[f[0]], e2 = x[f[2]] - x[f[0]];
    const Vec2d d1 = d[f[1]] - d[f[0]], d2 = d[f[2]] - d[f[0]];
    const double a = difference_of_products(e1.x, e2.y, e1.y, e2.x);
    const double b = cross(d1, e2) + cross(e1, d2);
    const double c = difference_of_products(d1.x, d2.y, d1.y, d2.x);
    const double discriminant = difference_of_products(b, b, 4 * a, c);
    if (!(discriminant >= 0)) return kInfinity;
    // Citardauq form: with -b the two terms add up for b < 0; for b >= 0 only c < 0 gives a positive root.
    const double root = std::sqrt(discriminant);
    double t = kInfinity;
    if (b < 0) {
        t = 2 * a / (root - b);
    } else if (c < 0) {
        t = (b + root) / (-2 * c);
    }
    return t > 0 ? t : kInfinity;
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

/// Newton direction into `step`; returns how far it may be followed, 0 if there is none.
///
/// Where energies lie orders of magnitude apart, the worst faces rule the direction, and a face of little energy that
/// would collapse first can end every step after a tiny way. Its Hessian is then made stiffer until it goes along.
double find_step(const Problem& problem, NewtonSystem& system, const std::vector<Vec2d>& x, Stiffness& stiffness,
                 std::vector<Vec2d>& step, const model::Progress& progress, double share) {
    for (double& s : stiffness) s = std::max(1.0, 0.25 * s);
    const std::span<const Face> faces = problem.faces();
    for (int hold = 0;; ++hold) {
        system.assemble(problem, x, stiffness);
        if (!system.find_direction()) return 0;
        for (std::size_t v = 0; v < x.size(); ++v) step[v] = system.direction(v);
        double first = kInfinity;
        for (const Face& f : faces) first = std::min(first, collapse_of(f, x, step));
        if (kCollapseShare * first >= kTooShort || hold == kHolds) return kCollapseShare * first;
        for (std::size_t f = 0; f < faces.size(); ++f)
            if (const double t = collapse_of(faces[f], x, step); t < 2 * kTooShort)
                stiffness[f] *= std::clamp(math::pow(2 * kTooShort / t, 1.5), 4.0, 1e12);
        progress.update(kStage, share);
    }
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

namespace {

/// Scales a map with a free border to its least energy, if no face inverts for it. Returns the energy.
double scale_to_least(const Problem& problem, std::span<const Face> faces, std::vector<Vec2d>& x, double energy) {
    const double scale = problem.best_scale(x);
    std::vector<Vec2d> scaled = x;
    for (Vec2d& p : scaled) p = p * scale;
    const double e = problem.energy(scaled);
    if (!(e < energy) || count_not_positive(faces, scaled) != 0) return energy;
    x = std::move(scaled);
    return e;
}

/// A step from a map, as far as no face inverts.
struct Line {
    const std::vector<Vec2d>& from;
    const std::vector<Vec2d>& step;
    double longest;  // in steps
    double energy;   // at `from`
    double slope;    // of the energy there
};

/// Goes along the line to a place `found` that is lower by Armijo's rule. Returns its energy; infinity if there is
/// none.
double search_line(const Problem& problem, std::span<const Face> faces, const Line& line, std::vector<Vec2d>& found) {
    const auto at = [&](double t) {
        for (std::size_t v = 0; v < found.size(); ++v) found[v] = line.from[v] + line.step[v] * t;
        return problem.energy(found);
    };
    double t = std::min(1.0, line.longest);
    // Where s^-2 rules, the quadratic model asks for a third more size: go on while the energy falls well.
    for (double e = at(t); t < std::min(kLongestStep, 0.9 * line.longest);) {
        const double next = std::min(2 * t, line.longest), further = at(next);
        if (!(further < 0.99 * e)) break;
        t = next;
        e = further;
    }
    for (int halving = 0; halving < kMaxHalvings; ++halving, t *= 0.5) {
        const double e = at(t);
        if (e < line.energy && e <= line.energy + kArmijo * t * line.slope && count_not_positive(faces, found) == 0)
            return e;
    }
    return kInfinity;
}

}  // namespace

std::vector<Vec2d> descend_flip_free(const DiskView& disk, std::vector<Vec2d> start, const SlimOptions& options,
                                     const model::Progress& progress, SlimReport* report) {
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
    if (!options.border_fixed && options.rest.empty()) energy = scale_to_least(problem, disk.faces, x, energy);
    SlimReport out{.start_energy = energy, .energy = energy};

    std::vector<std::uint8_t> fixed(x.size(), 0);
    if (options.border_fixed)
        for (const std::uint32_t v : disk.border) fixed[v] = 1;
    const bool dissect = x.size() > kLarge || (x.size() > kSmall && options.iterations > kFew);
    NewtonSystem system(disk, fixed, dissect ? Ordering::kNestedDissection : Ordering::kMinimumDegree);
    Stiffness stiffness(disk.faces.size(), 1.0);
    std::vector<Vec2d> step(x.size()), trial(x.size());
    std::size_t idle = 0;
    for (std::size_t k = 0; k < options.iterations && !system.empty() && std::isfinite(energy); ++k) {
        const double share = static_cast<double>(k) / static_cast<double>(options.iterations);
        progress.update(kStage, share);
        const double longest = find_step(problem, system, x, stiffness, step, progress, share);
        if (!(longest > 0)) break;
        const double lowered = search_line(problem, disk.faces, {x, step, longest, energy, system.slope()}, trial);
        if (!(lowered < energy)) break;
        const double gain = energy - lowered;
        x.swap(trial);
        energy = lowered;
        ++out.iterations;
        idle = gain < options.tolerance * std::abs(energy) ? idle + 1 : 0;
        if (idle >= options.patience) break;
    }
    progress.update(kStage, 1);
    out.energy = energy;
    out.factorizations = system.factorizations();
    if (report != nullptr) *report = out;
    return x;
}

}  // namespace dgm::bake
