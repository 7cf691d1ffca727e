// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component/cut_memory.cpp
#include "baking/component/cut_memory.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "geometry/chart/square_chart.h"
#include "geometry/parameterize/square_border.h"
#include "math/portable.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;

constexpr double kSimilar = 1.6;       // in samples along a side
constexpr double kSameAspect = 1.1;    // the corners fall where they fell
constexpr std::size_t kMostKnown = 4;  // cuts measured for a grid, the most similar first
constexpr std::size_t kRotations = 2;  // beside the cut's own, where the aspect is another
constexpr std::uint32_t kLongest = 257;

double ratio(double a, double b) {
    return std::max(a, b) / std::min(a, b);
}

double aspect(std::uint32_t m, std::uint32_t n) {
    return (m - 1.0) / (n - 1.0);
}

double side(std::uint32_t m, std::uint32_t n) {
    return std::sqrt(static_cast<double>(m) * n);
}

/// One way to lay a cut on the border of a grid.
struct Laying {
    std::uint32_t rotation;
    BorderShares shares;
    friend bool operator==(const Laying&, const Laying&) = default;
};

std::uint32_t scaled_rotation(const Disk& disk, BorderGrid from, std::uint32_t rotation, BorderGrid to) {
    const double share = static_cast<double>(rotation) / from.count();
    return nearest_rotation(disk, to.m, to.n, static_cast<std::uint32_t>(std::lround(share * to.count())));
}

/// How a cut that was laid on one grid may be laid on another: as it was, and otherwise where the aspect is another.
std::vector<Laying> layings(const Disk& disk, BorderGrid from, Laying as, BorderGrid to) {
    if (faces_loops(as.shares)) return {as};
    std::vector<Laying> out{{scaled_rotation(disk, from, as.rotation, to), as.shares}};
    if (ratio(aspect(from.m, from.n), aspect(to.m, to.n)) <= kSameAspect) return out;
    for (const std::uint32_t r : candidate_rotations(disk, to.m, to.n, kRotations)) {
        const Laying turned{r, as.shares};
        if (std::find(out.begin(), out.end(), turned) == out.end()) out.push_back(turned);
    }
    return out;
}

}  // namespace

CutMemory::Candidates CutMemory::similar(const CutSearchOptions& options, bool chosen) const {
    const std::uint32_t m = options.m, n = options.n;
    Candidates out;
    for (const Found& f : found_) {
        if (faces_loops(f.shares) != (options.rings > 0)) continue;
        if (ratio(side(f.m, f.n), side(m, n)) > kSimilar || f.chosen != chosen) continue;
        if (!chosen || ratio(aspect(f.m, f.n), aspect(m, n)) <= kSameAspect) out.push_back(f);
    }
    const auto distance = [&](const Found& f) {
        return math::log(ratio(side(f.m, f.n), side(m, n))) + math::log(ratio(aspect(f.m, f.n), aspect(m, n)));
    };
    std::stable_sort(out.begin(), out.end(), [&](const Found& a, const Found& b) { return distance(a) < distance(b); });
    out.resize(std::min(out.size(), chosen ? 1 : kMostKnown));
    return out;
}

Attempt<CutMemory::Cut> CutMemory::best_of(const Candidates& candidates, const TriMesh& component,
                                           const CutSearchOptions& options, const model::Progress& progress) {
    if (candidates.size() == 1 && options.rings > 0) {  // there is one way to lay it
        const Found& only = candidates.front();
        if (only.cut->shares == only.shares) return only.cut;
        CutSearchResult out = *only.cut;
        out.shares = only.shares;
        return std::make_shared<const CutSearchResult>(std::move(out));
    }
    const double shrink = std::min(1.0, (kLongest - 1.0) / (std::max(options.m, options.n) - 1.0));
    const auto shrunk = [&](std::uint32_t full) {
        return std::max(3u, 1 + static_cast<std::uint32_t>(std::lround((full - 1) * shrink)));
    };
    const BorderGrid grid{shrunk(options.m), shrunk(options.n)}, wanted{options.m, options.n};
    const auto stretch = make_stretch_parameterizer(0);
    const Topology source = measure_topology(component);
    LazyIndex index(component);
    const Found* best = nullptr;
    double best_rms = std::numeric_limits<double>::infinity();
    Laying best_laying{};
    std::optional<model::Error> failure;
    for (std::size_t k = 0; k < candidates.size(); ++k) {
        const Found& f = candidates[k];
        progress.update("cut", static_cast<double>(k) / static_cast<double>(candidates.size()));
        for (const Laying laying : layings(f.cut->disk, {f.m, f.n}, {f.rotation, f.shares}, grid)) {
            const Attempt<double> rms = attempt([&] {
                const SampledChart chart =
                    make_square_chart(f.cut->disk, grid.m, grid.n, laying.rotation, *stretch, {}, laying.shares);
                if (!holds_topology(welded_topology(chart), source))
                    throw model::Error(codes::kGridTooSmall, "the grid does not hold the topology of the cut");
                return quick_error(component, chart, options.samples, &index.get()).rms;
            });
            if (!rms) {
                if (!failure) failure = rms.error();
            } else if (*rms < best_rms) {
                best = &f;
                best_rms = *rms;
                best_laying = laying;
            }
        }
    }
    if (best == nullptr) return *failure;
    CutSearchResult out = *best->cut;
    out.rms = best_rms;
    out.shares = best_laying.shares;
    out.rotation = best_laying.rotation;
    if (grid.m != wanted.m || grid.n != wanted.n) out.rotation = scaled_rotation(out.disk, grid, out.rotation, wanted);
    found_.push_back({wanted.m, wanted.n, out.rotation, out.shares, true, best->cut});
    return std::make_shared<const CutSearchResult>(std::move(out));
}

CutMemory::Cut CutMemory::fresh(const TriMesh& component, const CutSearchOptions& options,
                                const model::Progress& progress) {
    for (const Found& f : found_)
        if (!f.chosen && f.m == options.m && f.n == options.n && faces_loops(f.shares) == (options.rings > 0))
            return f.cut;
    auto cut = std::make_shared<const CutSearchResult>(search_cut(component, options, progress));
    found_.push_back({options.m, options.n, cut->rotation, cut->shares, false, cut});
    return cut;
}

CutMemory::Cut CutMemory::search(const TriMesh& component, const CutSearchOptions& options, CutUse use,
                                 const model::Progress& progress) {
    if (use == CutUse::kSearch) return fresh(component, options, progress);
    // Those chosen before, then those found; where none of them fits this grid, it needs a cut of its own.
    if (use == CutUse::kReuse)
        for (const bool chosen : {true, false}) {
            const Candidates known = similar(options, chosen);
            if (known.empty()) continue;
            if (Attempt<Cut> best = best_of(known, component, options, progress)) return std::move(*best);
        }
    Cut own = fresh(component, options, progress);
    Candidates known = similar(options, true);
    if (use == CutUse::kBest && known.empty()) known = similar(options, false);
    std::erase_if(known, [&](const Found& f) { return !f.chosen && f.m == options.m && f.n == options.n; });
    if (use != CutUse::kBest || known.empty()) return own;
    known.push_back({options.m, options.n, own->rotation, own->shares, false, own});
    Attempt<Cut> best = best_of(known, component, options, progress);
    if (!best) throw best.error();
    return std::move(*best);
}

}  // namespace dgm::bake
