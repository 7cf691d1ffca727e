// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/chart/free_chart.cpp
#include "geometry/chart/free_chart.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string>

#include "geometry/chart/bijective_layout.h"
#include "geometry/chart/fit_to_square.h"
#include "geometry/chart/lattice_strip.h"
#include "geometry/chart/square_chart.h"
#include "geometry/cut/cut_graph.h"
#include "geometry/mesh/infinity.h"
#include "geometry/metrics/map_metrics.h"
#include "geometry/parameterize/convex_map.h"
#include "geometry/simplify/simplify.h"
#include "math/portable.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

using model::Error;
namespace codes = model::codes;

std::vector<std::uint32_t> border_vertices(const Disk& disk) {
    std::vector<std::uint32_t> border;
    for (std::uint32_t h : disk.border()) border.push_back(origin(disk.mesh.faces, h));
    return border;
}

std::vector<Vec2d> points_at(std::span<const Vec2d> uv, std::span<const std::uint32_t> vertices) {
    std::vector<Vec2d> out;
    for (std::uint32_t v : vertices) out.push_back(uv[v]);
    return out;
}

/// For a chart that overlaps itself whatever the cut: its border, edge lengths of the surface, on a circle, and the
/// inside by positive cotangent weights, which Tutte's theorem makes one to one. No border edge is shorter than a tenth
/// of its equal share. Where doubles do not hold that map, by weights that crowd less behind narrow places.
std::vector<Vec2d> lay_on_circle(const Disk& disk, std::span<const std::uint32_t> border,
                                 const model::Progress& progress) {
    const std::size_t n = border.size();
    std::vector<double> lengths(n);
    double total = 0;
    for (std::size_t k = 0; k < n; ++k)
        total += lengths[k] = length(disk.mesh.positions[border[(k + 1) % n]] - disk.mesh.positions[border[k]]);
    double floored = 0;
    for (double& l : lengths) floored += l = std::max(l, 0.1 * total / static_cast<double>(n));
    std::vector<Vec2d> circle;
    double at = 0;
    for (std::size_t k = 0; k < n; ++k) {
        const double angle = 2 * M_PI * at / floored;
        circle.push_back({0.5 + 0.5 * math::cos(angle), 0.5 + 0.5 * math::sin(angle)});
        at += lengths[k];
    }
    ConvexMapSolver solver(disk.mesh.positions.size(), disk.mesh.faces, border);
    std::vector<Vec2d> uv =
        solver.solve(positive_cotangent_weights(disk.mesh.positions, disk.mesh.faces, solver.edges()), circle);
    if (count_not_positive(disk.mesh.faces, uv) > 0)
        if (auto spread = flip_free_start({disk.mesh.positions, disk.mesh.faces, border, circle}, progress,
                                          FlipFreeStart::kSpread))
            uv = std::move(*spread);
    return uv;
}

/// Halves the edges before and after some vertices of the border, on both sides of the cut.
void halve_border_at(Disk& disk, std::vector<Vec2d>& uv, std::span<const std::uint32_t> places) {
    const std::vector<std::uint32_t> border = disk.border();
    std::set<std::uint32_t> edges;
    for (const std::uint32_t b : places)
        for (const std::uint32_t h : {border[b], border[(b + border.size() - 1) % border.size()]})
            edges.insert(disk.mate[h] == kNone ? h : std::min(h, disk.mate[h]));
    for (const std::uint32_t h : edges) split_border(disk, uv, h, 0.5);
}

/// Border samples, numbered after the grid, in border order; copies of a surface point share their weld id.
void add_border_samples(SampledChart& chart, const Disk& disk, std::span<const std::uint32_t> border) {
    std::vector<std::uint32_t> face_of(disk.mesh.positions.size(), kNone), lowest(disk.weld_count, kNone);
    for (std::uint32_t f = 0; f < disk.mesh.faces.size(); ++f)
        for (std::uint32_t v : disk.mesh.faces[f])
            if (face_of[v] == kNone) face_of[v] = f;
    const auto grid = static_cast<std::uint32_t>(chart.grid_count());
    const std::vector<std::uint8_t> reversed = disk.reversed_vertices();
    if (!reversed.empty()) chart.reversed.resize(grid + border.size());
    chart.representative.resize(grid + border.size());
    for (std::uint32_t s = 0; s < grid; ++s) chart.representative[s] = s;
    for (std::uint32_t b = 0; b < border.size(); ++b) {
        const std::uint32_t v = border[b], face = face_of[v];
        SurfaceSample at{face};
        for (int k = 0; k < 3; ++k) at.b[k] = disk.mesh.faces[face][k] == v ? 1 : 0;
        chart.samples.push_back(at);
        std::uint32_t& first = lowest[disk.weld[v]];
        if (first == kNone) first = grid + b;
        chart.representative[grid + b] = first;
        if (!reversed.empty()) chart.reversed[grid + b] = reversed[v] ^ reversed[border[first - grid]];
    }
}

/// The chart's lattice, border samples and strip. @return places on the border where more samples are needed
std::vector<std::uint32_t> fill_chart(SampledChart& chart, const Disk& disk, std::span<const Vec2d> uv,
                                      const SampleGrid& fine, const FreeChartTools& tools) {
    const std::vector<std::uint32_t> border = border_vertices(disk);
    const std::vector<Vec2d> outline = points_at(uv, border);
    if (!tools.is_simple(outline)) throw Error(codes::kMapInvalid, chart.method + ": the chart overlaps itself");
    chart.samples = coarsen(fine, chart.m, chart.n);
    chart.mask.assign(chart.samples.size(), 0);
    for (std::size_t s = 0; s < chart.samples.size(); ++s) chart.mask[s] = chart.samples[s].face != kNone;
    chart.border_uv = outline;
    chart.strip.clear();
    add_border_samples(chart, disk, border);
    return join_lattice_to_border(chart, tools.triangulate);
}

SampledChart sample_free_chart(Disk disk, std::vector<Vec2d> uv, std::uint32_t m, std::uint32_t n, std::string method,
                               const FreeChartTools& tools, Box box = Box::kLeastArea) {
    constexpr int kHalvings = 4;
    check_map(disk, uv, method);
    fit_to_square(uv, border_vertices(disk), m, n, box);
    divide_border(disk, uv, m - 1.0, n - 1.0);
    check_map(disk, uv, method);  // fitting and dividing round; nothing may have turned over
    SampledChart chart;
    chart.m = m;
    chart.n = n;
    chart.domain = layout::Domain::kFree;
    chart.method = std::move(method);
    SampleGrid fine;
    for (int halvings = 0;; ++halvings) {
        fine = rasterize(disk.mesh.faces, uv, 2 * m - 1, 2 * n - 1);
        const std::vector<std::uint32_t> crowded = fill_chart(chart, disk, uv, fine, tools);
        if (crowded.empty() || halvings == kHalvings) break;
        halve_border_at(disk, uv, crowded);
        check_map(disk, uv, chart.method);
    }
    chart.disk = std::move(disk);
    chart.uv = std::move(uv);
    for (std::size_t s = 0; s < chart.grid_count(); ++s)
        if (!chart.mask[s]) chart.samples[s] = {};
    place_samples(chart);
    choose_diagonals(chart, fine);
    return chart;
}

constexpr double kGoodStretch = 1.25;  // L2 stretch from which a shorter cut is preferred to a better map
constexpr double kBetter = 0.95;       // of the stretch so far: a longer cut must reach it to be taken
// Loops about so many handles make a cut that is long as it is, and each map of it takes long: no more than two.
constexpr std::int64_t kManyHandles = 16;
constexpr int kShrunkPerRound = 2;
constexpr double kLeastBranch = 0.1;  // of the distance of the farthest vertex: shorter branches are not worth a trial
constexpr int kTipsPerRound = 6;
constexpr double kFarTip =
    0.65;  // of the root of the area: no point of a flat disk is farther than 0.56 from its border
constexpr double kNearTip = 0.4;  // of the first tip's distance to the cut: nearer ones are left for the next round

/// Joins the vertices farthest from the cut to it: tips of limbs before anything else. False if there are none.
bool lengthen(CutGraph& cut, std::vector<std::uint32_t>& joined) {
    double first = 0;
    std::vector<double> distance = cut.distance_to_cut();
    for (int k = 0; k < kTipsPerRound; ++k, cut.follow_cut(distance)) {
        const auto tip = std::max_element(distance.begin(), distance.end());
        if (k == 0) first = *tip;
        if (!(*tip > 0) || *tip < kNearTip * first) return k > 0;
        joined.push_back(static_cast<std::uint32_t>(tip - distance.begin()));
        cut.join(joined.back());
    }
    return true;
}

/// A cut, and the method's map of the disk it leaves.
struct Layout {
    Disk disk;
    std::vector<Vec2d> uv = {};
    double cut_length = 0;
    double stretch = kInfinity;  // L2, of a map without flips
    bool overlaps = false;
    std::size_t joined = 0;  // vertices joined to the first cut
};

Layout lay_out(Disk disk, const Parameterizer& method, const FreeChartTools& tools, const model::Progress& progress,
               std::optional<Error>& failure) {
    Layout out{.disk = std::move(disk)};
    out.disk.join_sides();
    // A cut of one edge leaves two border edges between the same two vertices, which no map can separate.
    if (const std::vector<std::uint32_t> edges = out.disk.border(); edges.size() == 2)
        out.disk.split(edges.front(), 0.5);
    const std::vector<std::uint32_t> border = border_vertices(out.disk);
    const std::string name(method.name());
    try {
        out.uv = method.solve({out.disk.mesh.positions, out.disk.mesh.faces, border, {}}, progress);
        check_map(out.disk, out.uv, name);
        out.stretch = measure_map(out.disk.mesh.positions, out.disk.mesh.faces, out.uv).stretch_l2;
        out.overlaps = !tools.is_simple(points_at(out.uv, border));
        if (out.overlaps) throw Error(codes::kMapInvalid, name + ": the chart overlaps itself");
    } catch (const Error& e) {
        if (e.code().number != codes::kMapInvalid.number) throw;
        failure = e;
    }
    return out;
}

/// Splits edges inside that join two border vertices: the faces that they cut off would lie in a segment of the circle,
/// almost without height.
void split_chords(Disk& disk, std::span<const std::uint32_t> border) {
    std::vector<char> on_border(disk.mesh.positions.size(), 0);
    for (const std::uint32_t v : border) on_border[v] = 1;
    for (std::uint32_t h = 0; h < disk.opposite.size(); ++h) {  // grows while it runs; new edges end inside
        if (disk.opposite[h] == kNone) continue;
        const std::uint32_t a = origin(disk.mesh.faces, h), b = target(disk.mesh.faces, h);
        if (a < on_border.size() && b < on_border.size() && on_border[a] && on_border[b]) disk.split(h, 0.5);
    }
}

/// For a cut whose map is no chart: from the circle down as far as the energy of the method goes without an overlap.
SampledChart chart_without_overlap(Disk disk, std::uint32_t m, std::uint32_t n, const Parameterizer& method,
                                   const FreeChartTools& tools, const model::Progress& progress, const Error& why) {
    constexpr double kCrowded = 1e4;  // energy; an isometric map has 2
    const std::vector<std::uint32_t> border = border_vertices(disk);
    const std::string name(method.name());
    std::vector<Vec2d> circle = lay_on_circle(disk, border, progress);
    SlimOptions fixed;
    fixed.border_fixed = true;
    if (flip_free_energy({disk.mesh.positions, disk.mesh.faces, border, {}}, circle, fixed) > kCrowded) {
        split_chords(disk, border);
        circle = lay_on_circle(disk, border, progress);
    }
    const FlipFreeEnergy energy = name == "arap" ? FlipFreeEnergy::kArap : FlipFreeEnergy::kSymmetricDirichlet;
    std::string how = "; laid out again without overlap";
    SampledChart chart;
    try {
        std::vector<Vec2d> uv = descend_bijective({disk.mesh.positions, disk.mesh.faces, border, {}}, circle, energy,
                                                  tools.triangulate, progress);
        chart = sample_free_chart(disk, std::move(uv), m, n, name, tools, Box::kLeastSquares);
    } catch (const Error& e) {
        if (e.code().number != codes::kMapInvalid.number) throw;
        how = "; laid out again with a convex border";
        chart = sample_free_chart(std::move(disk), circle, m, n, name, tools);
    }
    chart.note = why.what() + how;
    return chart;
}

/// Joins the points that shrank most in a map to the cut [Gu, Gortler, Hoppe 2002]. False if there are none.
bool lengthen_where_shrunk(CutGraph& cut, const Layout& layout, std::vector<std::uint32_t>& joined) {
    const std::size_t points = cut.mesh().positions.size();
    std::vector<double> surface(points, 0.0), map(points, 0.0);
    for (const Face& f : layout.disk.mesh.faces) {
        const auto& q = layout.disk.mesh.positions;
        const double area = face_area({q[f[0]], q[f[1]], q[f[2]]});
        const double mapped = signed_area(layout.uv[f[0]], layout.uv[f[1]], layout.uv[f[2]]);
        for (const std::uint32_t v : f)
            if (const std::uint32_t point = layout.disk.weld[v]; point < points) {
                surface[point] += area;
                map[point] += mapped;
            }
    }
    for (int k = 0; k < kShrunkPerRound; ++k) {
        const std::vector<double> distance = cut.distance_to_cut();
        const double far = *std::max_element(distance.begin(), distance.end());
        std::uint32_t worst = kNone;
        double most = 0;
        for (std::uint32_t v = 0; v < points; ++v) {
            if (!(distance[v] > kLeastBranch * far)) continue;
            const double shrunk = surface[v] / std::max(map[v], std::numeric_limits<double>::min());
            if (shrunk > most) {
                most = shrunk;
                worst = v;
            }
        }
        if (worst == kNone) return k > 0;
        joined.push_back(worst);
        cut.join(worst);
    }
    return true;
}

CutGraph first_cut(const TriMesh& component) {
    CutGraph cut(component);
    cut.cut_to_disk();
    // A closed body has more than two tips, and one that bulges far out of its border cannot be laid flat as it is.
    const std::vector<double> distance = cut.distance_to_cut();
    std::vector<std::uint32_t> tips;
    if (cut.boundary_loop_count() == 0 ||
        *std::max_element(distance.begin(), distance.end()) > kFarTip * std::sqrt(surface_area(component)))
        lengthen(cut, tips);
    return cut;
}

/// Longer and longer cuts, and the maps that the method makes of them.
struct CutTrials {
    const Parameterizer& method;
    const FreeChartTools& tools;
    const model::Progress& progress;
    CutGraph cut;
    std::vector<std::uint32_t> joined = {};  // to the first cut, in this order
    std::optional<Layout> best = {}, last = {};
    std::optional<Error> failure = {};
    int idle = 0, rounds = 0;
    double stretch_factor = 1;

    void lay_out() {
        last = bake::lay_out(cut.open(), method, tools, progress, failure);
        last->stretch *= stretch_factor;
        last->cut_length = cut.length();
        last->joined = joined.size();
        ++rounds;
    }

    /// False if no longer cut is wanted.
    bool judge() {
        // Arms that lie over each other are moved apart; cutting more would give more arms.
        if (last->overlaps && last->stretch < kGoodStretch) return false;
        const bool gains = !last->overlaps && last->stretch < (best ? kBetter * best->stretch : kInfinity);
        if (best && !gains && ++idle > 1) return false;
        if (gains) {
            best = last;
            idle = 0;
        }
        return !best || best->stretch >= kGoodStretch;
    }

    bool lengthen_cut() {
        const bool mapped = std::isfinite(last->stretch);
        return mapped ? lengthen_where_shrunk(cut, *last, joined) : lengthen(cut, joined);
    }

    /// Rounds after the first one, which has been laid out.
    void run(int most) {
        while (judge() && rounds < most && lengthen_cut()) lay_out();
    }

    /// The last cut may be the better one, were it not for the overlap.
    [[nodiscard]] bool may_gain() const { return last->overlaps && best && last->stretch < kBetter * best->stretch; }
};

constexpr std::size_t kScoutFaces = 3000;

/// The further rounds of `trials`, whose first map overlaps, on a coarse copy of the component: a map of the component
/// itself is made with the best cut found there, none with cuts that overlap. False if the copy does not take the first
/// cut as the component does.
bool run_on_copy(CutTrials& trials, int most) {
    const TriMesh& fine = trials.cut.mesh();
    SimplifyOptions options;
    options.regularity = 1e-3;  // a map wants round rings more than the last detail
    const CompactMesh copy = compact(fine.positions, simplify(fine, kScoutFaces, options, trials.progress).faces);
    CutTrials scout{trials.method, trials.tools, trials.progress, first_cut(copy.mesh)};
    scout.lay_out();
    // Without its details a surface is stretched less.
    if (scout.last->stretch < trials.last->stretch && std::isfinite(trials.last->stretch))
        scout.last->stretch *= scout.stretch_factor = trials.last->stretch / scout.last->stretch;
    scout.run(most);
    const auto follow = [&](const Layout& to) {
        while (trials.joined.size() < to.joined) {
            trials.joined.push_back(copy.original[scout.joined[trials.joined.size()]]);
            trials.cut.join(trials.joined.back());
        }
    };
    if (scout.best) {
        if (scout.best->joined == 0) return false;
        follow(*scout.best);
        if (trials.last->joined < trials.joined.size()) trials.lay_out();
        const Layout& found = *trials.last;
        if (!found.overlaps && found.stretch < (trials.best ? kBetter * trials.best->stretch : kInfinity))
            trials.best = found;
        if (found.overlaps || !scout.may_gain()) return true;
    }
    follow(*scout.last);
    if (scout.failure) trials.failure = scout.failure;
    trials.last = Layout{.disk = trials.cut.open(),
                         .cut_length = trials.cut.length(),
                         .stretch = scout.last->stretch,
                         .overlaps = scout.last->overlaps};
    trials.last->disk.join_sides();
    return true;
}

}  // namespace

SampledChart make_free_chart(Disk disk, std::uint32_t m, std::uint32_t n, const Parameterizer& method,
                             const FreeChartTools& tools, const model::Progress& progress) {
    std::optional<Error> failure;
    Layout layout = lay_out(std::move(disk), method, tools, progress, failure);
    if (!failure) {
        try {
            return sample_free_chart(layout.disk, std::move(layout.uv), m, n, std::string(method.name()), tools);
        } catch (const Error& e) {
            if (e.code().number != codes::kMapInvalid.number) throw;
            failure = e;
        }
    }
    return chart_without_overlap(std::move(layout.disk), m, n, method, tools, progress, *failure);
}

SampledChart make_free_chart(const TriMesh& component, std::uint32_t m, std::uint32_t n, const Parameterizer& method,
                             const FreeChartTools& tools, const model::Progress& progress) {
    CutTrials trials{method, tools, progress, first_cut(component)};
    const CutGraph& cut = trials.cut;
    const int rounds = cut.genus() > kManyHandles ? std::min(tools.cut_rounds, 2) : tools.cut_rounds;
    // Loops about handles need not run alike on a copy.
    const bool large = component.faces.size() > 2 * kScoutFaces && cut.genus() == 0;
    trials.lay_out();
    // Only maps of the component show the gain of a cut beyond a valid map.
    const bool scouts = large && rounds > 1 && trials.last->overlaps && trials.judge();
    if (!scouts || !run_on_copy(trials, rounds)) trials.run(rounds);
    std::optional<Layout>&best = trials.best, &last = trials.last;
    std::optional<Error>& failure = trials.failure;
    const bool may_gain = trials.may_gain();
    std::optional<SampledChart> chart;
    if (best) {
        try {
            chart =
                sample_free_chart(std::move(best->disk), std::move(best->uv), m, n, std::string(method.name()), tools);
            chart->cut_length = best->cut_length;
        } catch (const Error& e) {
            if (e.code().number != codes::kMapInvalid.number) throw;
            failure = e;
        }
    }
    if (chart && !may_gain) return std::move(*chart);
    SampledChart moved = chart_without_overlap(std::move(last->disk), m, n, method, tools, progress, *failure);
    moved.cut_length = last->cut_length;
    const auto stretch = [](const SampledChart& c) {
        return measure_map(c.disk->mesh.positions, c.disk->mesh.faces, c.uv).stretch_l2;
    };
    return chart && stretch(*chart) <= stretch(moved) ? std::move(*chart) : moved;
}

SampledChart make_uv_chart(const TriMesh& component, std::uint32_t m, std::uint32_t n, const FreeChartTools& tools,
                           const model::Progress& progress) {
    progress.update("parameterize", 0);
    const auto unsuited = [](const std::string& why) { return Error(codes::kMethodUnsuited, "uv: " + why); };
    if (component.corner_uvs.empty()) throw unsuited("the mesh has no texture coordinates");
    CutGraph cut(component);
    const std::vector<std::uint32_t> opposite = opposite_half_edges(component.faces);
    for (std::uint32_t h = 0; h < opposite.size(); ++h) {
        const std::uint32_t o = opposite[h];
        if (o == kNone || o < h) continue;
        const bool same = component.corner_uvs[h] == component.corner_uvs[next_half_edge(o)] &&
                          component.corner_uvs[next_half_edge(h)] == component.corner_uvs[o];
        cut.mark(h, !same);
    }
    Disk disk = cut.open();
    disk.join_sides();
    const Topology shape = measure_topology(disk.mesh.positions.size(), disk.mesh.faces);
    if (shape.components != 1)
        throw unsuited("the texture coordinates form " + std::to_string(shape.components) + " charts, not one");
    if (shape.boundary_loops != 1 || shape.genus != 0)
        throw unsuited("the texture chart is not a disk (" + std::to_string(shape.boundary_loops) + " borders)");
    std::vector<Vec2d> uv(disk.mesh.positions.size());
    double twice_area = 0;
    for (std::uint32_t f = 0; f < disk.mesh.faces.size(); ++f) {
        const Vec2d* corner = &component.corner_uvs[3 * std::size_t{f}];
        for (int k = 0; k < 3; ++k) uv[disk.mesh.faces[f][k]] = corner[k];
        twice_area += cross(corner[1] - corner[0], corner[2] - corner[0]);
    }
    if (twice_area < 0)
        for (Vec2d& p : uv) p.x = -p.x;  // mirrored as a whole
    try {
        return sample_free_chart(std::move(disk), std::move(uv), m, n, "uv", tools);
    } catch (const Error& e) { throw unsuited(e.what()); }
}

}  // namespace dgm::bake
