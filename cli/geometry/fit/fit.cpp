// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/fit.cpp
#include "geometry/fit/fit.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "geometry/fit/border_rails.h"
#include "geometry/fit/diagonals.h"
#include "geometry/fit/fit_rows.h"
#include "geometry/fit/inverted_faces.h"
#include "geometry/fit/lattice_snap.h"
#include "geometry/fit/matches.h"
#include "geometry/fit/normal_equations.h"
#include "geometry/fit/patch_repair.h"
#include "geometry/fit/search_repair.h"
#include "geometry/fit/sliding.h"
#include "geometry/fit/vertex_repair.h"
#include "geometry/metrics/turned_faces.h"

namespace dgm::bake {
namespace {

// Chosen by measurement on organs and busts: the first two trade the speed of a step against its stability.
constexpr double kDamping = 0.001;
constexpr int kCgIterations = 20;
constexpr double kStartUpright = 0.2, kEndUpright = 0.02;  // faces below are mended at the start and at the end
constexpr int kDiagonalRounds = 9;
constexpr double kSureGain = 0.6;                           // in rms; ordinary charts reach 0.2
constexpr double kMendingPrice = 1.5, kMendingLargest = 3;  // in rms and in the largest error, of fewer inverted faces
constexpr double kRefitLargest = 1.02;     // largest error after refitting over before, where it is held ...
constexpr double kRefitLargestFree = 1.3;  // ... and where it is not
constexpr double kRefitGain = 2e-3;        // in rms, of two rounds, to go on
constexpr double kRoundingPrice = 1.03;    // in rms, of faces that rounding may turn
constexpr std::uint64_t kFewSamples = 20'000;
constexpr double kExact = 1e-10;  // normalised units: nothing is left to fit

/// What is in either of two ascending lists.
std::vector<std::uint32_t> joined(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
    std::vector<std::uint32_t> out;
    std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(out));
    return out;
}

/// Of two ascending lists, what only the first has.
std::vector<std::uint32_t> without(const std::vector<std::uint32_t>& all, const std::vector<std::uint32_t>& known) {
    std::vector<std::uint32_t> out;
    std::set_difference(all.begin(), all.end(), known.begin(), known.end(), std::back_inserter(out));
    return out;
}

class Fitter {
 public:
    Fitter(SampledChart& chart, const FitOptions& options, const model::Progress& progress)
        : chart_(chart),
          options_(options),
          progress_(progress),
          source_(link_source(chart.disk)),
          grid_(chart),
          matches_(chart, source_, grid_, point_count(chart, options)),
          fixed_(grid_.on_border),
          rails_(chart, source_, grid_),
          upward_(normals_at_scale(source_, surface_area(source_) / static_cast<double>(chart.grid_count()))),
          sliding_(grid_, matches_, rails_, upward_, fixed_),
          inverted_(source_, grid_.surface, matches_.source_index()),
          rows_(source_, grid_, matches_, rails_, options.points_per_sample) {}

    FitReport run() {
        FitReport report;
        const SampledChart start = chart_;
        matches_.update(false);
        report.start_rms = matches_.rms, report.start_hausdorff = matches_.largest;
        if (largest() < kExact)
            keep();
        else
            fit(report);
        tell(options_.rounds + options_.worst_rounds);
        mend_inverted();
        mend_nearly_inverted();
        if (options_.on_lattice) put_on_lattice();
        finish();
        report.rms = kept_.rms, report.hausdorff = kept_.largest;
        // Walks flatter a map that folds: where they promise little, what all faces say decides.
        const bool moved = chart_.positions != start.positions || chart_.diagonals != start.diagonals;
        if (moved && kept_.rms > kSureGain * report.start_rms) {
            const TriMesh& mesh = chart_.disk.mesh;
            const SurfaceError before = quick_error(mesh, start, kFewSamples),
                               after = quick_error(mesh, chart_, kFewSamples);
            // What was mended may cost something where as much was inverted that the start's figures mean little.
            const double price = after.hausdorff <= kMendingLargest * before.hausdorff ? kMendingPrice : 1;
            if (before.rms < after.rms &&
                (before.rms * price < after.rms || inverted_in(start) <= inverted_.faces().size())) {
                chart_ = start;
                report.rms = report.start_rms, report.hausdorff = report.start_hausdorff, report.rounds = 0;
            }
        }
        return report;
    }

 private:
    void fit(FitReport& report) {
        if (options_.split_quads) split_quads();
        if (sliding_.occupy_corners()) matches_.update(false);
        if (repair_by_vertex(source_, grid_, matches_, fixed_, kStartUpright)) matches_.update(false);
        keep();
        bool kept = true;
        for (int round = 0; round < options_.rounds; ++round) {
            tell(round);
            if (options_.split_quads && round % 2 == 0 && round < kDiagonalRounds) split_quads();
            step(false);
            matches_.update(false);
            kept = matches_.rms < kept_.rms;
            if (kept) keep(), ++report.rounds;
        }
        if (!kept || options_.worst_rounds > 0) restore(), matches_.update(false);
        if (options_.worst_rounds > 0) mend_inverted(), settle(report);
    }

    /// The rounds for the largest error, and the diagonals that go with them.
    void settle(FitReport& report) {
        lower_largest(report);
        restore();
        if (options_.split_quads) {
            split_quads();
            look_up_farthest();
            if (matches_.rms < kept_.rms && largest() <= kept_.largest)
                keep();
            else
                restore();
        }
        matches_.update(false);
    }

    [[nodiscard]] std::size_t inverted_in(const SampledChart& chart) {
        return find_turned_faces(inverted_.source_index(), chart.surface(), kTurnedTie).size();
    }

    static std::size_t point_count(const SampledChart& chart, const FitOptions& options) {
        const double samples = static_cast<double>(chart.grid_count()), wanted = options.points_per_sample * samples;
        return static_cast<std::size_t>(std::max(wanted, std::min(200'000.0, 3 * wanted)));
    }

    void tell(int round) const {
        constexpr int kMending = 2;  // rounds that what follows the last one takes as long as
        progress_.update("fit", static_cast<double>(round) / (options_.rounds + options_.worst_rounds + kMending));
    }

    [[nodiscard]] double largest() const { return std::max(matches_.largest, rails_.largest_gap()); }

    void keep() { kept_ = {matches_.rms, largest(), grid_.surface.positions, chart_.diagonals, rails_.places()}; }
    void restore() {
        grid_.surface.positions = kept_.positions, chart_.diagonals = kept_.diagonals;
        relink();
        rails_.set_places(kept_.places);
    }

    struct Kept {
        double rms = 0, largest = 0;
        std::vector<Vec3d> positions;
        std::vector<std::uint8_t> diagonals;
        std::vector<double> places;
    };
    void go_back_to(const Kept& before) {
        kept_ = before;
        restore();
        matches_.update(true);
    }

    [[nodiscard]] std::vector<std::uint32_t> inverted_now() { return inverted_.faces({}, nearly_); }

    void relink() {
        grid_.link(chart_);
        rows_.forget_edges();
    }

    void look_up_farthest() {
        matches_.update(true);
        matches_.settle_farthest(inverted_.source_index());
    }

    /// Rounds that pull hardest where the error is near the largest, at a bounded price in the mean. None that turns a
    /// face counts: to turn it back would cost more than was gained.
    void lower_largest(FitReport& report) {
        look_up_farthest();
        const double allowed = kept_.rms * std::pow(10, options_.worst_price_db / 20);
        kept_.largest = largest();
        const std::vector<std::uint32_t> left = inverted_.doubtful_faces(matches_, kEndUpright);
        for (int round = 0; round < options_.worst_rounds; ++round) {
            tell(options_.rounds + round);
            const std::vector<Vec3d> before = grid_.surface.positions;
            step(true);
            matches_.update(true);
            const bool sound =
                take_back(before, [&] { return without(inverted_.doubtful_faces(matches_, kEndUpright), left); });
            matches_.settle_farthest(inverted_.source_index());
            const bool closer = largest() < kept_.largest && matches_.rms <= allowed;
            if (sound && (closer || (largest() <= kept_.largest && matches_.rms < kept_.rms))) keep(), ++report.rounds;
        }
    }

    /// Corners of faces that a round has inverted go back to where they were before it.
    /// @param fresh_now  those faces, as the grid lies now
    /// @param went_back  per class: set where one did, if it is not empty
    /// @return  true if no such face is left
    template <class Fresh>
    bool take_back(const std::vector<Vec3d>& before, const Fresh& fresh_now, std::span<char> went_back = {}) {
        constexpr int kPasses = 3;
        LinkedSurface& grid = grid_.surface;
        for (int pass = 0;; ++pass) {
            const std::vector<std::uint32_t> fresh = fresh_now();
            if (fresh.empty()) return true;
            if (pass == kPasses) return false;
            std::vector<char> back(grid.positions.size(), 0), near(grid.faces.size(), 0);
            for (const std::uint32_t f : fresh)
                for (const std::uint32_t c : grid.faces[f]) back[c] = !fixed_[c];
            for (std::size_t c = 0; c < back.size(); ++c)
                if (back[c]) grid.positions[c] = before[c];
            for (std::size_t c = 0; c < went_back.size(); ++c) went_back[c] |= back[c];
            for (std::size_t f = 0; f < near.size(); ++f)
                for (const std::uint32_t c : grid.faces[f]) near[f] |= back[c];
            for (std::uint32_t f = 0; f < near.size(); ++f)
                if (near[f]) grid.update_normal(f);
            matches_.update(true, near);
        }
    }

    /// Faces that are inverted, by the measure (metrics/turned_faces.h), are mended where others do not turn for them.
    void mend_inverted() {
        const std::vector<std::uint32_t> inverted = inverted_now();
        if (inverted.empty() || (unmended_ && without(inverted, *unmended_).empty())) return;
        const Kept before = kept_;
        for (const bool all_ways : {true, false}) {
            if (!mend(all_ways) || inverted_now().size() < inverted.size() || kept_.rms <= before.rms) break;
            go_back_to(before);
        }
        unmended_ = inverted_now();
    }

    /// Walks end in local minima; the last faces to mend are those that the measure finds. What had to move is fitted
    /// again, as long as nothing turns.
    /// @param all_ways  not only those that count what they turn
    /// @return  true if something moved
    bool mend(bool all_ways) {
        constexpr int kSearches = 3;
        const std::vector<Vec3d> before = grid_.surface.positions;
        bool moved = all_ways && repair_vertices(), unfolded = false;
        if (moved) matches_.update(false);
        for (int round = 0; round < kSearches; ++round) {
            if (repair_patches()) moved = unfolded = true;
            const std::vector<std::uint32_t> left = inverted_now();
            if (left.empty() || !repair_by_search_of(left)) break;
            moved = true;
        }
        if (!moved) return false;
        matches_.update(true);
        keep();
        refit_around(before, unfolded);
        return true;
    }

    bool repair_vertices() {
        constexpr int kPasses = 10;
        const ClosestPointIndex& index = inverted_.source_index();
        bool moved = repair_by_vertex(source_, grid_, matches_, fixed_, kEndUpright);
        for (int pass = 0; pass < kPasses; ++pass) {
            const std::vector<std::uint32_t> inverted = inverted_now();
            for (const std::uint32_t f : inverted)
                if (const ClosestPoint hit = index.query(matches_.middles[f].position); hit.face != kNone)
                    matches_.middles[f].hit.face = hit.face;
            if (inverted.empty()) break;
            if (!flip_quads(inverted, false) && !repair_by_vertex(source_, grid_, matches_, fixed_, inverted)) break;
            moved = true;
        }
        return moved;
    }

    /// What rounding may turn, last and by itself: mending costs some accuracy, and it may turn nothing.
    void mend_nearly_inverted() {
        const Kept before = kept_;
        const std::size_t inverted = inverted_.faces().size();
        nearly_ = true;
        mend_inverted();
        if (kept_.rms <= kRoundingPrice * before.rms || inverted_.faces().size() < inverted) return;
        go_back_to(before);
    }

    /// Undone where it turns no face back, or makes the others pay too much for it.
    /// @return  true if fewer are left
    bool repair_by_search_of(const std::vector<std::uint32_t>& left) {
        const std::vector<Vec3d> positions = grid_.surface.positions;
        const std::vector<std::uint8_t> diagonals = chart_.diagonals;
        if (!repair_by_search(source_, inverted_.source_index(), grid_, matches_, fixed_, left)) return false;
        if (!flip_quads(inverted_now(), true)) matches_.update(false);
        if (inverted_now().size() < left.size() && matches_.rms <= kMendingPrice * kept_.rms) return true;
        grid_.surface.positions = positions, chart_.diagonals = diagonals;
        relink();
        matches_.update(false);
        return false;
    }

    /// @return  true if a sample moved
    bool repair_patches() {
        const std::vector<std::uint32_t> left = inverted_now();
        if (left.empty() ||
            !repair_by_patch(source_, inverted_.source_index(), upward_, grid_, matches_, fixed_, left, patch_effort_))
            return false;
        matches_.update(false);
        return true;
    }

    /// Fits the classes that are not where they were, and a few rings around them, while all others are held. Faces
    /// that turn again in a round have theirs held in the next.
    void refit_around(const std::vector<Vec3d>& before, bool unfolded) {
        constexpr int kRings = 4;
        const int rounds = unfolded ? 8 : options_.worst_rounds > 0 ? 6 : 2;
        const LinkedSurface& grid = grid_.surface;
        std::vector<char> near(before.size(), 0), near_face(grid.faces.size(), 0);
        for (std::size_t c = 0; c < near.size(); ++c) near[c] = grid.positions[c] != before[c];
        for (int ring = 0; ring < kRings; ++ring) {
            std::vector<char> next = near;
            for (const auto& [a, b] : grid_.edges) next[a] |= near[b], next[b] |= near[a];
            near.swap(next);
        }
        for (std::size_t f = 0; f < near_face.size(); ++f)
            for (const std::uint32_t c : grid.faces[f]) near_face[f] |= near[c];
        std::vector<Freedom> freedom(near.size(), Freedom::kHeld);
        for (std::size_t c = 0; c < near.size(); ++c)
            if (near[c] && !fixed_[c]) freedom[c] = Freedom::kFree;
        const std::vector<std::uint32_t> left = inverted_.faces(near_face, nearly_);
        std::vector<char> held(near.size(), 0);
        const double limit = (options_.worst_rounds > 0 ? kRefitLargest : kRefitLargestFree) * kept_.largest;
        double gained = 1, gained_before = 1;
        for (int round = 0; round < rounds && gained + gained_before > kRefitGain; ++round) {
            gained_before = gained;
            NormalEquations equations(grid_);
            rows_.assemble(equations, round % 2 == 1, near_face);
            sliding_.take(equations.solve(freedom, {}, kDamping, kCgIterations), {});
            matches_.update(true, near_face);
            const bool sound = take_back(
                kept_.positions,
                [&] {
                    return without(joined(inverted_.faces(near_face, nearly_), matches_.faces_beyond(limit)), left);
                },
                held);
            gained = sound ? std::max(0.0, 1 - matches_.rms / kept_.rms) : 0;
            if (gained > 0) {
                keep();
            } else {
                grid_.surface.positions = kept_.positions;
                grid_.surface.update_normals();
                matches_.update(true, near_face);
            }
            for (std::size_t c = 0; c < held.size(); ++c)
                if (held[c]) freedom[c] = Freedom::kHeld;
        }
    }

    void put_on_lattice() {
        grid_.write_positions(chart_);
        const Lattice lattice = lattice_around(chart_);
        if (!(lattice.step > 0)) return;
        NormalEquations equations(grid_);
        rows_.assemble(equations, false);
        snap_to_lattice(lattice, equations, rails_.freedom(), chart_.grid_count(), source_, grid_, matches_, inverted_);
        kept_.rms = matches_.rms, kept_.largest = largest();
        chart_.lattice = lattice;
    }

    /// The chart takes the fitted positions, and for its samples the closest points of the source.
    void finish() {
        grid_.write_positions(chart_);
        for (std::size_t s = 0; s < chart_.samples.size(); ++s) {
            const std::uint32_t c = grid_.class_of[s];
            if (c == kNone) continue;
            if (fixed_[c]) {
                if (rails_.has_moved(c)) chart_.samples[s] = rails_.sample(c);
                continue;
            }
            const SurfaceHit& hit = matches_.classes[c].hit;
            chart_.samples[s] = {hit.face, {hit.b[0], hit.b[1], hit.b[2]}};
        }
    }

    void step(bool worst_only) {
        NormalEquations equations(grid_);
        rows_.assemble(equations, worst_only);
        const std::vector<Vec3d> step = equations.solve(rails_.freedom(), rails_.directions(), kDamping, kCgIterations);
        std::vector<double> ways(rails_.empty() ? 0 : step.size());
        for (std::size_t c = 0; c < ways.size(); ++c) ways[c] = dot(step[c], rails_.directions()[c]);
        sliding_.take(step, std::move(ways));
    }

    void split_quads() {
        const std::vector<char> changed = fit_diagonals(chart_, grid_, matches_, source_);
        relink();
        matches_.update(false, changed);
    }

    bool flip_quads(std::span<const std::uint32_t> faces, bool measured) {
        if (!flip_diagonals(chart_, grid_, faces, measured ? &inverted_.source_index() : nullptr)) return false;
        relink();
        matches_.update(false);
        return true;
    }

    SampledChart& chart_;
    const FitOptions& options_;
    const model::Progress& progress_;
    LinkedSurface source_;
    WeldedGrid grid_;
    Matches matches_;
    std::vector<char> fixed_;  // per class: on the source's border
    BorderRails rails_;
    std::vector<Vec3d> upward_;  // per face of the source: its normal at the scale of the grid
    Sliding sliding_;
    InvertedFaces inverted_;
    FitRows rows_;
    std::optional<std::vector<std::uint32_t>> unmended_;  // inverted faces that mending has left
    std::size_t patch_effort_ = 500'000;                  // samples that may be moved yet: some seconds at most
    bool nearly_ = false;                                 // mends faces that rounding may turn, too
    Kept kept_;
};

}  // namespace

FitOptions l2_fit() {
    return {};
}

FitOptions best_fit() {
    FitOptions o;
    o.rounds = 10;
    o.worst_rounds = 8;
    return o;
}

FitReport fit_chart(SampledChart& chart, const FitOptions& options, const model::Progress& progress) {
    return Fitter(chart, options, progress).run();
}

}  // namespace dgm::bake
