// SPDX-License-Identifier: GPL-3.0-or-later
// cli/pipeline/pipeline.cpp
#include "pipeline/pipeline.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>

#include "dgm/hash.h"
#include "geometry/fit/fit.h"
#include "geometry/layers/layers.h"
#include "geometry/metrics/bump_normals.h"
#include "geometry/metrics/reconstruction.h"
#include "geometry/metrics/turned_faces.h"
#include "geometry/repair/repair.h"
#include "mesh/mesh_reader.h"
#include "model/codes.h"
#include "pipeline/component_bake.h"

namespace dgm::bake {
namespace {

using model::Error;
namespace codes = model::codes;

constexpr std::uint64_t kMaxSamples = std::uint64_t{1} << 26;  // of all charts together: 3 GB of layers

double total_area(const TriMesh& mesh) {
    double sum = 0;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) sum += face_area(mesh.corners(f));
    return sum;
}

/// Six times the signed volume.
double six_volume(const TriMesh& mesh) {
    double sum = 0;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const auto q = mesh.corners(f);
        sum += dot(q[0], cross(q[1], q[2]));
    }
    return sum;
}

/// Appends `part` to `whole`: what errors of a whole asset are measured on.
void append(TriMesh& whole, const TriMesh& part) {
    const auto base = static_cast<std::uint32_t>(whole.positions.size());
    whole.positions.insert(whole.positions.end(), part.positions.begin(), part.positions.end());
    for (const Face& f : part.faces) whole.faces.push_back({f[0] + base, f[1] + base, f[2] + base});
}

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
        stage("map", [&] { map_components(); });
        if (options_.ablates("diagonals")) straighten_diagonals();
        if (options_.fit != Fit::kSample) stage("fit", [&] { fit_charts(); });
        stage("layers", [&] { make_charts(); });
        stage("measure", [&] { measure(); });
        result_.maps.report_json = to_json(result_.report, false);
        return std::move(result_);
    }

 private:
    template <class Body>
    void stage(const char* name, Body body) {
        progress_.update(name, 0);
        const auto start = std::chrono::steady_clock::now();
        const std::clock_t cpu_start = std::clock();
        try {
            body();
        } catch (Error& e) {
            e.with_stage(name);
            throw;
        }
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        result_.report.times.push_back(
            {name, seconds.count(), static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC});
    }

    void import() {
        imported_ = formats::read_mesh(source_);
        BakeReport& report = result_.report;
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
        if (components > 1)
            result_.report.warnings.push_back(std::to_string(components) + " components: one chart each");
    }

    void map_components() {
        std::vector<double> areas;
        for (const TriMesh& component : repaired_.components) areas.push_back(total_area(component));
        const double largest = *std::max_element(areas.begin(), areas.end());
        std::uint64_t samples = 0;
        for (std::size_t c = 0; c < areas.size(); ++c) {
            const GridSize size = component_size(options_.size, areas[c], largest);
            samples += std::uint64_t{size.rows} * size.cols;
        }
        if (samples > kMaxSamples)
            throw Error(codes::kTooLarge, std::to_string(areas.size()) + " components would need " +
                                              std::to_string(samples) + " samples, more than " +
                                              std::to_string(kMaxSamples) +
                                              "; join or drop components, or ask for a smaller --size");
        for (std::size_t c = 0; c < areas.size(); ++c) {
            const double done = static_cast<double>(c) / static_cast<double>(areas.size());
            model::Progress inner;
            inner.cancelled = progress_.cancelled;
            inner.on_update = [&](std::string_view, double share) {
                progress_.update("map", done + share / static_cast<double>(areas.size()));
            };
            try {
                mapped_.push_back(bake_component(repaired_.components[c],
                                                 component_size(options_.size, areas[c], largest), options_, inner));
            } catch (Error& e) {
                if (areas.size() == 1) throw;
                throw Error(
                    e.code(),
                    "component " + std::to_string(c + 1) + " of " + std::to_string(areas.size()) + ": " + e.what(),
                    e.place());
            }
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
        for (std::size_t c = 0; c < mapped_.size(); ++c) {
            model::Progress inner;
            inner.cancelled = progress_.cancelled;
            inner.on_update = [&](std::string_view, double share) {
                progress_.update("fit", (static_cast<double>(c) + share) / static_cast<double>(mapped_.size()));
            };
            fit_chart(mapped_[c].chart, fit, inner);
        }
    }

    void make_charts() {
        for (std::size_t c = 0; c < mapped_.size(); ++c) {
            progress_.update("layers", static_cast<double>(c) / static_cast<double>(mapped_.size()));
            const SampledChart& chart = mapped_[c].chart;
            const StoredFrame stored = choose_frame(repaired_.frame, chart, options_.precision == Precision::kU16);
            const bool fitted = options_.fit != Fit::kSample;
            const SampleGrid fine = fitted
                                        ? closest_samples(chart, 2 * chart.m - 1, 2 * chart.n - 1)
                                        : rasterize(chart.disk.mesh.faces, chart.uv, 2 * chart.m - 1, 2 * chart.n - 1);
            LayerInput in{chart, repaired_.frame, stored, images_, fine, std::nullopt, fitted, std::nullopt};
            if (options_.texture_size) in.texture_size = {options_.texture_size->rows, options_.texture_size->cols};
            if (options_.bump_size) in.bump_size = {options_.bump_size->rows, options_.bump_size->cols};
            ChartLayers made = make_layers(in, options_.layers);
            worst_quantisation_ = std::max(worst_quantisation_, made.worst_quantisation);
            result_.maps.charts.push_back(std::move(made.chart));
        }
        result_.report.worst_quantisation = worst_quantisation_;
        result_.maps.generator = "dgm-bake " DGM_VERSION;
        result_.maps.source_name = result_.report.source_name;
        result_.maps.source_hash = formats::hash_file(source_);
        const std::string settings = canonical_settings(options_);
        result_.maps.settings_hash = formats::hash_bytes(std::as_bytes(std::span(settings)));
    }

    /// Errors of what was stored, in the normalised frame, then scaled to source units.
    void measure() {
        const Frame& frame = repaired_.frame;
        double area = 0;
        for (const TriMesh& component : repaired_.components) area += total_area(component);
        TriMesh whole_source, whole_map;
        for (std::size_t c = 0; c < mapped_.size(); ++c) {
            const TriMesh& component = repaired_.components[c];
            const SampledChart& chart = mapped_[c].chart;
            Reconstruction reconstruction = reconstruct(result_.maps.charts[c]);
            TriMesh& map = reconstruction.mesh;
            const std::optional<BumpNormals> bump = BumpNormals::of(result_.maps.charts[c], reconstruction);
            for (Vec3d& p : map.positions) p = (p - frame.centre) / frame.diagonal;
            ChartReport report;
            report.method = chart.method;
            report.domain = chart.domain == layout::Domain::kSquare ? "square" : "free";
            report.rows = chart.m, report.cols = chart.n;
            report.source_vertices = component.positions.size();
            report.source_faces = component.faces.size();
            report.seam_gap = reconstruction.seam_gap;
            report.cut_length = chart.cut_length * frame.diagonal;
            report.map = measure_map(chart.disk.mesh.positions, chart.disk.mesh.faces, chart.uv);
            std::size_t used = 0;
            for (std::size_t s = 0; s < chart.grid_count(); ++s) used += chart.on_surface(s);
            report.utilisation = static_cast<double>(used) / static_cast<double>(chart.grid_count());
            for (std::size_t s = 0; s < chart.representative.size(); ++s)
                report.seam_pairs += chart.representative[s] != s;
            report.source_topology = measure_topology(component.positions.size(), component.faces);
            report.map_topology = measure_topology(map.positions.size(), reconstruction.welded_faces);
            if (report.source_topology.boundary_loops == 0) {
                const double truth = six_volume(component);
                if (truth != 0) report.volume_relative_error = six_volume(map) / truth - 1;
            }
            report.turned_faces = count_turned_faces(component, map);
            report.candidates = mapped_[c].candidates;
            const double share = area > 0 ? total_area(component) / area : 1;
            const auto samples = static_cast<std::uint64_t>(std::max(2000.0, 400'000 * share));
            model::Progress inner;
            inner.cancelled = progress_.cancelled;
            SurfaceErrorOptions sampling{samples, 1, {}};
            if (bump) sampling.shading = [&](std::uint32_t face, const double(&b)[3]) { return bump->at(face, b); };
            report.error = measure_surface_error(component, map, sampling, inner);
            add_normals(report.error, share);
            if (mapped_.size() > 1) append(whole_source, component), append(whole_map, map);
            result_.report.charts.push_back(std::move(report));
            progress_.update("measure", static_cast<double>(c + 1) / static_cast<double>(mapped_.size() + 1));
        }
        result_.report.error = result_.report.charts.front().error;
        if (mapped_.size() > 1) {
            result_.report.error = measure_surface_error(whole_source, whole_map, {400'000, 1, {}});
            // Charts are measured with their normals, each as much as its share of the area.
            result_.report.error.normal_rms_degrees = std::sqrt(normals_squared_[0]);
            result_.report.error.normal_rms_face_degrees = std::sqrt(normals_squared_[1]);
            result_.report.error.normal_rms_bump_degrees = std::sqrt(normals_squared_[2]);
        }
        const auto to_source_units = [&](SurfaceError& e) {
            for (double* x : {&e.rms, &e.hausdorff, &e.rms_forward, &e.rms_backward, &e.hausdorff_forward,
                              &e.hausdorff_backward, &e.diagonal})
                *x *= frame.diagonal;
        };
        to_source_units(result_.report.error);
        for (ChartReport& report : result_.report.charts) to_source_units(report.error);
        // Geometry is always made, to measure it; it is stored only if it was asked for.
        if (!wants(options_.layers, "geometry"))
            for (model::Chart& chart : result_.maps.charts)
                std::erase_if(chart.layers, [](const model::Layer& l) {
                    return l.name == "geometry" || l.name == "border_geometry";
                });
    }

    void add_normals(const SurfaceError& chart, double share) {
        const double degrees[3] = {chart.normal_rms_degrees, chart.normal_rms_face_degrees,
                                   chart.normal_rms_bump_degrees};
        for (int k = 0; k < 3; ++k) normals_squared_[k] += share * degrees[k] * degrees[k];
    }

    const std::filesystem::path& source_;
    const BakeOptions& options_;
    const model::Progress& progress_;
    std::array<double, 3> normals_squared_{};  // stored, face, bump: mean over the area
    formats::ImportedMesh imported_;
    RepairedMesh repaired_;
    MaterialImages images_;
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
