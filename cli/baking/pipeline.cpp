// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/pipeline.cpp
#include "baking/pipeline.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>

#include "baking/component_bake.h"
#include "baking/component_loop.h"
#include "baking/component_shapes.h"
#include "baking/component_sizes.h"
#include "baking/cpu_clock.h"
#include "baking/grid_search.h"
#include "baking/measure_chart.h"
#include "baking/notices.h"
#include "baking/size_search.h"
#include "baking/up_to_date.h"
#include "dgm/dgm_writer.h"
#include "dgm/hash.h"
#include "geometry/fit/closest_samples.h"
#include "geometry/fit/fit.h"
#include "geometry/layers/layers.h"
#include "geometry/repair/repair.h"
#include "mesh/mesh_reader.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

using model::Error;
namespace codes = model::codes;

constexpr std::uint64_t kMaxSamples = std::uint64_t{1} << 26;  // of all charts together: 3 GB of layers

/// Appends `part` to `whole`: what errors of a whole asset are measured on.
void append(TriMesh& whole, const TriMesh& part) {
    const auto base = static_cast<std::uint32_t>(whole.positions.size());
    whole.positions.insert(whole.positions.end(), part.positions.begin(), part.positions.end());
    for (const Face& f : part.faces) whole.faces.push_back({f[0] + base, f[1] + base, f[2] + base});
}

/// One rising share from steps whose number nobody knows beforehand (start, descent, other candidates), each of which
/// counts from 0 to 1: each gets half of what is left.
class OpenSteps {
 public:
    double operator()(double share) {
        if (share < last_) left_ /= 2;
        last_ = share;
        return 1 - left_ + left_ / 2 * share;
    }

 private:
    double last_ = 0, left_ = 1;
};

class AssetBake {
 public:
    AssetBake(const std::filesystem::path& source, const BakeOptions& options, const model::Progress& progress)
        : source_(source), options_(options), progress_(progress) {}

    BakeResult run() {
        stage("import", [&] { import(); });
        stage("repair", [&] {
            repaired_ = repair(imported_.mesh);
            for (TriMesh& component : repaired_.components) complete_normals(component);
        });
        stage("textures", [&] { load_images(); });
        describe();
        u16_ = choose_u16();
        GridSize largest = options_.size;
        if (options_.auto_samples) stage("shape", [&] { largest = choose_shapes(); });
        if (options_.max_error || options_.budget_bytes) {
            use_cuts(CutUse::kReuse);
            search_grid(largest);
        } else {
            if (options_.auto_samples) use_cuts(CutUse::kBest);
            map_and_fit(largest, true);
            finish();
        }
        return std::move(result_);
    }

 private:
    template <class Body>
    void stage(const char* name, Body body) {
        const std::string shown = trial_ + name;
        progress_.update(shown, 0);
        const auto start = std::chrono::steady_clock::now();
        const CpuClock clock;
        try {
            body();
        } catch (Error& e) {
            e.with_stage(shown);
            throw;
        }
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        std::vector<StageTime>& times = result_.report.times;
        if (times.empty() || times.back().stage != shown) times.push_back({shown, 0, 0});
        times.back().seconds += seconds.count();
        times.back().cpu_seconds += clock.seconds();
    }

    /// Shares of `count` equal parts, as shares of the whole stage.
    [[nodiscard]] model::Progress part(std::string stage, std::size_t k, std::size_t count) const {
        model::Progress out;
        out.cancelled = progress_.cancelled;
        out.on_update = [this, stage = std::move(stage), k, count, steps = OpenSteps()](std::string_view inner,
                                                                                        double share) mutable {
            // The search for the cut is the long part of mapping, and goes by its own name.
            const bool cut = inner == "cut", counted = cut || stage != "map";
            progress_.update(trial_ + (cut ? "cut" : stage),
                             (static_cast<double>(k) + (counted ? share : steps(share))) / static_cast<double>(count));
        };
        return out;
    }

    /// --size auto:N. @return the grid of the largest component
    GridSize choose_shapes() {
        const std::uint64_t samples = *options_.auto_samples;
        GridSearch& search = result_.report.search.emplace();
        search.goal = "samples";
        search.asked_samples = samples;
        shapes_ = choose_component_shapes(repaired_.components, areas_, samples, options_, cuts_, part("shape", 0, 1));
        search.shapes = shapes_.trials;
        for (GridTrial& trial : search.shapes) trial.rms *= repaired_.frame.diagonal;
        const GridSize out = grid_of(samples, shapes_.aspects[largest_]);
        search.rows = out.rows, search.cols = out.cols;
        return out;
    }

    /// --max-error, --budget: bakes grids up to `most` until the asked one is found.
    void search_grid(GridSize most) {
        const std::vector<GridTrial> shapes =
            result_.report.search ? result_.report.search->shapes : std::vector<GridTrial>{};
        const double diagonal = repaired_.frame.diagonal;
        std::vector<ComponentResult> kept;
        GridTries tries;
        tries.keep = [&](GridSize) {
            if (options_.max_error) kept = mapped_;
        };
        const auto trial = [&](GridSize size, const auto& body) {
            const CpuClock clock;
            trial_ = std::to_string(size.rows) + "x" + std::to_string(size.cols) + ": ";
            const Attempt<GridTrial> out = attempt([&] {
                GridTrial measured{size.rows, size.cols, std::nan(""), std::nan(""), 0, "", 0};
                body(measured);
                measured.cpu_seconds = clock.seconds();
                return measured;
            });
            trial_.clear();
            return out;
        };
        const std::vector<GridSize> ladder = grid_ladder(most, options_.max_error.has_value());
        if (options_.max_error) {
            tries.measure = [&](GridSize size) {
                return trial(size, [&](GridTrial& out) {
                    map_and_fit(size, true);
                    make_and_measure(kGeometryOnly, kErrorSamples);
                    out.rms = result_.report.error.rms, out.hausdorff = result_.report.error.hausdorff;
                });
            };
            result_.report.search = in_search(
                [&] { return search_by_error(*options_.max_error, diagonal, ladder, first_side(shapes), tries); });
        } else {
            tries.measure = [&](GridSize size) {
                return trial(size, [&](GridTrial& out) {
                    map_and_fit(size, false);
                    make_and_measure(options_.layers, kFewSamples);
                    out.bytes = file_bytes();
                });
            };
            result_.report.search = in_search([&] { return search_by_budget(*options_.budget_bytes, ladder, tries); });
        }
        GridSearch& search = *result_.report.search;
        search.shapes = shapes;
        if (options_.max_error) {
            mapped_ = std::move(kept);
        } else {
            use_cuts(CutUse::kBest);
            map_and_fit({search.rows, search.cols}, true);
        }
        finish();
        if (options_.budget_bytes) hold_budget(ladder);
    }

    template <class Body>
    static GridSearch in_search(Body body) {
        try {
            return body();
        } catch (Error& e) {
            e.with_stage("search");
            throw;
        }
    }

    /// What the shapes' cheap bakes say about the side that a search by rms should begin with.
    [[nodiscard]] double first_side(const std::vector<GridTrial>& shapes) const {
        constexpr double kDefault = 65, kFarthest = 4;
        const ErrorGoal& goal = *options_.max_error;
        if (shapes.empty() || areas_.size() > 1 || goal.kind != ErrorKind::kRms) return kDefault;
        const double asked = goal.percent ? goal.value / 100 * repaired_.frame.diagonal : goal.value;
        const auto best = std::min_element(shapes.begin(), shapes.end(),
                                           [](const GridTrial& a, const GridTrial& b) { return a.rms < b.rms; });
        const double side = std::sqrt(static_cast<double>(best->rows) * best->cols);
        return side * std::clamp(std::sqrt(best->rms / asked), 1 / kFarthest, kFarthest);
    }

    /// The finished file may be a little larger than its trial was: the report tells of the trials.
    void hold_budget(const std::vector<GridSize>& ladder) {
        const std::uint64_t budget = *options_.budget_bytes;
        GridSearch& search = *result_.report.search;
        search.asked_bytes = budget;
        for (std::uint64_t bytes = file_bytes(); bytes > budget; bytes = file_bytes()) {
            const auto at = std::find(ladder.begin(), ladder.end(), GridSize{search.rows, search.cols});
            const std::string size = std::to_string(search.rows) + "x" + std::to_string(search.cols);
            if (options_.max_error)
                throw Error(codes::kBudgetTooSmall, size +
                                                        " is the smallest grid that holds the error; its file takes " +
                                                        std::to_string(bytes) + " bytes of " + std::to_string(budget));
            if (at == ladder.begin() || at == ladder.end())
                throw Error(codes::kBudgetTooSmall, "the smallest grid, " + size + ", takes " + std::to_string(bytes) +
                                                        " bytes of " + std::to_string(budget));
            search.next = GridTrial{at->rows, at->cols, std::nan(""), std::nan(""), bytes, "too large", 0};
            const GridSize smaller = *(at - 1);
            search.rows = smaller.rows, search.cols = smaller.cols;
            map_and_fit(smaller, true);
            finish();
        }
    }

    /// Size of the file as it stands, by writing it.
    [[nodiscard]] std::uint64_t file_bytes() {
        if (options_.scratch.empty()) throw Error(codes::kUsage, "a budget needs a .dgm to measure");
        result_.maps.report_json = to_json(result_.report, false);
        formats::write_dgm(result_.maps, options_.scratch);
        std::error_code error;
        const std::uintmax_t bytes = std::filesystem::file_size(options_.scratch, error);
        std::filesystem::remove(options_.scratch, error);
        if (error) throw Error(codes::kWriteFailed, error.message(), options_.scratch.string());
        return bytes;
    }

    /// What Precision::kAuto stands for. Rounding to 65536 steps over the longest side of the bounding box moves a
    /// point by a twelfth root of a step squared rms along any direction.
    [[nodiscard]] bool choose_u16() const {
        if (options_.precision != Precision::kAuto) return options_.precision == Precision::kU16;
        if (!options_.max_error) return false;
        const ErrorGoal& goal = *options_.max_error;
        const double asked = goal.percent ? goal.value / 100 : goal.value / repaired_.frame.diagonal;
        const double rounding = 1 / (65535.0 * std::sqrt(12.0));
        return asked >= (goal.kind == ErrorKind::kRms ? 3 : 6) * rounding;
    }

    void use_cuts(CutUse use) { use_ = use; }

    void map_and_fit(GridSize largest, bool fit) {
        stage("map", [&] { map_components(largest); });
        if (options_.ablates("diagonals")) straighten_diagonals();
        if (fit && options_.fit != Fit::kSample) stage("fit", [&] { fit_charts(); });
    }

    void make_and_measure(const std::vector<std::string>& layers, std::uint64_t samples) {
        result_.maps.charts.clear();
        result_.report.charts.clear();
        worst_quantisation_ = 0;
        stage("layers", [&] { make_charts(layers); });
        stage("measure", [&] { measure(layers, samples); });
    }

    void finish() {
        make_and_measure(options_.layers, kErrorSamples);
        if (GridSearch* search = result_.report.search ? &*result_.report.search : nullptr) {
            const SurfaceError& error = result_.report.error;
            search->reached = search->kind == "hausdorff" ? error.hausdorff : error.rms;
            search->reached_percent = 100 * search->reached / error.diagonal;
        }
        result_.maps.report_json = to_json(result_.report, false);
    }

    void import() {
        BakeReport& report = result_.report;
        // Before anything is read: what changes while it is read makes the output stale, not wrong.
        result_.maps.source_hash = formats::hash_file(source_);
        report.inputs_hash = hash_inputs(source_);
        imported_ = formats::read_mesh(source_);
        report.source_name = source_.filename().string();
        report.source_vertices = imported_.mesh.positions.size();
        report.source_faces = imported_.mesh.faces.size();
        report.warnings = imported_.warnings;
        report.repairs = imported_.dropped;
    }

    void load_images() {
        const auto try_read = [&](const std::filesystem::path& path, auto read, auto& into) {
            if (path.empty()) return;
            try {
                into = read(path);
            } catch (const Error& e) {
                result_.report.warnings.push_back("texture " + path.filename().string() + " left out: " + e.what());
            }
        };
        for (const model::Material& material : imported_.mesh.materials) {
            try_read(material.diffuse_map, formats::read_image, images_.colour.emplace_back());
            auto& height = images_.height.emplace_back();
            if (material.bump_is_normal_map)
                result_.report.warnings.push_back("normal map " + material.bump_map.filename().string() +
                                                  " left out: only height maps go into the bump layer");
            else
                try_read(material.bump_map, formats::read_height, height);
        }
        if (!options_.texture.empty()) images_.fabric = formats::read_image(options_.texture);
    }

    void describe() {
        constexpr double kSmallest = 1e-15, kLargest = 1e15;  // squared lengths of the deformation layer are float
        const double diagonal = repaired_.frame.diagonal;
        if (!(diagonal > kSmallest && diagonal < kLargest))
            throw Error(codes::kScaleOutOfRange, "the bounding box measures " + std::to_string(std::log10(diagonal)) +
                                                     " powers of ten across; single precision holds -15 to 15")
                .with_stage("repair");
        for (const auto& count : repaired_.counts) result_.report.repairs.push_back(count);
        const std::size_t components = repaired_.components.size();
        for (const TriMesh& component : repaired_.components) areas_.push_back(surface_area(component));
        largest_ = static_cast<std::size_t>(std::max_element(areas_.begin(), areas_.end()) - areas_.begin());
        shapes_.aspects.assign(components, 0.0);
        cuts_.resize(components);
        if (components > 1)
            result_.report.warnings.push_back(std::to_string(components) + " components: one chart each");
        if (options_.on_notice)
            for (const std::string& line : notices(result_.report, repaired_)) options_.on_notice(line);
    }

    /// The grid of component c where the largest one has `largest`, as if it were as large; see component_size.
    [[nodiscard]] GridSize full_size(std::size_t c, GridSize largest) const {
        if (c == largest_ || shapes_.aspects[c] == 0) return largest;
        return grid_of(std::uint64_t{largest.rows} * largest.cols, shapes_.aspects[c]);
    }

    void map_components(GridSize largest) {
        mapped_.clear();
        std::vector<GridSize> full;
        for (std::size_t c = 0; c < areas_.size(); ++c) full.push_back(full_size(c, largest));
        const std::vector<GridSize> sizes = component_sizes(full, areas_, largest_);
        std::uint64_t samples = 0;
        for (const GridSize& size : sizes) samples += std::uint64_t{size.rows} * size.cols;
        if (samples > kMaxSamples)
            throw Error(codes::kTooLarge, std::to_string(areas_.size()) + " components would need " +
                                              std::to_string(samples) + " samples, more than " +
                                              std::to_string(kMaxSamples) +
                                              "; join or drop components, or ask for a smaller --size");
        for (std::size_t c = 0; c < sizes.size(); ++c) {
            Attempt<ComponentResult> mapped =
                bake_component({repaired_.components[c], sizes[c], full_size(c, largest), use_}, options_, cuts_[c],
                               part("map", c, sizes.size()));
            if (!mapped && sizes.size() == 1) throw mapped.error();
            if (!mapped)
                throw Error(mapped.error().code(),
                            "component " + std::to_string(c + 1) + " of " + std::to_string(sizes.size()) + ": " +
                                mapped.error().what(),
                            mapped.error().place());
            mapped_.push_back(std::move(*mapped));
        }
    }

    /// All quads that may be split either way are split alike: those at the border keep what the topology needs.
    void straighten_diagonals() {
        for (ComponentResult& mapped : mapped_) {
            SampledChart& chart = mapped.chart;
            for (std::uint32_t i = 1; i + 2 < chart.m; ++i)
                for (std::uint32_t j = 1; j + 2 < chart.n; ++j) chart.diagonals[std::size_t{i} * (chart.n - 1) + j] = 0;
        }
    }

    void fit_charts() {
        FitOptions fit = options_.fit == Fit::kBest ? best_fit() : l2_fit();
        fit.split_quads = !options_.ablates("diagonals");
        fit.on_lattice = u16_;
        for_each_component(mapped_.size(), part("fit", 0, 1), [&](std::size_t c, const model::Progress& progress) {
            fit_chart(mapped_[c].chart, fit, progress);
        });
    }

    void make_charts(const std::vector<std::string>& layers) {
        for (std::size_t c = 0; c < mapped_.size(); ++c) {
            const model::Progress progress = part("layers", c, mapped_.size());
            progress.update("layers", 0);
            const SampledChart& chart = mapped_[c].chart;
            const StoredFrame stored = choose_frame(repaired_.frame, chart, u16_);
            const bool fitted = options_.fit != Fit::kSample;
            SampleGrid fine;  // read by bump and texture alone
            if (wants(layers, "bump") || wants(layers, "texture"))
                fine = fitted ? closest_samples(chart, 2 * chart.m - 1, 2 * chart.n - 1)
                              : rasterize(chart.disk.mesh.faces, chart.uv, 2 * chart.m - 1, 2 * chart.n - 1);
            LayerInput in{chart, repaired_.frame, stored, images_, fine, std::nullopt, fitted, std::nullopt};
            if (options_.texture_size) in.texture_size = {options_.texture_size->rows, options_.texture_size->cols};
            if (options_.bump_size) in.bump_size = {options_.bump_size->rows, options_.bump_size->cols};
            in.texture_size = limited_texture(texture_shape(in), c);
            ChartLayers made = make_layers(in, layers, progress);
            worst_quantisation_ = std::max(worst_quantisation_, made.worst_quantisation);
            result_.maps.charts.push_back(std::move(made.chart));
        }
        result_.report.worst_quantisation = worst_quantisation_;
        result_.maps.generator = generator();
        result_.maps.source_name = result_.report.source_name;
        const std::string settings = canonical_settings(options_);
        result_.maps.settings_hash = formats::hash_bytes(std::as_bytes(std::span(settings)));
    }

    /// The texture's size within BakeOptions::texture_bytes, which charts share by area, and texel_length.
    [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> limited_texture(std::pair<std::uint32_t, std::uint32_t> shape,
                                                                          std::size_t c) const {
        constexpr double kTexelBytes = 4;
        const double texels = static_cast<double>(shape.first) * shape.second;
        double most = texels;
        if (options_.texture_bytes) {
            double area = 0;
            for (const double a : areas_) area += a;
            const double share = area > 0 ? areas_[c] / area : 1 / static_cast<double>(areas_.size());
            most = std::min(most, share * static_cast<double>(*options_.texture_bytes) / kTexelBytes);
        }
        if (options_.texel_length) {
            const double side = repaired_.frame.diagonal / *options_.texel_length;
            most = std::min(most, areas_[c] * side * side);
        }
        const double scale = std::sqrt(most / texels);
        if (!(scale < 1)) return shape;
        const auto shrunk = [&](std::uint32_t side) {
            return std::max<std::uint32_t>(1, static_cast<std::uint32_t>(std::floor(side * scale)));
        };
        return {shrunk(shape.first), shrunk(shape.second)};
    }

    /// Errors of what was stored, in the normalised frame, then scaled to source units.
    void measure(const std::vector<std::string>& layers, std::uint64_t error_samples) {
        const Frame& frame = repaired_.frame;
        double area = 0;
        for (const double a : areas_) area += a;
        const std::size_t count = mapped_.size();
        const auto share_of = [&](std::size_t c) { return area > 0 ? areas_[c] / area : 1; };
        const std::size_t parts = count > 1 ? 2 : 1;  // the charts, the whole
        std::vector<MeasuredChart> measured(count);
        for_each_component(count, part("measure", 0, parts), [&](std::size_t c, const model::Progress& progress) {
            measured[c] = measure_chart(repaired_.components[c], mapped_[c].chart, result_.maps.charts[c], frame,
                                        {error_samples, share_of(c)}, progress);
            for (const Candidate& candidate : mapped_[c].candidates)
                measured[c].report.candidates.push_back(report_of(candidate));
        });
        SurfaceError whole = measured.front().report.error;
        if (count > 1) {
            TriMesh whole_source, whole_map;
            for (std::size_t c = 0; c < count; ++c) {
                append(whole_source, repaired_.components[c]), append(whole_map, measured[c].surface);
                measured[c].surface = {};
            }
            whole =
                measure_surface_error(whole_source, whole_map, {.samples = error_samples}, part("measure", 1, parts));
            // Charts are measured with their normals, each as much as its share of the area.
            double squared[3] = {0, 0, 0};
            for (std::size_t c = 0; c < count; ++c) {
                const SurfaceError& e = measured[c].report.error;
                const double degrees[3] = {e.normal_rms_degrees, e.normal_rms_face_degrees, e.normal_rms_bump_degrees};
                for (int k = 0; k < 3; ++k) squared[k] += share_of(c) * degrees[k] * degrees[k];
            }
            whole.normal_rms_degrees = std::sqrt(squared[0]);
            whole.normal_rms_face_degrees = std::sqrt(squared[1]);
            whole.normal_rms_bump_degrees = std::sqrt(squared[2]);
        }
        result_.report.error = whole;
        for (MeasuredChart& chart : measured) result_.report.charts.push_back(std::move(chart.report));
        const auto to_source_units = [&](SurfaceError& e) {
            for (double* x : {&e.rms, &e.hausdorff, &e.rms_forward, &e.rms_backward, &e.hausdorff_forward,
                              &e.hausdorff_backward, &e.diagonal})
                *x *= frame.diagonal;
        };
        to_source_units(result_.report.error);
        for (ChartReport& report : result_.report.charts) to_source_units(report.error);
        // Geometry is always made, to measure it; it is stored only if it was asked for.
        if (!wants(layers, "geometry"))
            for (model::Chart& chart : result_.maps.charts)
                std::erase_if(chart.layers, [](const model::Layer& l) {
                    return l.name == "geometry" || l.name == "border_geometry";
                });
    }

    static constexpr std::uint64_t kErrorSamples = kSurfaceSamples;  // as dgm-validate: the same points
    static constexpr std::uint64_t kFewSamples = 1000;
    inline static const std::vector<std::string> kGeometryOnly{"geometry"};

    const std::filesystem::path& source_;
    const BakeOptions& options_;
    const model::Progress& progress_;
    formats::ImportedMesh imported_;
    RepairedMesh repaired_;
    MaterialImages images_;
    std::vector<double> areas_;  ///< per component
    std::size_t largest_ = 0;    ///< component
    bool u16_ = false;           ///< positions are stored as u16
    ComponentShapes shapes_;     ///< aspect 0: that of the largest
    std::vector<CutMemory> cuts_;
    CutUse use_ = CutUse::kSearch;
    std::string trial_;  ///< "129x129: " while grids are tried
    std::vector<ComponentResult> mapped_;
    double worst_quantisation_ = 0;
    BakeResult result_;
};

}  // namespace

BakeResult bake_asset(const std::filesystem::path& source, const BakeOptions& options,
                      const model::Progress& progress) {
    return AssetBake(source, options, progress).run();
}

}  // namespace dgm::bake
