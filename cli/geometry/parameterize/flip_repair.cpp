// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/flip_repair.cpp
// [Garanzha 2021] Garanzha, Kaporin, Kudryavtseva, Protais, Ray, Sokolov. Foldover-free maps in 50 lines of code.
//                 SIGGRAPH 2021. Energy tr(J^T J) / chi + lambda (det^2 + 1) / chi with
//                 chi = (det + sqrt(det^2 + eps^2)) / 2, eps falling with the worst determinant.
// [Nocedal, Wright 2006] Numerical Optimization, algorithm 7.4: limited-memory BFGS.
#include "geometry/parameterize/flip_repair.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>

#include "geometry/metrics/map_metrics.h"
#include "geometry/parameterize/rest_shapes.h"

namespace dgm::bake {
namespace {
constexpr double kMostConformal = 0.1, kMostIsometric = 0.4;  // of the disk's faces, in patches
// Faces in patches, over flipped ones, in one try after the other: where a map has collapsed, much has to give way.
constexpr std::array kFacesPerFlip{1.0, 6.0};
constexpr int kLeastRings = 2;

bool is_positive(const std::vector<Vec2d>& uv, const Face& f) {
    return orient2d(uv[f[0]], uv[f[1]], uv[f[2]]) > 0;
}

/// Faces around each vertex.
struct Fans {
    std::vector<std::uint32_t> first, face;
    explicit Fans(const DiskView& disk) : first(disk.positions.size() + 1, 0), face(3 * disk.faces.size()) {
        for (const Face& f : disk.faces)
            for (const std::uint32_t v : f) ++first[v + 1];
        for (std::size_t v = 0; v + 1 < first.size(); ++v) first[v + 1] += first[v];
        std::vector<std::uint32_t> fill(first.begin(), first.end() - 1);
        for (std::uint32_t f = 0; f < disk.faces.size(); ++f)
            for (const std::uint32_t v : disk.faces[f]) face[fill[v]++] = f;
    }
};

/// Faces around the flipped ones, in groups that share no vertex: kLeastRings vertex rings, and more until they are
/// `faces_per_flip` times as many as those; empty if they are more than `most`.
std::vector<std::vector<std::uint32_t>> patches(const DiskView& disk, const Fans& fans, const std::vector<Vec2d>& uv,
                                                double faces_per_flip, double most) {
    std::vector<std::uint32_t> ring, all;
    std::vector<std::uint8_t> inside(disk.faces.size(), 0), seen(disk.positions.size(), 0);
    for (std::uint32_t f = 0; f < disk.faces.size(); ++f)
        if (!is_positive(uv, disk.faces[f])) {
            inside[f] = 1;
            ring.push_back(f);
        }
    all = ring;
    const double wanted = faces_per_flip * static_cast<double>(ring.size());
    for (int r = 0; r < kLeastRings || static_cast<double>(all.size()) < wanted; ++r) {
        std::vector<std::uint32_t> next;
        for (const std::uint32_t f : ring)
            for (const std::uint32_t v : disk.faces[f]) {
                if (seen[v] != 0) continue;
                seen[v] = 1;
                for (std::uint32_t k = fans.first[v]; k < fans.first[v + 1]; ++k)
                    if (inside[fans.face[k]] == 0) {
                        inside[fans.face[k]] = 1;
                        next.push_back(fans.face[k]);
                    }
            }
        ring.swap(next);
        all.insert(all.end(), ring.begin(), ring.end());
        if (static_cast<double>(all.size()) > most || ring.empty()) return {};
    }
    std::vector<std::vector<std::uint32_t>> out;
    for (const std::uint32_t seed : all) {
        if (inside[seed] != 1) continue;
        std::vector<std::uint32_t> group{seed};
        inside[seed] = 2;
        for (std::size_t k = 0; k < group.size(); ++k)
            for (const std::uint32_t v : disk.faces[group[k]])
                for (std::uint32_t e = fans.first[v]; e < fans.first[v + 1]; ++e)
                    if (inside[fans.face[e]] == 1) {
                        inside[fans.face[e]] = 2;
                        group.push_back(fans.face[e]);
                    }
        std::sort(group.begin(), group.end());
        out.push_back(std::move(group));
    }
    return out;
}

class Patch {
 public:
    Patch(const DiskView& disk, const std::vector<RestShape>& rest, const Fans& fans,
          const std::vector<std::uint32_t>& group, RepairShape shape, std::vector<Vec2d>& uv)
        : disk_(disk), group_(group), uv_(uv), size_weight_(shape == RepairShape::kIsometric ? 1.0 : 0.01) {
        unknown_.assign(3 * group.size(), -1);
        std::vector<std::uint32_t> vertices;
        for (const std::uint32_t f : group)
            for (const std::uint32_t v : disk.faces[f]) vertices.push_back(v);
        std::sort(vertices.begin(), vertices.end());
        std::vector<std::uint32_t> uses;
        for (const std::uint32_t v : vertices) {
            if (vertices_.empty() || vertices_.back() != v) {
                vertices_.push_back(v);
                uses.push_back(0);
            }
            ++uses.back();
        }
        // Free are the vertices whose faces are all in the patch.
        std::vector<int> number(vertices_.size(), -1);
        for (std::size_t k = 0; k < vertices_.size(); ++k)
            if (uses[k] == fans.first[vertices_[k] + 1] - fans.first[vertices_[k]]) {
                number[k] = static_cast<int>(free_.size());
                free_.push_back(vertices_[k]);
            }
        double surface = 0, map = 0;
        for (std::size_t g = 0; g < group.size(); ++g) {
            const Face& face = disk.faces[group[g]];
            for (std::size_t k = 0; k < 3; ++k) {
                const auto it = std::lower_bound(vertices_.begin(), vertices_.end(), face[k]);
                unknown_[3 * g + k] = number[static_cast<std::size_t>(it - vertices_.begin())];
            }
            rest_.push_back(rest[group[g]]);
            surface += rest_.back().area;
            map += 0.5 * cross(uv[face[1]] - uv[face[0]], uv[face[2]] - uv[face[0]]);
        }
        // A conformal map has a scale of its own here.
        const double scale = shape == RepairShape::kConformal && map > 0 ? std::sqrt(map / surface) : 1;
        for (RestShape& r : rest_) {
            for (Vec2d& b : r.hat) b = b * (1 / scale);
            r.area /= surface;
        }
        x_.resize(static_cast<Eigen::Index>(2 * free_.size()));
        for (std::size_t k = 0; k < free_.size(); ++k) put(x_, k, uv[free_[k]]);
    }

    /// True, with the vertices moved, if no face of the patch is flipped any more.
    bool untangle(const model::Progress& progress) {
        constexpr int kRounds = 40, kSteps = 60;
        if (free_.empty()) return false;
        for (int round = 0; round < kRounds; ++round) {
            progress.update("flip repair", static_cast<double>(round) / kRounds);
            const double worst = std::min(least_determinant(), 0.0);
            epsilon_ = std::sqrt(1e-12 + 0.04 * worst * worst);
            const bool moved = descend(kSteps);
            for (std::size_t k = 0; k < free_.size(); ++k) uv_[free_[k]] = point(x_, k);
            if (std::all_of(group_.begin(), group_.end(),
                            [&](std::uint32_t f) { return is_positive(uv_, disk_.faces[f]); }))
                return true;
            if (!moved) return false;
        }
        return false;
    }

 private:
    static void put(Eigen::VectorXd& x, std::size_t k, Vec2d p) {
        x[static_cast<Eigen::Index>(2 * k)] = p.x;
        x[static_cast<Eigen::Index>(2 * k + 1)] = p.y;
    }
    static Vec2d point(const Eigen::VectorXd& x, std::size_t k) {
        return {x[static_cast<Eigen::Index>(2 * k)], x[static_cast<Eigen::Index>(2 * k + 1)]};
    }

    struct Jacobian {
        double a = 0, b = 0, c = 0, d = 0;
        [[nodiscard]] double determinant() const { return a * d - b * c; }
    };
    [[nodiscard]] Jacobian jacobian(const Eigen::VectorXd& x, std::size_t g) const {
        Jacobian j;
        for (std::size_t k = 0; k < 3; ++k) {
            const int u = unknown_[3 * g + k];
            const Vec2d p = u >= 0 ? point(x, static_cast<std::size_t>(u)) : uv_[disk_.faces[group_[g]][k]];
            const Vec2d& h = rest_[g].hat[k];
            j.a += p.x * h.x;
            j.b += p.x * h.y;
            j.c += p.y * h.x;
            j.d += p.y * h.y;
        }
        return j;
    }
    [[nodiscard]] double least_determinant() const {
        double least = 1;
        for (std::size_t g = 0; g < group_.size(); ++g) least = std::min(least, jacobian(x_, g).determinant());
        return least;
    }

    double energy(const Eigen::VectorXd& x, Eigen::VectorXd& gradient) const {
        gradient.setZero(x.size());
        double sum = 0;
        for (std::size_t g = 0; g < group_.size(); ++g) {
            const Jacobian j = jacobian(x, g);
            const double det = j.determinant(), root = std::sqrt(det * det + epsilon_ * epsilon_);
            // For det < 0 the sum cancels: use eps^2 / (root - det) instead.
            const double chi = det > 0 ? 0.5 * (det + root) : 0.5 * epsilon_ * epsilon_ / (root - det);
            const double slope = chi / root;  // d chi / d det
            const double trace = j.a * j.a + j.b * j.b + j.c * j.c + j.d * j.d;
            const double top = trace + size_weight_ * (det * det + 1), w = rest_[g].area;
            sum += w * top / chi;
            const double of_j = 2 * w / chi, of_det = w * (2 * size_weight_ * det / chi - top * slope / (chi * chi));
            const Jacobian p{of_j * j.a + of_det * j.d, of_j * j.b - of_det * j.c, of_j * j.c - of_det * j.b,
                             of_j * j.d + of_det * j.a};
            for (std::size_t k = 0; k < 3; ++k) {
                const int u = unknown_[3 * g + k];
                if (u < 0) continue;
                const Vec2d& h = rest_[g].hat[k];
                gradient[2 * u] += p.a * h.x + p.b * h.y;
                gradient[2 * u + 1] += p.c * h.x + p.d * h.y;
            }
        }
        return std::isfinite(sum) ? sum : INFINITY;
    }

    /// At most `steps` steps of limited-memory BFGS with backtracking. False if the first one gains nothing.
    bool descend(int steps) {
        constexpr std::size_t kMemory = 8;
        struct Pair {
            Eigen::VectorXd s, y;
            double inverse;
        };
        std::deque<Pair> memory;
        Eigen::VectorXd gradient, next_gradient, direction, next;
        double value = energy(x_, gradient);
        bool moved = false;
        for (int step = 0; step < steps && std::isfinite(value); ++step) {
            direction = gradient;
            std::vector<double> alpha(memory.size());
            for (std::size_t k = memory.size(); k-- > 0;) {
                alpha[k] = memory[k].inverse * memory[k].s.dot(direction);
                direction -= alpha[k] * memory[k].y;
            }
            if (memory.empty()) {
                // First step: a hundredth of the patch's size at most.
                const double most = direction.cwiseAbs().maxCoeff();
                if (!(most > 0)) return moved;
                double span = 0;
                for (const std::uint32_t v : vertices_) span = std::max(span, length(uv_[v] - uv_[vertices_[0]]));
                direction *= 0.01 * span / most;
            } else {
                direction *= 1 / (memory.back().inverse * memory.back().y.squaredNorm());
            }
            for (std::size_t k = 0; k < memory.size(); ++k) {
                const double beta = memory[k].inverse * memory[k].y.dot(direction);
                direction += (alpha[k] - beta) * memory[k].s;
            }
            const double slope = -gradient.dot(direction);
            if (!(slope < 0)) break;
            double t = 1, lowered = value;
            for (int halving = 0; halving < 30; ++halving, t *= 0.5) {
                next = x_ - t * direction;
                lowered = energy(next, next_gradient);
                if (lowered <= value + 1e-4 * t * slope) break;
            }
            if (!(lowered < value)) break;
            moved = true;
            Pair pair{next - x_, next_gradient - gradient, 0};
            const double curvature = pair.s.dot(pair.y);
            const double gain = value - lowered;
            x_.swap(next);
            gradient.swap(next_gradient);
            value = lowered;
            if (curvature > 0) {
                pair.inverse = 1 / curvature;
                memory.push_back(std::move(pair));
                if (memory.size() > kMemory) memory.pop_front();
            } else {
                memory.clear();
            }
            if (gain < 1e-6 * value) break;
        }
        return moved;
    }

    const DiskView& disk_;
    const std::vector<std::uint32_t>& group_;
    std::vector<Vec2d>& uv_;
    double size_weight_;
    std::vector<std::uint32_t> vertices_, free_;
    std::vector<int> unknown_;  // of each corner
    std::vector<RestShape> rest_;
    Eigen::VectorXd x_;
    double epsilon_ = 0;
};
}  // namespace

std::optional<std::vector<Vec2d>> repair_flips(const DiskView& disk, std::vector<Vec2d> uv, RepairShape shape,
                                               const model::Progress& progress) {
    progress.update("flip repair", 0);
    const Fans fans(disk);
    const std::vector<RestShape> rest = rest_shapes(disk);
    const double most =
        (shape == RepairShape::kIsometric ? kMostIsometric : kMostConformal) * static_cast<double>(disk.faces.size());
    for (const double faces_per_flip : kFacesPerFlip) {
        const std::vector<std::vector<std::uint32_t>> groups = patches(disk, fans, uv, faces_per_flip, most);
        if (groups.empty()) return std::nullopt;
        bool all = true;
        for (const std::vector<std::uint32_t>& group : groups) {
            std::vector<Vec2d> before;
            for (const std::uint32_t f : group)
                for (const std::uint32_t v : disk.faces[f]) before.push_back(uv[v]);
            if (Patch(disk, rest, fans, group, shape, uv).untangle(progress)) continue;
            all = false;
            std::size_t k = 0;
            for (const std::uint32_t f : group)
                for (const std::uint32_t v : disk.faces[f]) uv[v] = before[k++];
        }
        if (all) return uv;
    }
    return std::nullopt;
}

}  // namespace dgm::bake
