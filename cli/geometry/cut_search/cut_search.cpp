// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/cut_search.cpp
#include "geometry/cut_search/cut_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "geometry/chart/square_chart.h"
#include "geometry/cut_search/cut_transfer.h"
#include "geometry/cut_search/hidden_cut.h"
#include "geometry/cut_search/star_cut.h"
#include "geometry/cut_search/straight_cut.h"
#include "geometry/cut_search/trial_map.h"
#include "geometry/mesh/infinity.h"
#include "geometry/simplify/simplify.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

constexpr double kExact = 1e-10;  // normalised units
constexpr double kReach = 1;      // of straight paths from those along edges, in mean edges of the mesh searched
constexpr double kGain = 0.99;    // a trial must lower the error by 1 % to count
/// A trial need not be as good as the bake, only as good as the other trials.
MultilevelOptions trial_options() {
    MultilevelOptions options;
    options.newton_steps = 8;
    options.coarsest_sweeps = 30;
    options.sweeps = 6;
    return options;
}

struct GridSides {
    std::uint32_t m, n;
};

double length_of_cut(const Disk& disk) {
    double total = 0;
    for (const BorderPath& path : disk.paths())
        if (path.mate != kNone) total += 0.5 * path.length;
    return total;
}

struct Trial {
    double rms = kInfinity;
    std::uint32_t rotation = 0;
    Disk split;             // as the border layout split it
    std::vector<Vec2d> uv;  // empty if the map failed
};

class Search {
 public:
    Search(const TriMesh& component, const CutSearchOptions& options, const model::Progress& progress)
        : component_(component),
          options_(options),
          progress_(progress),
          stretch_(options.reweighted ? make_reweighted_parameterizer() : make_stretch_parameterizer(0)),
          cut_(component),
          source_(measure_topology(component.positions.size(), component.faces)) {}

    CutSearchResult run() {
        if (!options_.only_stars) {
            begin();
            augment();
            if (!best_) throw *failure_;
            drop_branches();
            try_rotations();
        }
        if (options_.stars > 0 && !(best_ && out_.rms < kExact)) try_stars();
        if (!best_) throw *failure_;
        if (options_.given_to_hide > 0 && !options_.measured) hide();
        out_.disk = best_->open();
        if (best_->length() > 0 && !options_.measured && !(out_.rms < kExact)) pull_straight();
        out_.cut_length = length_of_cut(out_.disk);
        return std::move(out_);
    }

    /// Of the last run.
    [[nodiscard]] const CutGraph& best_cut() const { return *best_; }
    [[nodiscard]] bool runs_straight() const { return straight_; }

 private:
    /// Loops about handles depend on where they meet: of some places the best of the shortest cuts.
    void begin() {
        if (cut_.genus() == 0 || options_.measured) return cut_.cut_to_disk();
        // Many handles take long, and one place among them is as good as another.
        constexpr std::size_t kTried = 4, kLoops = 24 * 16;
        const std::size_t roots = std::clamp<std::size_t>(kLoops / static_cast<std::size_t>(cut_.genus()), 2, 24);
        const std::size_t n = component_.positions.size();
        std::vector<std::pair<double, std::uint32_t>> by_length;
        const auto length_from = [&](std::uint32_t root) {
            CutGraph cut = cut_;
            cut.cut_to_disk(root);
            by_length.emplace_back(cut.length(), root);
        };
        length_from(kNone);
        for (std::size_t k = 0; k < roots; ++k) {
            progress_.update("cut", 0);
            length_from(static_cast<std::uint32_t>(k * n / roots));
        }
        std::sort(by_length.begin(), by_length.end());
        by_length.erase(std::unique(by_length.begin(), by_length.end()), by_length.end());
        CutGraph best = cut_;
        best.cut_to_disk();
        double least = kInfinity;
        for (std::size_t k = 0; k < std::min(kTried, by_length.size()); ++k) {
            CutGraph cut = cut_;
            cut.cut_to_disk(by_length[k].second);
            if (const double rms = attempt(cut, std::nullopt).rms; rms < least) least = rms, best = std::move(cut);
        }
        cut_ = std::move(best);
    }

    /// One map and one measurement of a cut; keeps the first failure's reason.
    Trial attempt(const CutGraph& cut, std::optional<std::uint32_t> rotation,
                  BorderShares shares = BorderShares::kByLength) {
        return attempt(cut.open(), rotation, shares);
    }

    Trial attempt(Disk disk, std::optional<std::uint32_t> rotation, BorderShares shares) {
        progress_.update("cut", share());
        ++out_.trials;
        Trial trial;
        try {
            trial.rotation = rotation ? *rotation : candidate_rotations(disk, options_.m, options_.n, 1).front();
            if (!options_.measured) {
                TrialMap map = make_trial_map(std::move(disk), options_.m, options_.n, trial.rotation, trial_options(),
                                              {}, shares);
                trial.rms = map.rms;
                trial.split = std::move(map.disk);
                trial.uv = std::move(map.uv);
                return trial;
            }
            SampledChart chart =
                make_square_chart(std::move(disk), options_.m, options_.n, trial.rotation, *stretch_, {});
            if (!holds_topology(welded_topology(chart), source_))
                throw model::Error(model::codes::kGridTooSmall, "the grid does not hold the topology of the cut");
            trial.rms = quick_error(component_, chart, options_.samples).rms;
            trial.split = std::move(chart.disk);
            trial.uv = std::move(chart.uv);
        } catch (const model::Error& e) {
            if (e.code().number == model::codes::kInterrupted.number) throw;
            if (!failure_) failure_ = e;
        }
        return trial;
    }

    [[nodiscard]] double share() const {
        return std::min(0.95, out_.trials / (2.0 * options_.patience + options_.rotations + 6.0));
    }

    void keep(const CutGraph& cut, const Trial& trial, BorderShares shares = BorderShares::kByLength) {
        best_.emplace(cut);
        out_.rms = trial.rms;
        out_.rotation = trial.rotation;
        out_.shares = shares;
    }

    void augment() {
        out_.rms = kInfinity;
        int idle = 0;
        for (int k = 0; k <= options_.max_extremities; ++k) {
            const Trial trial = attempt(cut_, std::nullopt);
            if (trial.rms < kGain * out_.rms) {
                idle = 0;
                keep(cut_, trial);
                out_.extremities = k;
            } else {
                ++idle;
            }
            if (out_.rms < kExact) break;  // a flat panel: what is left is rounding
            // A border that is too short for its paths is no longer with one more.
            if (!best_ && !options_.measured && failure_->code().number == model::codes::kGridTooSmall.number) break;
            // While nothing valid was found, keep going: a body with limbs needs its limbs cut first.
            if (idle > options_.patience && best_) break;
            const std::uint32_t vertex = extremity(trial);
            if (vertex == kNone || cut_.join(vertex) <= 0) break;
        }
    }

    /// The vertex whose surroundings shrank most in the map; without a map, the one farthest from the cut.
    [[nodiscard]] std::uint32_t extremity(const Trial& trial) const {
        const std::vector<double> distance = cut_.distance_to_cut();
        const std::size_t n = component_.positions.size();
        std::vector<double> score(n, 0.0);
        if (trial.uv.empty()) {
            score = distance;
        } else {
            std::vector<double> surface(n, 0.0), map(n, 0.0);
            for (const Face& f : trial.split.mesh.faces) {
                const auto& q = trial.split.mesh.positions;
                const double area = face_area({q[f[0]], q[f[1]], q[f[2]]});
                const double mapped = signed_area(trial.uv[f[0]], trial.uv[f[1]], trial.uv[f[2]]);
                for (std::uint32_t v : f) {
                    const std::uint32_t point = trial.split.weld[v];
                    if (point < n) surface[point] += area, map[point] += mapped;
                }
            }
            for (std::size_t v = 0; v < n; ++v)
                if (distance[v] > 0) score[v] = surface[v] / std::max(map[v], std::numeric_limits<double>::min());
        }
        const auto it = std::max_element(score.begin(), score.end());
        return *it > 0 ? static_cast<std::uint32_t>(it - score.begin()) : kNone;
    }

    /// Heals each dead-end branch in turn, longest first, where that lowers the error.
    void drop_branches() {
        for (const std::vector<std::uint32_t>& branch : branches()) {
            CutGraph trial_cut = *best_;
            for (std::uint32_t h : branch) trial_cut.mark(h, false);
            const Trial trial = attempt(trial_cut, std::nullopt);
            if (trial.rms < kGain * out_.rms) keep(trial_cut, trial);
        }
    }

    /// Dead-end branches of the best cut as half-edges; the only branch of a closed body is none.
    [[nodiscard]] std::vector<std::vector<std::uint32_t>> branches() const {
        const Disk disk = best_->open();
        const std::vector<BorderPath> paths = disk.paths();
        std::vector<std::pair<double, std::vector<std::uint32_t>>> found;
        if (paths.size() > 2)
            for (std::size_t p = 0; p < paths.size(); ++p)
                if (paths[p].mate == (p + 1) % paths.size()) found.emplace_back(-paths[p].length, paths[p].half_edges);
        std::sort(found.begin(), found.end());
        if (found.size() > options_.drops) found.resize(options_.drops);
        std::vector<std::vector<std::uint32_t>> out;
        out.reserve(found.size());
        for (auto& entry : found) out.push_back(std::move(entry.second));
        return out;
    }

    void try_rotations() {
        if (options_.rotations < 2 || out_.rms < kExact) return;
        const Disk disk = best_->open();
        for (std::uint32_t r : candidate_rotations(disk, options_.m, options_.n, options_.rotations)) {
            if (r == out_.rotation) continue;
            const Trial trial = attempt(*best_, r);
            if (trial.rms < out_.rms) out_.rms = trial.rms, out_.rotation = r;
        }
    }

    /// Bodies with limbs are far from a sphere: there the first stars tell, and the others are not worth their time.
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
        } catch (const model::Error& e) {
            if (e.code().number == model::codes::kInterrupted.number) throw;
            if (!failure_) failure_ = e;
        }
        if (!failure_)
            failure_.emplace(model::codes::kMapInvalid, "sphere: no star of arms can be laid on the surface");
    }

    /// Leads the seams of the best cut through hidden places, all of them or those that gain most, where the error
    /// allows it.
    void hide() {
        constexpr std::size_t kSingles = 4;
        // The arms of a star are even on the sphere; detours would fold what lies between them.
        if (out_.shares == BorderShares::kEqualArms || out_.rms < kExact || best_->length() <= 0) return;
        CutGraph cut = *best_;
        cut.weigh(hiding_factors(component_, best_->opposite()));
        const std::vector<CutWay> ways = hideable_ways(cut);
        if (ways.empty()) return;
        const double most = options_.given_to_hide * out_.rms;
        std::vector<std::uint32_t> same(component_.positions.size());
        std::iota(same.begin(), same.end(), 0u);
        const auto serves = [&](const CutGraph& hidden) {
            const std::optional<std::uint32_t> rotation = transfer_rotation(
                best_->open(), options_.m, options_.n, out_.rotation, same, hidden.open(), options_.m, options_.n);
            const Trial trial = attempt(hidden, rotation);
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

    /// Paths of the best cut run across faces where they are jagged along edges, unless that costs more accuracy than
    /// they were jagged: where the grid shows each face of a coarse mesh, seams along its edges spare samples.
    void pull_straight() {
        constexpr double kJagged = 0.03;  // share of the length that is lost
        constexpr double kWorth = 0.25;   // of that share: how much the error may grow
        Disk straight = open_straight(*best_, kReach);
        const double shorter = 1 - length_of_cut(straight) / best_->length();
        if (shorter < kJagged) return;
        std::uint32_t rotation = 0;
        if (out_.shares != BorderShares::kEqualArms) {
            std::vector<std::uint32_t> same(component_.positions.size());
            std::iota(same.begin(), same.end(), 0u);
            const auto found = transfer_rotation(out_.disk, options_.m, options_.n, out_.rotation, same, straight,
                                                 options_.m, options_.n);
            rotation = found ? *found : candidate_rotations(straight, options_.m, options_.n, 1).front();
        }
        const Trial trial = attempt(straight, rotation, out_.shares);
        if (trial.rms > (1 + kWorth * shorter) * out_.rms) return;
        straight_ = true;
        out_.disk = std::move(straight);
        out_.rms = trial.rms;
        out_.rotation = rotation;
    }

    const TriMesh& component_;
    const CutSearchOptions& options_;
    const model::Progress& progress_;
    std::unique_ptr<Parameterizer> stretch_;
    CutGraph cut_;
    Topology source_;
    std::optional<CutGraph> best_;
    std::optional<model::Error> failure_;
    CutSearchResult out_;
    bool straight_ = false;
};

/// An m x n grid shrunk to `longest` samples along its longer side.
GridSides shrink(GridSides grid, double longest) {
    const double share = std::min(1.0, (longest - 1) / (std::max(grid.m, grid.n) - 1));
    const auto side = [&](std::uint32_t samples) {
        return std::max(std::min(samples, 3u), 1 + static_cast<std::uint32_t>(std::lround((samples - 1) * share)));
    };
    return {side(grid.m), side(grid.n)};
}

std::uint32_t scaled_rotation(const Disk& disk, GridSides from, std::uint32_t rotation, GridSides to) {
    if (from.m == to.m && from.n == to.n) return rotation;
    const double share = static_cast<double>(rotation) / BorderGrid{from.m, from.n}.count();
    return nearest_rotation(disk, to.m, to.n,
                            static_cast<std::uint32_t>(std::lround(share * BorderGrid{to.m, to.n}.count())));
}

CutSearchResult search_measured(const TriMesh& component, const CutSearchOptions& options, GridSides wanted,
                                const model::Progress& progress) {
    CutSearchOptions on_itself = options;
    on_itself.measured = true;
    on_itself.stars = 0;
    // The cut hardly depends on the resolution from here on, its cost does.
    const GridSides grid = shrink(wanted, 257);
    on_itself.m = grid.m, on_itself.n = grid.n;
    CutSearchResult out = Search(component, on_itself, progress).run();
    out.rotation = scaled_rotation(out.disk, grid, out.rotation, wanted);
    return out;
}

/// Corners of the real border: a simplified border must keep them, they are nodes of it.
std::vector<char> border_corners(const TriMesh& mesh) {
    std::vector<char> corners(mesh.positions.size(), 0);
    const std::vector<std::uint32_t> opposite = opposite_half_edges(mesh.faces);
    const auto direction = [&](std::uint32_t h) {
        return normalized(mesh.positions[target(mesh.faces, h)] - mesh.positions[origin(mesh.faces, h)], Vec3d{});
    };
    const double limit = std::cos(50 * M_PI / 180);  // as Disk::paths
    for (std::uint32_t h = 0; h < opposite.size(); ++h)
        if (opposite[h] == kNone)
            if (dot(direction(h), direction(next_border_half_edge(opposite, h))) < limit)
                corners[target(mesh.faces, h)] = 1;
    return corners;
}

bool is_sphere(const TriMesh& mesh) {
    const Topology topology = measure_topology(mesh.positions.size(), mesh.faces);
    return topology.boundary_loops == 0 && topology.genus == 0;
}

}  // namespace

CutSearchResult search_cut(const TriMesh& component, const CutSearchOptions& options, const model::Progress& progress) {
    const GridSides wanted{options.m, options.n};
    const bool even = wanted.m % 2 == 0 || wanted.n % 2 == 0;
    if (options.only_stars && even)
        throw model::Error(model::codes::kMethodUnsuited,
                           "sphere: each side of the square folds at its middle sample, which even numbers of samples "
                           "do not have");
    if (options.measured) return search_measured(component, options, wanted, progress);
    CutSearchOptions trial = options;
    const bool simplified = component.faces.size() > options.coarse_faces + options.coarse_faces / 2;
    Simplified small;
    CompactMesh coarse;
    if (simplified) {
        const std::vector<char> corners = border_corners(component);
        SimplifyOptions simplify_options;
        simplify_options.locked = corners;
        small = simplify(component, options.coarse_faces, simplify_options, progress);
        coarse = compact(component.positions, small.faces);
    }
    const TriMesh& mesh = simplified ? coarse.mesh : component;
    // As many samples a vertex as the whole bake has, within limits.
    const double share = std::sqrt(static_cast<double>(mesh.positions.size()) / component.positions.size());
    const double longest = (std::max(wanted.m, wanted.n) - 1) * share + 1;
    const double largest = options.largest_side;
    GridSides grid = shrink(wanted, std::clamp(longest, 0.5 * largest, largest));
    // A network of 6g - 3 paths about g handles stands twice on the border; a path wants two intervals.
    const Topology shape = measure_topology(component.positions.size(), component.faces);
    const double intervals = 4 * (6.0 * static_cast<double>(shape.genus) - 3);
    if (BorderGrid{grid.m, grid.n}.count() < intervals) grid = wanted;
    if (!options.only_stars && (even || !is_sphere(mesh))) trial.stars = 0;
    if (trial.stars > 0) grid.m |= 1u, grid.n |= 1u;
    trial.m = grid.m, trial.n = grid.n;
    try {
        Search search(mesh, trial, progress);
        CutSearchResult out = search.run();
        const bool star = out.shares == BorderShares::kEqualArms;
        if (!simplified) {
            if (!star) out.rotation = scaled_rotation(out.disk, grid, out.rotation, wanted);
            return out;
        }
        CutGraph fine(component);
        if (!transfer_cut(search.best_cut(), coarse.original, small, fine))
            throw model::Error(model::codes::kMapInvalid, "the cut of the simplified mesh could not be carried over");
        const Disk coarse_disk = std::move(out.disk);
        const double finer =
            std::sqrt(static_cast<double>(component.faces.size()) / static_cast<double>(small.faces.size()));
        out.disk = search.runs_straight() ? open_straight(fine, kReach * finer) : fine.open();
        out.cut_length = length_of_cut(out.disk);
        if (star) return out;
        const auto rotation =
            transfer_rotation(coarse_disk, grid.m, grid.n, out.rotation, coarse.original, out.disk, wanted.m, wanted.n);
        out.rotation = rotation ? *rotation : candidate_rotations(out.disk, wanted.m, wanted.n, 1).front();
        return out;
    } catch (const model::Error& e) {
        if (e.code().number == model::codes::kInterrupted.number || options.only_stars) throw;
        if (options.only_simplified && trial.stars == 0) throw;
        // Where the border has no room for the paths of a simplified mesh, the whole one will find no more.
        if (trial.stars == 0 && e.code().number == model::codes::kGridTooSmall.number && grid.m == wanted.m &&
            grid.n == wanted.n)
            throw;
    }
    if (trial.stars > 0) {  // a star may come to nothing where another cut does not
        CutSearchOptions others = options;
        others.stars = 0;
        return search_cut(component, others, progress);
    }
    return search_measured(component, options, wanted, progress);
}

}  // namespace dgm::bake
