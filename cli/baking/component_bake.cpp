// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component_bake.cpp
#include "baking/component_bake.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "baking/cpu_clock.h"
#include "geometry/cgal/border_simple.h"
#include "geometry/cgal/cgal_parameterizers.h"
#include "geometry/cgal/constrained_triangulation.h"
#include "geometry/chart/free_chart.h"
#include "geometry/chart/square_chart.h"
#include "geometry/metrics/map_metrics.h"
#include "geometry/parameterize/free_methods.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

using model::Error;
namespace codes = model::codes;

constexpr std::size_t kNewtonSteps = 8;
constexpr std::size_t kStars = 12;  // octahedra tried for a sphere
constexpr double kGain = 0.99;      // a later candidate must be 1 % better, and the earlier not exact but for rounding
constexpr double kExact = 1e-10;    // normalised units
// dB at 257 samples a side: below this a square chart has something folded away, and a free one is tried as well.
constexpr double kPoor = 75, kPerDoubling = 8.5, kHandles = 10;
// A free chart beside a square one must not take longer than all the rest: it gets few cuts.
constexpr int kSecondRounds = 2;

bool is_free_method(const std::string& method) {
    return method == "lscm" || method == "arap" || method == "slim" || method == "uv";
}

/// What every candidate of one component shares.
class ComponentBaker {
 public:
    ComponentBaker(const TriMesh& component, GridSize size, const BakeOptions& options, CutMemory& cuts,
                   const model::Progress& progress)
        : component_(component), size_(size), options_(options), cuts_(cuts), progress_(progress) {}

    ComponentResult run() {
        if (options_.method == "uv") {
            add_uv();
            return finish();
        }
        if (is_free_method(options_.method) || (options_.method == "auto" && options_.domain == DomainChoice::kFree)) {
            for (const std::string& method : methods()) add(method, [&] { return make(method); });
            if (options_.method == "auto" && !component_.corner_uvs.empty()) add_uv();
            return finish();
        }
        // Texture coordinates that lay the surface out well cost next to nothing, and what they reach tells how far the
        // search for a cut may go.
        if (options_.method == "auto" && may_be_free() && !component_.corner_uvs.empty()) add_uv();
        search_.m = size_.rows, search_.n = size_.cols;
        search_.only_simplified = best_ && best_psnr() > poor();
        // A small grid is a small part of the asset (component_size): it gets a proportionate search, which measures,
        // since cuts that its few samples cannot hold must be left out.
        const double effort = std::min(1.0, static_cast<double>(size_.rows) * size_.cols / (129.0 * 129.0));
        search_.samples = static_cast<std::uint64_t>(200 + 7800 * effort);
        if (effort < 0.1) {
            search_.max_extremities = 8, search_.patience = 1, search_.rotations = 2, search_.drops = 2;
            search_.measured = true;
        }
        // Trials of the search are stretch maps. Maps that crowd limbs more need limbs cut that those do without: there
        // the plain, less converged trials of the measured search are the nearer ones.
        if (options_.method == "mvc" || options_.method == "authalic" || options_.method == "conformal" ||
            options_.method == "tutte")
            search_.measured = search_.reweighted = true;
        if (options_.ablates("cut-search"))  // the first cut that can be mapped at all
            search_.patience = -1, search_.rotations = 1, search_.drops = 0, search_.measured = true;
        if (options_.ablates("hidden-cuts")) search_.given_to_hide = 0;
        if (options_.method == "auto") search_.stars = kStars;
        if (options_.method == "sphere") search_.measured = false, search_.stars = kStars, search_.only_stars = true;
        try {
            cut_ = cuts_.search(component_, search_, progress_);
        } catch (const Error& e) {
            if (e.code().number == codes::kInterrupted.number || !may_be_free()) throw;
            failure_ = e, no_square_ = true;  // a free chart may still do
        }
        for (const std::string& method : methods()) add(method, [&] { return make(method); });
        if (options_.method == "auto" && failed("sphere")) add("stretch", [&] { return make_without_star(); });
        if (options_.method == "auto" && may_be_free() && !tried("arap") && (!best_ || free_may_help())) {
            if (best_) cut_rounds_ = kSecondRounds;
            add("arap", [&] { return make("arap"); });
        }
        return finish();
    }

 private:
    [[nodiscard]] std::vector<std::string> methods() const {
        if (options_.method != "auto") return {options_.method};
        const bool square = options_.domain != DomainChoice::kFree, free = options_.domain != DomainChoice::kSquare;
        std::vector<std::string> out;
        if (square && !no_square_) out.push_back(cut_.shares == BorderShares::kEqualArms ? "sphere" : "stretch");
        // A free chart earns its unused samples only where the surface is a panel: flat pieces of cloth above all.
        if (free && (!square || is_panel()) && !(no_square_ && best_)) out.push_back("arap");
        if (free && !square) out.insert(out.end(), {"slim", "lscm"});
        return out;
    }

    [[nodiscard]] double poor() const {
        const double samples = static_cast<double>(size_.rows) * size_.cols;
        return kPoor + kPerDoubling * std::min(0.0, 0.5 * std::log2(samples / (257.0 * 257.0)));
    }

    /// Loops about handles make a free chart ragged: of 6 and 11 handles it lost 2 to 3 dB to the square, of 81 it won
    /// 14 where the square had come to 51.
    [[nodiscard]] bool free_may_help() const {
        const bool handles = measure_topology(component_.positions.size(), component_.faces).genus > 0;
        return best_psnr() < poor() - (handles ? kHandles : 0);
    }

    [[nodiscard]] double best_psnr() const { return result_.candidates[best_index_].psnr; }

    /// A disk as it stands, not cut by us.
    [[nodiscard]] bool is_panel() const { return cut_.cut_length == 0; }

    [[nodiscard]] bool may_be_free() const {
        return options_.method == "auto" ? options_.domain != DomainChoice::kSquare : is_free_method(options_.method);
    }

    void add_uv() {
        add("uv", [&] { return make_uv_chart(component_, size_.rows, size_.cols, tools(), progress_); });
    }

    /// Of charts as good as each other, but for a percent or for rounding, the one that uses all samples wins; then the
    /// earlier one.
    [[nodiscard]] bool wins(const SampledChart& chart, double rms) const {
        if (chart.domain == layout::Domain::kSquare && best_->domain == layout::Domain::kFree)
            return kGain * rms < best_rms_ || rms <= kExact;
        return rms < kGain * best_rms_ && best_rms_ > kExact;
    }

    [[nodiscard]] bool tried(std::string_view method) const {
        for (const CandidateReport& c : result_.candidates)
            if (c.method == method) return true;
        return false;
    }

    [[nodiscard]] bool failed(std::string_view method) const {
        for (const CandidateReport& c : result_.candidates)
            if (c.method == method) return c.psnr == 0;  // never measured
        return false;
    }

    SampledChart make(const std::string& method) {
        if (is_free_method(method))
            return make_free_chart(component_, size_.rows, size_.cols, *make_free_parameterizer(method), tools(),
                                   progress_);
        const std::unique_ptr<Parameterizer> parameterizer =
            method == "stretch" || method == "sphere"
                ? make_stretch_parameterizer(options_.ablates("newton") ? 0 : kNewtonSteps,
                                             !options_.ablates("curvature"))
                : make_cgal_parameterizer(method);
        if (!parameterizer) throw Error(codes::kUsage, "unknown method: " + method);
        SampledChart chart =
            make_square_chart(cut_.disk, size_.rows, size_.cols, cut_.rotation, *parameterizer, progress_, cut_.shares);
        chart.method = method;
        return chart;
    }

    /// A star that served the simplified component need not serve the component itself.
    SampledChart make_without_star() {
        search_.stars = 0;
        cut_ = search_cut(component_, search_, progress_);
        return make("stretch");
    }

    [[nodiscard]] FreeChartTools tools() const { return {border_is_simple, constrained_triangulation, cut_rounds_}; }

    template <class Make>
    void add(const std::string& method, Make make_chart) {
        CandidateReport report{method, 0, "", 0};
        const CpuClock clock;
        try {
            SampledChart chart = make_chart();
            if (!is_free_method(method)) chart.cut_length = cut_.cut_length;
            check_topology(chart);
            const SurfaceError error = quick_error(component_, chart, 20'000);
            report.psnr = error.psnr();
            report.outcome = "higher error";
            if (!best_ || wins(chart, error.rms)) {
                best_ = std::move(chart), best_rms_ = error.rms, best_index_ = result_.candidates.size();
            }
        } catch (const Error& e) {
            if (e.code().number == codes::kInterrupted.number) throw;
            report.outcome = e.what();
            failure_ = e;
        }
        report.cpu_seconds = clock.seconds();
        result_.candidates.push_back(std::move(report));
    }

    /// The welded grid surface must be the manifold that the component is.
    void check_topology(const SampledChart& chart) const {
        const Topology map = welded_topology(chart);
        const Topology source = measure_topology(component_.positions.size(), component_.faces);
        if (holds_topology(map, source)) return;
        throw Error(codes::kGridTooSmall,
                    chart.method + ": a grid of " + std::to_string(chart.m) + "x" + std::to_string(chart.n) +
                        " does not hold the surface's topology (genus " + std::to_string(source.genus) + ", " +
                        std::to_string(source.boundary_loops) + " borders; the grid has genus " +
                        std::to_string(map.genus) + ", " + std::to_string(map.boundary_loops) + " borders, " +
                        std::to_string(map.degenerate_faces) + " degenerate faces" +
                        (map.manifold ? "" : ", not manifold") + ")");
    }

    ComponentResult finish() {
        if (!best_) throw *failure_;
        result_.candidates[best_index_].outcome = best_->note.empty() ? "chosen" : "chosen; " + best_->note;
        result_.chart = std::move(*best_);
        return std::move(result_);
    }

    const TriMesh& component_;
    GridSize size_;
    const BakeOptions& options_;
    CutMemory& cuts_;
    const model::Progress& progress_;
    CutSearchResult cut_;
    CutSearchOptions search_;
    ComponentResult result_;
    int cut_rounds_ = FreeChartTools{}.cut_rounds;
    std::optional<SampledChart> best_;
    std::optional<Error> failure_;
    bool no_square_ = false;  // no cut could be mapped to one
    std::size_t best_index_ = 0;
    double best_rms_ = 0;
};

}  // namespace

GridSize component_size(GridSize full, double area, double largest_area) {
    constexpr std::uint32_t kLeast = 17;
    const double share = largest_area > 0 ? std::sqrt(area / largest_area) : 1.0;
    const auto side = [&](std::uint32_t samples) {
        const auto scaled = 1 + static_cast<std::uint32_t>(std::lround((samples - 1) * share));
        return std::clamp(scaled, std::min(kLeast, samples), samples);
    };
    return {side(full.rows), side(full.cols)};
}

std::vector<GridSize> component_sizes(std::span<const GridSize> full, std::span<const double> areas,
                                      std::size_t largest) {
    constexpr std::uint64_t kMost = 10;  // times the samples of the largest
    constexpr int kHalvings = 24;
    std::vector<GridSize> out(areas.size());
    const auto samples_at = [&](double share) {  // of the area of all but the largest
        std::uint64_t sum = 0;
        for (std::size_t c = 0; c < areas.size(); ++c) {
            out[c] = component_size(full[c], c == largest ? areas[c] : share * areas[c], areas[largest]);
            sum += std::uint64_t{out[c].rows} * out[c].cols;
        }
        return sum;
    };
    const std::uint64_t most = kMost * full[largest].rows * full[largest].cols;
    if (samples_at(1) <= most) return out;
    double low = 0, high = 1;
    for (int k = 0; k < kHalvings; ++k) {
        const double middle = 0.5 * (low + high);
        (samples_at(middle) <= most ? low : high) = middle;
    }
    samples_at(low);
    return out;
}

ComponentResult bake_component(const TriMesh& component, GridSize size, GridSize most, const BakeOptions& options,
                               CutMemory& cuts, const model::Progress& progress) {
    while (true) {
        try {
            return ComponentBaker(component, size, options, cuts, progress).run();
        } catch (const Error& e) {
            if (e.code().number != codes::kGridTooSmall.number || size == most) throw;
        }
        size.rows = std::min(most.rows, 2 * size.rows - 1);
        size.cols = std::min(most.cols, 2 * size.cols - 1);
    }
}

}  // namespace dgm::bake
