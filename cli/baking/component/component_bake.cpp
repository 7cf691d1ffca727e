// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component/component_bake.cpp
#include "baking/component/component_bake.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "baking/methods.h"
#include "geometry/cgal/border_simple.h"
#include "geometry/cgal/cgal_parameterizers.h"
#include "geometry/cgal/constrained_triangulation.h"
#include "geometry/chart/free_chart.h"
#include "geometry/chart/square_chart.h"
#include "geometry/cut_search/limb_cut.h"
#include "geometry/cut_search/ring_cut.h"
#include "geometry/mesh/infinity.h"
#include "geometry/mesh/refine.h"
#include "geometry/metrics/map_metrics.h"
#include "geometry/parameterize/convex_map.h"
#include "geometry/parameterize/flat_map.h"
#include "geometry/parameterize/free_methods.h"
#include "math/portable.h"

namespace dgm::bake {
namespace {

constexpr std::size_t kNewtonSteps = 8;
constexpr std::size_t kStars = 12;                     // octahedra tried for a sphere
constexpr std::size_t kRings = 6, kMeasuredRings = 2;  // cuts tried for a ring
constexpr double kFarRing = 1.5;                       // a ring whose cut is predicted so much more error is not mapped
// In rms, of a ring in physics and cloth: where a corner of the square lies amid a loop, its cell has two sides on one
// line, and cloth that hangs there knots.
constexpr double kPriceOfRing = 2, kFarRingOfPhysics = 3;
// The same for another cut onto the square, and the faces above which none is looked for.
constexpr double kFarOther = 1.1;
constexpr std::size_t kMostFacesCutAgain = 200'000;
// Samples: what a cut is worth on fewer is measured as well as predicted. Trials that measure map the component itself,
// so those of many faces get them on tiny grids alone.
constexpr double kSmallGrid = 1664, kTinyGrid = 800;
// dB before a fit, at 257 samples a side: below this a square chart has something folded away.
constexpr double kPoor = 75, kPerDoubling = 8.5;
// A free chart uses half of its samples: one without stretch can be better than square ones of more than these L2
// stretches, where the source has fewer or more than so many facets a face of the grid.
constexpr double kLargeFacets = 0.02, kStretchOfLarge = 1.3, kStretchOfSmall = 1.45;
constexpr std::size_t kMostFacesFreeToo = 80'000;  // more take half a minute, and longer than the rest
// Beside LSCM; above the first only where that is at most so many dB behind the square. Divided facets likewise.
constexpr std::size_t kFewFaces = 10'000, kMostFacesArapToo = 20'000;
constexpr double kFarBehind = 2.5;
constexpr double kExactPsnr = 200;  // what is left is rounding

/// Nothing can have a smaller error than the best chart so far.
bool is_exact(const Contest& contest) {
    return contest.has_best() && contest.best_psnr() > kExactPsnr;
}

double samples_of(GridSize size) {
    return static_cast<double>(size.rows) * size.cols;
}

FreeChartTools free_tools() {
    return {border_is_simple, constrained_triangulation};
}

SampledChart free_chart(const ComponentTask& task, Method method, const FreeChartTools& tools,
                        const model::Progress& progress) {
    return make_free_chart(task.component, task.size.rows, task.size.cols, *make_free_parameterizer(name_of(method)),
                           tools, progress);
}

SampledChart uv_chart(const ComponentTask& task, const model::Progress& progress) {
    return make_uv_chart(task.component, task.size.rows, task.size.cols, free_tools(), progress);
}

bool by_stretch(Method method) {
    return method == Method::kStretch || method == Method::kSphere;
}

std::unique_ptr<Parameterizer> square_parameterizer(Method method, const BakeOptions& options,
                                                    std::shared_ptr<StretchMemory> memory = nullptr) {
    if (!by_stretch(method)) return make_cgal_parameterizer(name_of(method));
    return make_stretch_parameterizer(options.ablates("newton") ? 0 : kNewtonSteps,
                                      options.ablates("curvature") ? Levelling::kArea : Levelling::kCurvature,
                                      std::move(memory));
}

LaidDisk laid_on(GridSize size, const CutSearchResult& cut) {
    return lay_disk(cut.disk, size.rows, size.cols, cut.rotation, cut.shares);
}

SampledChart square_chart(const LaidDisk& laid, Method method, const Parameterizer& parameterizer,
                          const CutSearchResult& cut, const model::Progress& progress) {
    SampledChart chart = make_square_chart(laid, parameterizer, progress);
    chart.method = name_of(method);
    chart.cut_length = cut.cut_length;
    return chart;
}

ComponentTask with_component(const ComponentTask& task, const TriMesh& component) {
    Trials trials = task.trials;
    trials.index = std::make_shared<LazyIndex>(component);
    return {component, task.size, task.most, task.use, task.rings, std::move(trials), task.is_one_of_many};
}

/// The method of `auto` for a cut onto the square.
Method method_of(const CutSearchResult& cut) {
    return cut.shares == BorderShares::kEqualArms ? Method::kSphere : Method::kStretch;
}

/// What a PSNR at 257 samples a side is at `size`.
double psnr_at(GridSize size, double at_257) {
    return at_257 + kPerDoubling * std::min(0.0, 0.5 * math::log2(samples_of(size) / (257.0 * 257.0)));
}

CutSearchOptions cut_options(const ComponentTask& task, const BakeOptions& options) {
    CutSearchOptions out;
    out.m = task.size.rows;
    out.n = task.size.cols;
    // A small grid, mostly of a small part of the asset (component_size), gets a proportionate search, which measures,
    // since cuts that its few samples cannot hold must be left out.
    const double samples = samples_of(task.size), effort = std::min(1.0, samples / (129.0 * 129.0));
    out.samples = static_cast<std::uint64_t>(200 + 7800 * effort);
    const bool many_faces = !task.is_one_of_many && task.component.faces.size() > kFewFaces;
    if (samples < (many_faces ? kTinyGrid : kSmallGrid)) {
        out.max_extremities = 8;
        out.patience = 1;
        out.rotations = 2;
        out.drops = 2;
        out.measured = true;
    }
    const Method method = options.method;
    // Trials of the search are stretch maps. Maps that crowd limbs more need limbs cut that those do without: there
    // the plain, less converged trials of the measured search are the nearer ones.
    if (row_of(method).cut == MethodCut::kSearched && method != Method::kStretch) out.measured = out.reweighted = true;
    if (options.ablates("cut-search")) {  // the first cut that can be mapped at all
        out.patience = -1;
        out.rotations = 1;
        out.drops = 0;
        out.measured = true;
    }
    if (options.ablates("hidden-cuts")) out.given_to_hide = 0;
    if (method == Method::kAuto) out.stars = kStars;
    if (row_of(method).cut == MethodCut::kStar) {
        out.measured = false;
        out.stars = kStars;
        out.only_stars = true;
    }
    return out;
}

/// The maps of one cut onto the square.
class SquareMaps {
 public:
    /// All must outlive the object.
    SquareMaps(const ComponentTask& task, const BakeOptions& options, const CutSearchResult& cut,
               const model::Progress& progress)
        : task_(task), options_(options), cut_(cut), progress_(progress), memory_(std::make_shared<StretchMemory>()) {}

    void enter(Method method, Contest& contest) const {
        contest.enter(method, [&] {
            SampledChart chart =
                square_chart(laid(), method, *square_parameterizer(method, options_, memory_), cut_, progress_);
            memory_->map = chart.uv;
            return chart;
        });
    }
    /// Levelled along the directions of curvature.
    void enter_directed(Method method, Contest& contest) const {
        contest.enter(
            method, [&] { return directed(method); }, true);
    }
    /// `auto` levels a second map along the directions of curvature, if the first one is the best so far.
    void challenge(Method method, Contest& contest) const {
        const bool levelled = !options_.ablates("newton") && !options_.ablates("curvature");
        if (options_.method != Method::kAuto || !levelled || options_.ablates("directions")) return;
        if (!contest.has_best() || contest.best_method() != method || is_exact(contest)) return;
        contest.challenge([&] { return directed(method); }, options_.fit != Fit::kSample, progress_);
    }

 private:
    [[nodiscard]] SampledChart directed(Method method) const {
        const auto parameterizer = make_stretch_parameterizer(kNewtonSteps, Levelling::kDirections, memory_);
        return square_chart(laid(), method, *parameterizer, cut_, progress_);
    }
    [[nodiscard]] const LaidDisk& laid() const {
        if (!laid_) laid_ = laid_on(task_.size, cut_);
        return *laid_;
    }

    const ComponentTask& task_;
    const BakeOptions& options_;
    const CutSearchResult& cut_;
    const model::Progress& progress_;
    std::shared_ptr<StretchMemory> memory_;
    mutable std::optional<LaidDisk> laid_;  ///< all maps share it
};

/// Unrolls a ring between opposite sides of the square, beside the charts in `contest`.
/// @param search  of the cut that those have, whose error was `rms`; infinity: they have none
void try_ring(const ComponentTask& task, const BakeOptions& options, CutSearchOptions search, double rms,
              CutMemory& cuts, Contest& contest, const model::Progress& progress) {
    if (is_exact(contest)) return;
    search.rings = search.measured ? kMeasuredRings : kRings;
    search.stars = 0;
    const Attempt<CutMemory::Cut> cut =
        attempt([&] { return cuts.search(task.component, search, task.use, progress); });
    if (!cut && task.rings == RingUse::kOnly) contest.fail(cut.error());
    const bool moves = options.metres_per_unit.has_value();
    if (!cut || (*cut)->rms > (moves ? kFarRingOfPhysics : kFarRing) * rms) return;
    Contest rings(task.component, CutKind::kRing, task.trials);
    const SquareMaps maps(task, options, **cut, progress);
    maps.enter(Method::kStretch, rings);
    maps.challenge(Method::kStretch, rings);
    if (moves && rings.has_best() && contest.has_best() && rings.best_rms() < kPriceOfRing * contest.best_rms())
        contest.yield_to(std::move(rings));
    else
        contest.meet(std::move(rings), options.fit != Fit::kSample, progress);
}

/// Cuts beside the first one of a grid that is not small, for `best`: of a component without borders, or with handles,
/// the search begins elsewhere.
std::vector<CutSearchResult> cuts_from_elsewhere(const ComponentTask& task, const CutSearchOptions& search,
                                                 const CutSearchResult& first, const model::Progress& progress) {
    if (first.shares != BorderShares::kByLength) return {};
    if (const Topology found = measure_topology(task.component); found.genus == 0 && found.boundary_loops > 0)
        return {};
    return search_other_cuts(task.component, search, kFarOther * first.rms, progress);
}

/// The cut of a small grid that is predicted to be best, beside the one of measured trials; none for disks, which need
/// no cut and may have a free chart that is exact.
std::vector<CutSearchResult> predicted_cut(const ComponentTask& task, const BakeOptions& options,
                                           const model::Progress& progress) {
    const Topology found = measure_topology(task.component);
    if (found.genus == 0 && found.boundary_loops == 1) return {};
    CutSearchOptions search;
    search.m = task.size.rows;
    search.n = task.size.cols;
    search.stars = kStars;
    if (options.ablates("hidden-cuts")) search.given_to_hide = 0;
    Attempt<CutSearchResult> cut = attempt([&] { return search_cut(task.component, search, progress); });
    std::vector<CutSearchResult> out;
    if (cut) out.push_back(*std::move(cut));
    return out;
}

/// Searches the cut again: the errors that are predicted of two good cuts, or measured on few samples, do not tell
/// which of them is better after the fit, trial fits do. The maps are levelled as the one of the first cut that won.
void try_other_cuts(const ComponentTask& task, const BakeOptions& options, const CutSearchOptions& search,
                    const CutSearchResult& first, Contest& contest, const model::Progress& progress) {
    if (options.method != Method::kAuto || options.ablates("other-cuts") || options.ablates("cut-search")) return;
    if (search.measured ? task.is_one_of_many : options.fit != Fit::kBest) return;
    if (task.use != CutUse::kSearch || !contest.has_best() || is_exact(contest)) return;
    if (contest.best_method() != Method::kStretch || task.component.faces.size() > kMostFacesCutAgain) return;
    const std::vector<CutSearchResult> cuts =
        search.measured ? predicted_cut(task, options, progress) : cuts_from_elsewhere(task, search, first, progress);
    for (const CutSearchResult& cut : cuts) {
        if (cut.rms == first.rms && cut.cut_length == first.cut_length) continue;
        Contest others(task.component, CutKind::kOther, task.trials);
        const SquareMaps maps(task, options, cut, progress);
        const Method method = method_of(cut);
        contest.best_is_directed() ? maps.enter_directed(method, others) : maps.enter(method, others);
        contest.meet(std::move(others), options.fit != Fit::kSample, progress);
    }
}

double stretch_of_best(const Contest& contest) {
    const SampledChart& best = contest.best_chart();
    return l2_stretch(best.disk->mesh.positions, best.disk->mesh.faces, best.uv);
}

/// Where limbs are crowded in the map of the first cut, `auto` tries one that runs to all of their tips: the search,
/// which goes on while each limb pays for itself, ends long before that.
void try_limbs(const ComponentTask& task, const BakeOptions& options, const CutSearchResult& first, Contest& contest,
               const model::Progress& progress) {
    if (!contest.has_best() || is_exact(contest) || contest.best_chart().domain != layout::Domain::kSquare) return;
    constexpr double kCrowded = 3;
    if (!(stretch_of_best(contest) > kCrowded)) return;
    const Attempt<std::optional<CutSearchResult>> cut =
        attempt([&] { return open_limbs(task.component, task.size.rows, task.size.cols, progress); });
    if (!cut || !*cut || (*cut)->cut_length == first.cut_length) return;
    Contest limbs(task.component, CutKind::kLimbs, task.trials);
    const SquareMaps maps(task, options, **cut, progress);
    maps.enter(Method::kStretch, limbs);
    maps.challenge(Method::kStretch, limbs);
    contest.meet(std::move(limbs), options.fit != Fit::kSample, progress);
}

/// Where they are crowded on the square still, they are unfolded beside each other: a slit limb is nearly flat. Of 80
/// spikes on a ball, 257 x 257 samples show 79 dB so, and 59 on the square.
/// @return  true if that is the best chart
bool try_unfolded_limbs(const ComponentTask& task, const BakeOptions& options, Contest& contest,
                        const model::Progress& progress) {
    constexpr double kSamplesToLimb = 8, kCrowded = 2;
    if (!(stretch_of_best(contest) > kCrowded)) return false;
    const auto most = static_cast<std::size_t>(samples_of(task.size) / kSamplesToLimb);
    const Attempt<std::optional<CutGraph>> cut = attempt([&] { return limb_cut(task.component, most, progress); });
    if (!cut || !*cut) return false;
    Contest limbs(task.component, CutKind::kLimbs, task.trials);
    for (const Method method : {Method::kLscm, Method::kArap})
        limbs.enter(method, [&] {
            return make_free_chart((*cut)->open(), task.size.rows, task.size.cols,
                                   *make_free_parameterizer(name_of(method)), free_tools(), progress);
        });
    return contest.meet(std::move(limbs), options.fit != Fit::kSample, progress);
}

/// Charts that stretch less beside the square's. What a fit makes of either cannot be told from the errors before it:
/// where samples are many beside facets, a surface that is laid out nearly flat is fitted almost exactly (a bag with
/// handles, 76 dB on either before, reached 89 on the square and 107 on a free chart), and where they are few, the
/// samples that a free chart leaves unused are lost.
void try_free(const ComponentTask& task, const BakeOptions& options, Contest& contest,
              const model::Progress& progress) {
    const bool fitted = options.fit != Fit::kSample;
    if (fitted) {
        const double facets = static_cast<double>(task.component.faces.size()) / (2 * samples_of(task.size));
        const double least = facets < kLargeFacets ? kStretchOfLarge : kStretchOfSmall;
        if (!(stretch_of_best(contest) > least)) return;
    } else if (!(contest.best_psnr() < psnr_at(task.size, kPoor))) {
        return;
    }
    Contest frees(task.component, CutKind::kFree, task.trials);
    const auto enter = [&](Method method) {
        frees.enter(method, [&] { return free_chart(task, method, free_tools(), progress); });
    };
    enter(Method::kLscm);
    const bool is_near = frees.has_best() && frees.best_psnr() > contest.best_psnr() - kFarBehind;
    const std::size_t faces = task.component.faces.size();
    if (faces <= kFewFaces || (is_near && faces <= kMostFacesArapToo)) enter(Method::kArap);
    contest.meet(std::move(frees), fitted, progress);
}

/// The square of `auto` and of the methods that name it, and the free charts that `auto` tries beside it.
void try_square(const ComponentTask& task, const BakeOptions& options, CutMemory& cuts, Contest& contest,
                const model::Progress& progress) {
    const bool any = options.method == Method::kAuto, may_be_free = any && options.domain != DomainChoice::kSquare;
    // Texture coordinates that lay the surface out well cost next to nothing, and the error they reach limits how far
    // the search for a cut goes.
    if (may_be_free && !options.stays_on_square() && !task.component.corner_uvs.empty())
        contest.enter(Method::kUv, [&] { return uv_chart(task, progress); });
    const auto arap = [&] {
        contest.enter(Method::kArap, [&] { return free_chart(task, Method::kArap, free_tools(), progress); });
    };
    // A flat panel full of needles has a chart without error, and none that stretches it costs less than minutes.
    if (may_be_free && flat_needle_map(task.component.positions, task.component.faces)) {
        arap();
        if (is_exact(contest)) return;
    }
    CutSearchOptions search = cut_options(task, options);
    if (task.rings == RingUse::kOnly) return try_ring(task, options, search, kInfinity, cuts, contest, progress);
    search.only_simplified = contest.has_best() && contest.best_psnr() > psnr_at(task.size, kPoor);
    const Attempt<CutMemory::Cut> found =
        attempt([&] { return cuts.search(task.component, search, task.use, progress); });
    if (!found) contest.fail(found.error());
    const CutSearchResult* const cut = found ? found->get() : nullptr;
    if (cut != nullptr) {
        const Method method = any ? method_of(*cut) : options.method;
        const SquareMaps maps(task, options, *cut, progress);
        maps.enter(method, contest);
        maps.challenge(method, contest);
        try_other_cuts(task, options, search, *cut, contest, progress);
        if (any) try_limbs(task, options, *cut, contest, progress);
    }
    const bool may_unroll = task.rings == RingUse::kTried && (any || options.method == Method::kStretch);
    if (may_unroll && is_ring(task.component))
        try_ring(task, options, search, cut ? cut->rms : kInfinity, cuts, contest, progress);
    if (!any || is_exact(contest)) return;
    // A free chart earns its unused samples only where the surface is a panel, a disk that needs no cut: flat pieces of
    // cloth above all.
    const bool panel = cut ? cut->cut_length == 0 : !contest.has_best();
    if (may_be_free && panel && !contest.tried(Method::kArap) && !(contest.has_best() && options.stays_on_square()))
        arap();
    // A star that served the simplified component need not serve the component itself.
    if (contest.failed(Method::kSphere))
        contest.enter(Method::kStretch, [&] {
            search.stars = 0;
            const CutSearchResult other = search_cut(task.component, search, progress);
            return square_chart(laid_on(task.size, other), Method::kStretch,
                                *square_parameterizer(Method::kStretch, options), other, progress);
        });
    if (!may_be_free || contest.tried(Method::kArap)) return;
    if (!contest.has_best()) return arap();
    if (task.component.faces.size() > kMostFacesFreeToo || options.ablates("free-charts")) return;
    if (options.stays_on_square() || try_unfolded_limbs(task, options, contest, progress)) return;
    try_free(task, options, contest, progress);
}

/// A map that is linear on each facet cannot spread samples where facets are large or thin. Beside the chart in
/// `contest`, some of the same surface with its facets divided: 12 dB for a comb of 332 triangles as modellers cut
/// them and for an icosahedron. Where each facet lies well on the grid as it is, they have the higher error.
void try_refined(const ComponentTask& task, const BakeOptions& options, Contest& contest,
                 const model::Progress& progress) {
    constexpr std::size_t kRefinedFaces = 7000;  // so many are searched without simplifying them
    if (options.method != Method::kAuto || options.fit == Fit::kSample || options.ablates("refinement")) return;
    if (task.use != CutUse::kSearch || task.rings == RingUse::kOnly || task.is_one_of_many) return;
    if (task.component.faces.size() > kFewFacets || !task.component.points.empty()) return;
    if (options.stays_on_square()) return;  // physics may have taken a ring, whatever its error
    const CutSearchOptions search = cut_options(task, options);
    if (search.measured || !contest.has_best() || is_exact(contest)) return;
    const TriMesh refined = refine(task.component, kRefinedFaces);
    Contest divided(task.component, CutKind::kRefined, task.trials);
    if (const Attempt<CutSearchResult> cut = attempt([&] { return search_cut(refined, search, progress); })) {
        const SquareMaps maps(task, options, *cut, progress);
        const Method method = method_of(*cut);
        maps.enter(method, divided);
        maps.challenge(method, divided);
    }
    const ComponentTask of_refined = with_component(task, refined);
    // Free charts take longest. Where those of whole facets are far behind, so are these.
    const bool may_be_free = options.domain != DomainChoice::kSquare && !options.ablates("free-charts") &&
                             contest.best_psnr_of_free().value_or(kInfinity) > contest.best_psnr() - kFarBehind;
    if (divided.has_best() && may_be_free && !try_unfolded_limbs(of_refined, options, divided, progress))
        try_free(of_refined, options, divided, progress);
    contest.meet(std::move(divided), true, progress);
}

Attempt<ComponentResult> bake_on_grid(const ComponentTask& task, const BakeOptions& options, CutMemory& cuts,
                                      const model::Progress& progress) {
    Contest contest(task.component, CutKind::kFirst, task.trials);
    const auto free = [&](Method method) {
        contest.enter(method, [&] { return free_chart(task, method, free_tools(), progress); });
    };
    const auto uv = [&] { contest.enter(Method::kUv, [&] { return uv_chart(task, progress); }); };
    if (row_of(options.method).cut == MethodCut::kUvSeams) {
        uv();
    } else if (is_free(options.method)) {
        free(options.method);
    } else if (options.method == Method::kAuto && options.domain == DomainChoice::kFree) {
        for (const Method method : {Method::kArap, Method::kSlim, Method::kLscm}) free(method);
        if (!task.component.corner_uvs.empty()) uv();
    } else {
        try_square(task, options, cuts, contest, progress);
        try_refined(task, options, contest, progress);
    }
    return std::move(contest).result();
}

}  // namespace

Attempt<ComponentResult> bake_component(const ComponentTask& task, const BakeOptions& options, CutMemory& cuts,
                                        const model::Progress& progress) {
    ComponentTask grown = task;
    if (!grown.trials.index) grown.trials.index = std::make_shared<LazyIndex>(task.component);
    for (;;) {
        Attempt<ComponentResult> result = bake_on_grid(grown, options, cuts, progress);
        if (result || result.failure() != Failure::kGridTooSmall || grown.size == task.most) return result;
        grown.size.rows = std::min(task.most.rows, 2 * grown.size.rows - 1);
        grown.size.cols = std::min(task.most.cols, 2 * grown.size.cols - 1);
    }
}

}  // namespace dgm::bake
