// SPDX-License-Identifier: GPL-3.0-or-later
// cli/pipeline/cut_memory.cpp
#include "pipeline/cut_memory.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "geometry/chart/square_chart.h"
#include "geometry/parameterize/square_border.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;

constexpr double kSimilar = 1.6;       // in samples along a side
constexpr double kSameAspect = 1.1;    // the corners fall where they fell
constexpr std::size_t kMostKnown = 4;  // cuts measured for a grid, the most similar first
constexpr std::size_t kRotations = 4;
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

std::uint32_t scaled_rotation(const Disk& disk, BorderGrid from, std::uint32_t rotation, BorderGrid to) {
    const double share = static_cast<double>(rotation) / from.count();
    return nearest_rotation(disk, to.m, to.n, static_cast<std::uint32_t>(std::lround(share * to.count())));
}

}  // namespace

std::vector<const CutMemory::Found*> CutMemory::similar(std::uint32_t m, std::uint32_t n) const {
    std::vector<const Found*> out;
    for (const Found& f : found_)
        if (ratio(side(f.m, f.n), side(m, n)) <= kSimilar) out.push_back(&f);
    const auto distance = [&](const Found* f) {
        return std::log(ratio(side(f->m, f->n), side(m, n))) + std::log(ratio(aspect(f->m, f->n), aspect(m, n)));
    };
    std::stable_sort(out.begin(), out.end(), [&](const Found* a, const Found* b) { return distance(a) < distance(b); });
    if (out.size() > kMostKnown) out.resize(kMostKnown);
    return out;
}

CutSearchResult CutMemory::best_of(const std::vector<const Found*>& candidates, const TriMesh& component,
                                   const CutSearchOptions& options, const model::Progress& progress) {
    const double shrink = std::min(1.0, (kLongest - 1.0) / (std::max(options.m, options.n) - 1.0));
    const auto shrunk = [&](std::uint32_t full) {
        return std::max(3u, 1 + static_cast<std::uint32_t>(std::lround((full - 1) * shrink)));
    };
    const BorderGrid grid{shrunk(options.m), shrunk(options.n)}, wanted{options.m, options.n};
    const auto stretch = make_stretch_parameterizer(0);
    const Topology source = measure_topology(component.positions.size(), component.faces);
    const Found* best = nullptr;
    double best_rms = std::numeric_limits<double>::infinity();
    std::uint32_t best_rotation = 0;
    std::optional<model::Error> failure;
    for (std::size_t k = 0; k < candidates.size(); ++k) {
        const Found& f = *candidates[k];
        progress.update("cut", static_cast<double>(k) / static_cast<double>(candidates.size()));
        std::vector<std::uint32_t> rotations{scaled_rotation(f.cut.disk, {f.m, f.n}, f.cut.rotation, grid)};
        if (ratio(aspect(f.m, f.n), aspect(wanted.m, wanted.n)) > kSameAspect)
            for (const std::uint32_t r : candidate_rotations(f.cut.disk, grid.m, grid.n, kRotations))
                if (std::find(rotations.begin(), rotations.end(), r) == rotations.end()) rotations.push_back(r);
        for (const std::uint32_t rotation : rotations) {
            try {
                const SampledChart chart = make_square_chart(f.cut.disk, grid.m, grid.n, rotation, *stretch, {});
                if (!holds_topology(welded_topology(chart), source))
                    throw model::Error(codes::kGridTooSmall, "the grid does not hold the topology of the cut");
                const double rms = quick_error(component, chart, options.samples).rms;
                if (rms < best_rms) best = &f, best_rms = rms, best_rotation = rotation;
            } catch (const model::Error& e) {
                if (e.code().number == codes::kInterrupted.number) throw;
                if (!failure) failure = e;
            }
        }
    }
    if (best == nullptr) throw *failure;
    CutSearchResult out = best->cut;
    out.rms = best_rms;
    out.rotation = grid.m == wanted.m && grid.n == wanted.n ? best_rotation
                                                            : scaled_rotation(out.disk, grid, best_rotation, wanted);
    return out;
}

CutSearchResult CutMemory::search(const TriMesh& component, const CutSearchOptions& options,
                                  const model::Progress& progress) {
    const auto known = std::find_if(found_.begin(), found_.end(),
                                    [&](const Found& f) { return f.m == options.m && f.n == options.n; });
    std::vector<const Found*> pool = similar(options.m, options.n);
    if (use != CutUse::kReuse || pool.empty()) {
        CutSearchResult fresh = known != found_.end() ? known->cut : search_cut(component, options, progress);
        if (known == found_.end()) {
            found_.push_back({options.m, options.n, fresh});
            pool = similar(options.m, options.n);  // its entries may have moved
        }
        if (use != CutUse::kBest || pool.size() < 2) return fresh;
    }
    try {
        return best_of(pool, component, options, progress);
    } catch (const model::Error& e) {
        // None of them fits this grid: it needs a cut of its own.
        if (e.code().number == codes::kInterrupted.number || known != found_.end()) throw;
    }
    found_.push_back({options.m, options.n, search_cut(component, options, progress)});
    return found_.back().cut;
}

}  // namespace dgm::bake
