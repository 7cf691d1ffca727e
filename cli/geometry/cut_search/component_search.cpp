// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/component_search.cpp
#include "geometry/cut_search/component_search.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "geometry/cut_search/cut_transfer.h"
#include "geometry/cut_search/cut_trial.h"
#include "geometry/cut_search/hidden_cut.h"
#include "geometry/cut_search/ring_cut.h"
#include "geometry/cut_search/star_cut.h"
#include "geometry/cut_search/straight_cut.h"
#include "math/portable.h"

namespace dgm::bake {
namespace {

constexpr double kExact = 1e-10;  // normalised units
constexpr int kMostLimbs = 640;   // joined while no map was found
constexpr double kGain = 0.99;    // a trial must lower the error by 1 % to count
// The prediction does not see that the fit reaches less beside a seam, above all where there are more samples than
// vertices. A cut longer by the diagonal must be worth so much of the error's logarithm. 0.15 takes tips off limbs.
constexpr double kSeamCost = 0.08;

/// Roots of loops about the handles with the lengths of their cuts, shortest first.
std::vector<std::pair<double, std::uint32_t>> roots_by_length(const CutGraph& uncut, const model::Progress& progress) {
    // Many handles take long, and one place among them is as good as another.
    constexpr std::size_t kLoops = 24 * 16;
    const std::size_t roots = std::clamp<std::size_t>(kLoops / static_cast<std::size_t>(uncut.genus()), 2, 24);
    const std::size_t n = uncut.mesh().positions.size();
    std::vector<std::pair<double, std::uint32_t>> by_length;
    const auto length_from = [&](std::uint32_t root) {
        CutGraph cut = uncut;
        cut.cut_to_disk(root);
        by_length.emplace_back(cut.length(), root);
    };
    length_from(kNone);
    for (std::size_t k = 0; k < roots; ++k) {
        progress.update("cut", 0);
        length_from(static_cast<std::uint32_t>(k * n / roots));
    }
    std::sort(by_length.begin(), by_length.end());
    by_length.erase(std::unique(by_length.begin(), by_length.end()), by_length.end());
    return by_length;
}

/// Area of the faces about each vertex on the surface over that in the map.
std::vector<double> shrinkage(const Trial& trial, std::size_t vertices) {
    std::vector<double> surface(vertices, 0.0), map(vertices, 0.0);
    const std::vector<Vec3d>& q = trial.split.mesh.positions;
    for (const Face& f : trial.split.mesh.faces) {
        const double area = face_area({q[f[0]], q[f[1]], q[f[2]]});
        const double mapped = signed_area(trial.uv[f[0]], trial.uv[f[1]], trial.uv[f[2]]);
        for (const std::uint32_t v : f) {
            const std::uint32_t point = trial.split.weld[v];
            if (point >= vertices) continue;
            surface[point] += area;
            map[point] += mapped;
        }
    }
    for (std::size_t v = 0; v < vertices; ++v) surface[v] /= std::max(map[v], std::numeric_limits<double>::min());
    return surface;
}

/// The vertex whose surroundings shrank most in the map; without a map, the one farthest from the cut. kNone if all
/// vertices are on the cut.
/// @param distance  of each vertex to the cut
std::uint32_t extremity(const std::vector<double>& distance, const Trial& trial) {
    std::vector<double> score = distance;
    if (!trial.uv.empty()) {
        score = shrinkage(trial, distance.size());
        for (std::size_t v = 0; v < score.size(); ++v)
            if (!(distance[v] > 0)) score[v] = 0;
    }
    const auto it = std::max_element(score.begin(), score.end());
    return *it > 0 ? static_cast<std::uint32_t>(it - score.begin()) : kNone;
}

/// Dead-end branches of a cut as half-edges, longest first; the only branch of a closed body is none.
std::vector<std::vector<std::uint32_t>> dead_ends(const CutGraph& cut, std::size_t most) {
    const Disk disk = cut.open();
    const std::vector<BorderPath> paths = disk.paths();
    std::vector<std::pair<double, std::vector<std::uint32_t>>> found;
    if (paths.size() > 2)
        for (std::size_t p = 0; p < paths.size(); ++p)
            if (paths[p].mate == (p + 1) % paths.size()) found.emplace_back(-paths[p].length, paths[p].half_edges);
    std::sort(found.begin(), found.end());
    if (found.size() > most) found.resize(most);
    std::vector<std::vector<std::uint32_t>> out;
    out.reserve(found.size());
    for (auto& entry : found) out.push_back(std::move(entry.second));
    return out;
}

/// The best cut so far, and the trials of others.
class ComponentSearch {
 public:
    ComponentSearch(const TriMesh& component, const CutSearchOptions& options, const model::Progress& progress)
        : component_(component), options_(options), progress_(progress), trials_(component, options, progress) {}

    [[nodiscard]] ComponentCut best() {
        if (options_.rings > 0) {
            try_rings();
        } else if (!options_.only_stars) {
            augment(first_cut());
            if (!best_) throw *trials_.failure();
            if (out_.extremities <= options_.max_extremities) drop_branches();  // few of hundreds matter little
            try_rotations();
        }
        if (options_.rings == 0 && options_.stars > 0 && !(best_ && out_.rms < kExact)) try_stars();
        if (!best_) throw *trials_.failure();
        if (options_.given_to_hide > 0 && !options_.measured) hide();
        out_.disk = best_->open();
        bool straight = false;
        if (best_->length() > 0 && !options_.measured && !(out_.rms < kExact)) straight = pull_straight();
        out_.cut_length = length_of_cut(out_.disk);
        out_.trials = trials_.count();
        return {std::move(out_), std::move(*best_), straight};
    }

 private:
    Trial attempt(const CutGraph& cut, std::optional<std::uint32_t> rotation,
                  BorderShares shares = BorderShares::kByLength) {
        return trials_.attempt(cut.open(), rotation, shares);
    }

    [[nodiscard]] static double score(const CutGraph& cut, const Trial& trial) {
        return trial.rms * math::exp(kSeamCost * cut.length());
    }

    void keep(const CutGraph& cut, const Trial& trial, BorderShares shares = BorderShares::kByLength) {
        best_.emplace(cut);
        out_.rms = trial.rms;
        score_ = score(cut, trial);
        out_.rotation = trial.rotation;
        out_.shares = shares;
    }

    /// Loops about handles depend on where they meet: the best of the shortest cuts from some places, or the next best
    /// ones.
    [[nodiscard]] CutGraph first_cut() {
        const CutGraph uncut(component_);
        CutGraph best = uncut;
        best.cut_to_disk(kNone, options_.start);
        if (uncut.genus() == 0 || options_.measured) return best;
        constexpr std::size_t kTried = 4;
        const std::vector<std::pair<double, std::uint32_t>> roots = roots_by_length(uncut, progress_);
        std::vector<std::pair<double, CutGraph>> tried;
        for (std::size_t k = 0; k < std::min(kTried, roots.size()); ++k) {
            CutGraph cut = uncut;
            cut.cut_to_disk(roots[k].second);
            const double found = score(cut, attempt(cut, std::nullopt));
            if (found < kInfinity) tried.emplace_back(found, std::move(cut));
        }
        std::stable_sort(tried.begin(), tried.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
        if (tried.empty()) return best;
        return std::move(tried[std::min(static_cast<std::size_t>(options_.start), tried.size() - 1)].second);
    }

    /// Joins the most shrunk vertex to the cut, again and again [Gu, Gortler, Hoppe 2002].
    void augment(CutGraph cut) {
        out_.rms = score_ = kInfinity;
        int idle = 0;
        std::vector<double> distance(component_.positions.size(), kInfinity);
        for (int k = 0; k <= options_.max_extremities || (!best_ && k <= kMostLimbs); ++k) {
            const bool tried = best_ || is_worth_a_trial(k);
            const Trial trial = tried ? attempt(cut, std::nullopt) : Trial{};
            if (score(cut, trial) < kGain * score_) {
                idle = 0;
                keep(cut, trial);
                out_.extremities = k;
            } else {
                ++idle;
            }
            if (out_.rms < kExact) break;  // a flat panel: only rounding is left
            // A border that is too short for its paths is no longer with one more.
            if (!best_ && !options_.measured && trials_.failure()->code().number == model::codes::kGridTooSmall.number)
                break;
            // While nothing valid was found, keep going: a body with limbs needs its limbs cut first.
            if (idle > options_.patience && best_) break;
            cut.follow_cut(distance);
            const std::uint32_t vertex = extremity(distance, trial);
            if (vertex == kNone || cut.join(vertex) <= 0) break;
        }
    }

    /// Heals each dead-end branch in turn, longest first, where that lowers the error.
    void drop_branches() {
        for (const std::vector<std::uint32_t>& branch : dead_ends(*best_, options_.drops)) {
            CutGraph without = *best_;
            for (const std::uint32_t h : branch) without.mark(h, false);
            const Trial trial = attempt(without, std::nullopt);
            if (score(without, trial) < kGain * score_) keep(without, trial);
        }
    }

    void try_rotations() {
        if (options_.rotations < 2 || out_.rms < kExact) return;
        const Disk disk = best_->open();
        for (const std::uint32_t r : candidate_rotations(disk, options_.m, options_.n, options_.rotations)) {
            if (r == out_.rotation) continue;
            const Trial trial = attempt(*best_, r);
            if (!(trial.rms < out_.rms)) continue;
            out_.rms = trial.rms;
            out_.rotation = r;
        }
    }

    /// Bodies with limbs are far from a sphere: the first stars show it, and the others are not worth their time.
    void try_stars() {
        constexpr std::size_t kFew = 3;
        constexpr double kFar = 1.1;
        double least = kInfinity;
        model::Progress silent;  // the stages below have shares of their own
        silent.cancelled = progress_.cancelled;
        try {
            const std::vector<CutGraph> cuts = star_cuts(component_, options_.stars, silent);
            for (std::size_t k = 0; k < cuts.size(); ++k) {
                if (k >= kFew && !options_.only_stars && least > kFar * out_.rms) break;
                const Trial trial = attempt(cuts[k], 0, BorderShares::kEqualArms);
                least = std::min(least, trial.rms);
                if (trial.rms < (best_ ? kGain * out_.rms : kInfinity)) keep(cuts[k], trial, BorderShares::kEqualArms);
            }
        } catch (const model::Error& e) { trials_.note(e); }
        if (!trials_.failure())
            trials_.note({model::codes::kMapInvalid, "sphere: no star of arms can be laid on the surface"});
    }

    /// On a square grid the loops may lie on either pair of sides.
    void try_rings() {
        std::vector<BorderShares> sides{BorderShares::kLoopsOnM};
        if (options_.m != options_.n) sides.push_back(BorderShares::kLoopsOnN);
        for (const CutGraph& cut : ring_cuts(component_, options_.rings))
            for (const BorderShares shares : sides) {
                const Trial trial = attempt(cut, 0, shares);
                if (trial.rms < (best_ ? kGain * out_.rms : kInfinity)) keep(cut, trial, shares);
            }
        if (!best_ && !trials_.failure())
            trials_.note({model::codes::kMethodUnsuited, "the surface is no ring: two sides, two loops, no handles"});
    }

    /// Leads the seams of the best cut through hidden places, all of them or those that gain most, where the error
    /// allows it.
    void hide() {
        constexpr std::size_t kSingles = 4;
        // The arms of a star are even on the sphere; detours would fold the parts between them.
        if (out_.shares != BorderShares::kByLength || out_.rms < kExact || best_->length() <= 0) return;
        CutGraph cut = *best_;
        cut.weigh(hiding_factors(component_, best_->opposite()));
        const std::vector<CutWay> ways = hideable_ways(cut);
        if (ways.empty()) return;
        const double most = options_.given_to_hide * out_.rms;
        const auto serves = [&](const CutGraph& hidden) {
            const Trial trial = attempt(hidden, rotation_on(hidden.open()));
            if (trial.rms > most) return false;
            keep(hidden, trial);
            return true;
        };
        CutGraph all = cut;
        for (const CutWay& way : ways) hide_way(all, way);
        if (serves(all)) return;
        for (std::size_t k = 0; k < std::min(kSingles, ways.size()) && ways.size() > 1; ++k) {
            CutGraph one = cut;
            hide_way(one, ways[k]);
            if (serves(one)) cut = std::move(one);
        }
    }

    /// The rotation that lays another cut as the best one is laid; nothing if they have no path in common.
    [[nodiscard]] std::optional<std::uint32_t> rotation_on(const Disk& disk) const {
        std::vector<std::uint32_t> same(component_.positions.size());
        std::iota(same.begin(), same.end(), 0u);
        return transfer_rotation(best_->open(), options_.m, options_.n, out_.rotation, same, disk, options_.m,
                                 options_.n);
    }

    /// Pulls paths of the best cut across faces where they are jagged along edges, unless that costs too much accuracy:
    /// where the grid shows each face of a coarse mesh, seams along its edges spare samples.
    bool pull_straight() {
        constexpr double kJagged = 0.03;  // share of the length that is lost
        constexpr double kWorth = 0.25;   // of that share: how much the error may grow
        Disk straight = open_straight(*best_, kStraightReach);
        const double shorter = 1 - length_of_cut(straight) / best_->length();
        if (shorter < kJagged) return false;
        std::uint32_t rotation = 0;
        if (out_.shares == BorderShares::kByLength) {
            const auto found = rotation_on(straight);
            rotation = found ? *found : candidate_rotations(straight, options_.m, options_.n, 1).front();
        }
        const Trial trial = trials_.attempt(straight, rotation, out_.shares);
        if (trial.rms > (1 + kWorth * shorter) * out_.rms) return false;
        out_.disk = std::move(straight);
        out_.rms = trial.rms;
        out_.rotation = rotation;
        return true;
    }

    const TriMesh& component_;
    const CutSearchOptions& options_;
    const model::Progress& progress_;
    CutTrials trials_;
    std::optional<CutGraph> best_;
    double score_ = kInfinity;  ///< of the best cut's trial, with the cost of its length
    CutSearchResult out_;
};

}  // namespace

bool is_worth_a_trial(int limbs) {
    constexpr unsigned kMostBetween = 16;
    const auto joined = static_cast<unsigned>(limbs);
    return joined % std::clamp(std::bit_floor(joined / 4), 1u, kMostBetween) == 0;
}

double length_of_cut(const Disk& disk) {
    double total = 0;
    Disk joined;
    if (!disk.mesh.points.empty()) (joined = disk).join_sides();
    for (const BorderPath& path : (disk.mesh.points.empty() ? disk : joined).paths())
        if (path.mate != kNone) total += 0.5 * path.length;
    return total;
}

ComponentCut search_component(const TriMesh& component, const CutSearchOptions& options,
                              const model::Progress& progress) {
    return ComponentSearch(component, options, progress).best();
}

}  // namespace dgm::bake
