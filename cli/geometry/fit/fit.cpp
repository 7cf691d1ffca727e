// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/fit.cpp
#include "geometry/fit/fit.h"

#include <tbb/parallel_for.h>

#include <dgm/grid.h>
#include <algorithm>
#include <cmath>

#include "geometry/fit/least_squares.h"
#include "geometry/spatial/closest_point.h"

namespace dgm::bake {
namespace {

constexpr double kDamping = 0.005;
constexpr int kCgIterations = 20;
constexpr double kMinCosine = 0.3;  // source and grid are matched only where their normals agree so far

struct SurfacePoint {
    Vec3d position;
    Vec3d normal;  // of its face; zero for a face without area
    std::uint32_t face;
    double b[3];
};

Vec3d face_normal(const TriMesh& mesh, std::uint32_t f) {
    const auto q = mesh.corners(f);
    return normalized(cross(q[1] - q[0], q[2] - q[0]), Vec3d{});
}

/// `count` points spread evenly by area (k-th point at share (k + 1/2) / count of the total, inside its face by the R2
/// sequence), so the same mesh gives the same points.
std::vector<SurfacePoint> spread_points(const TriMesh& mesh, std::size_t count) {
    std::vector<double> upto(mesh.faces.size() + 1, 0.0);
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) upto[f + 1] = upto[f] + face_area(mesh.corners(f));
    std::vector<SurfacePoint> points;
    points.reserve(count);
    std::size_t f = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const double at = upto.back() * (static_cast<double>(k) + 0.5) / static_cast<double>(count);
        while (f + 1 < mesh.faces.size() && upto[f + 1] <= at) ++f;
        double s = std::fmod(0.5 + 0.7548776662466927 * static_cast<double>(k), 1.0);
        double t = std::fmod(0.5 + 0.5698402909980532 * static_cast<double>(k), 1.0);
        if (s + t > 1) s = 1 - s, t = 1 - t;
        const auto q = mesh.corners(f);
        points.push_back({q[0] * (1 - s - t) + q[1] * s + q[2] * t,
                          face_normal(mesh, static_cast<std::uint32_t>(f)),
                          static_cast<std::uint32_t>(f),
                          {1 - s - t, s, t}});
    }
    return points;
}

double squared_distance_to_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const Vec3d e0 = b - a, e1 = c - a, d = p - a;
    const double g00 = dot(e0, e0), g01 = dot(e0, e1), g11 = dot(e1, e1), r0 = dot(e0, d), r1 = dot(e1, d);
    const double det = g00 * g11 - g01 * g01;
    const double s = det > 0 ? (g11 * r0 - g01 * r1) / det : -1, t = det > 0 ? (g00 * r1 - g01 * r0) / det : -1;
    if (s >= 0 && t >= 0 && s + t <= 1) {
        const Vec3d r = d - e0 * s - e1 * t;
        return dot(r, r);
    }
    const auto to_edge = [&](const Vec3d& from, const Vec3d& e) {
        const Vec3d v = p - from;
        const double l = dot(e, e), u = l > 0 ? std::clamp(dot(v, e) / l, 0.0, 1.0) : 0.0;
        const Vec3d r = v - e * u;
        return dot(r, r);
    };
    return std::min({to_edge(a, e0), to_edge(a, e1), to_edge(b, c - b)});
}

std::vector<Vec3d> face_normals(const TriMesh& mesh) {
    std::vector<Vec3d> normals(mesh.faces.size());
    for (std::uint32_t f = 0; f < normals.size(); ++f) normals[f] = face_normal(mesh, f);
    return normals;
}

/// Mean distance of the chart's samples.
double sample_spacing(const TriMesh& surface, const SampledChart& chart) {
    double area = 0;
    for (std::size_t f = 0; f < surface.faces.size(); ++f) area += face_area(surface.corners(f));
    return std::sqrt(area / static_cast<double>(chart.grid_count()));
}

/// The closest point whose face looks the same way, if it is about as near as the closest of all: a sliver's normal
/// says little, and may agree with the far side of the body only. Else the closest of all.
ClosestPoint closest_facing(const ClosestPointIndex& index, const std::vector<Vec3d>& normals, const Vec3d& point,
                            const Vec3d& normal, double spacing) {
    const ClosestPoint any = index.query(point);
    if (any.face == kNone || dot(normals[any.face], normal) > kMinCosine) return any;
    const ClosestPoint same = index.query_facing(point, normal, kMinCosine);
    return same.face != kNone && same.distance <= 2 * any.distance + 0.25 * spacing ? same : any;
}

class Fitter {
 public:
    Fitter(const TriMesh& component, SampledChart& chart, const FitOptions& options, const model::Progress& progress)
        : source_(component),
          chart_(chart),
          options_(options),
          progress_(progress),
          source_index_(component.positions, component.faces) {
        number_unknowns();
        source_normals_ = face_normals(component);
        const auto count =
            static_cast<std::size_t>(options.points_per_sample * static_cast<double>(chart.grid_count()));
        points_ = spread_points(component, count);
        area_points_ = points_.size();
        add_vertices();
    }

    FitReport run() {
        FitReport report;
        best_ = measure();
        report.start_rms = best_.rms, report.start_hausdorff = best_.hausdorff;
        if (untangle()) best_ = measure();
        keep();
        const int total = options_.rounds + options_.worst_rounds;
        for (int round = 0; round < options_.rounds; ++round) {
            progress_.update("fit", static_cast<double>(round) / total);
            match();
            step(false);
            if (options_.split_quads && round % 2 == 0) split_quads();
            const SurfaceError error = measure();
            if (error.rms < best_.rms) best_ = error, keep(), ++report.rounds;
        }
        restore();
        const double price = std::pow(10, options_.worst_price_db / 20), allowed = best_.rms * price;
        for (int round = 0; round < options_.worst_rounds; ++round) {
            progress_.update("fit", static_cast<double>(options_.rounds + round) / total);
            match();
            step(true);
            const SurfaceError error = measure();
            if (error.rms <= allowed && error.hausdorff < best_.hausdorff) best_ = error, keep(), ++report.rounds;
        }
        restore();
        report.rms = best_.rms, report.hausdorff = best_.hausdorff;
        return report;
    }

 private:
    void number_unknowns() {
        const std::size_t count = chart_.positions.size();
        unknown_.assign(count, kNone);
        for (std::uint32_t s = 0; s < count; ++s) {
            if (!chart_.on_surface(s)) continue;
            const std::uint32_t rep = chart_.representative[s];
            if (unknown_[rep] == kNone) unknown_[rep] = unknowns_++, sample_of_.push_back(rep);
            unknown_[s] = unknown_[rep];
        }
        // Samples on the source's real border: edges of the welded grid surface with one face.
        fixed_.assign(unknowns_, 0);
        std::vector<std::pair<std::uint64_t, int>> edges;
        for (const Face& f : chart_.faces())
            for (int k = 0; k < 3; ++k) {
                const std::uint64_t a = unknown_[f[k]], b = unknown_[f[(k + 1) % 3]];
                edges.emplace_back(std::min(a, b) << 32 | std::max(a, b), 0);
            }
        std::sort(edges.begin(), edges.end());
        for (std::size_t k = 0; k < edges.size(); ++k) {
            const bool single = (k == 0 || edges[k - 1].first != edges[k].first) &&
                                (k + 1 == edges.size() || edges[k + 1].first != edges[k].first);
            if (single) fixed_[edges[k].first >> 32] = fixed_[edges[k].first & 0xffffffffu] = 1;
        }
    }

    void add_vertices() {
        std::vector<Vec3d> normals(source_.positions.size(), Vec3d{});
        std::vector<std::uint32_t> face(source_.positions.size(), kNone);
        for (std::uint32_t f = 0; f < source_.faces.size(); ++f) {
            const auto q = source_.corners(f);
            for (std::uint32_t v : source_.faces[f]) normals[v] += cross(q[1] - q[0], q[2] - q[0]), face[v] = f;
        }
        for (std::uint32_t v = 0; v < face.size(); ++v)
            if (face[v] != kNone)
                points_.push_back({source_.positions[v], normalized(normals[v], Vec3d{}), face[v], {0, 0, 0}});
    }

    [[nodiscard]] SurfaceError measure() const {
        return quick_error(source_, chart_, std::min<std::uint64_t>(60'000, 2 * chart_.grid_count()));
    }
    void keep() { kept_positions_ = chart_.positions, kept_diagonals_ = chart_.diagonals; }
    void restore() { chart_.positions = kept_positions_, chart_.diagonals = kept_diagonals_; }

    /// Sampling may leave faces that look against the source, above all beside the zigzags of a cut. Their samples are
    /// moved to the mean of their neighbours and back onto the source until none is left. Returns true if any moved.
    bool untangle() {
        constexpr int kPasses = 30;
        constexpr double kUpright = 0.1;
        bool moved = false;
        std::vector<Vec3d> sum(unknowns_);
        std::vector<double> count(unknowns_);
        for (int pass = 0; pass < kPasses; ++pass) {
            const TriMesh surface = chart_.surface();
            std::vector<char> turned(surface.faces.size(), 0);
            tbb::parallel_for(std::size_t{0}, turned.size(), [&](std::size_t f) {
                const auto q = surface.corners(f);
                const ClosestPoint hit = source_index_.query((q[0] + q[1] + q[2]) / 3);
                turned[f] =
                    dot(face_normal(surface, static_cast<std::uint32_t>(f)), source_normals_[hit.face]) < kUpright;
            });
            std::vector<char> marked(unknowns_, 0);
            bool any = false;
            for (std::size_t f = 0; f < turned.size(); ++f)
                if (turned[f]) {
                    any = true;
                    for (std::uint32_t s : surface.faces[f]) marked[unknown_[s]] = 1;
                }
            if (!any) break;
            std::fill(sum.begin(), sum.end(), Vec3d{});
            std::fill(count.begin(), count.end(), 0.0);
            for (const Face& f : surface.faces)
                for (int k = 0; k < 3; ++k) {
                    const std::uint32_t u = unknown_[f[k]];
                    if (!marked[u]) continue;
                    sum[u] += surface.positions[f[(k + 1) % 3]] + surface.positions[f[(k + 2) % 3]];
                    count[u] += 2;
                }
            for (std::uint32_t u = 0; u < unknowns_; ++u)
                if (marked[u] && !fixed_[u] && count[u] > 0) sum[u] = source_index_.query(sum[u] / count[u]).point;
            for (std::size_t s = 0; s < chart_.positions.size(); ++s) {
                const std::uint32_t u = unknown_[s];
                if (u != kNone && marked[u] && !fixed_[u] && count[u] > 0) chart_.positions[s] = sum[u], moved = true;
            }
        }
        return moved;
    }

    void match() {
        surface_ = chart_.surface();
        const ClosestPointIndex index(surface_.positions, surface_.faces);
        const std::vector<Vec3d> surface_normals = face_normals(surface_);
        const double spacing = sample_spacing(surface_, chart_);
        hits_.assign(points_.size(), {});
        constexpr std::size_t kChunk = 1024;
        tbb::parallel_for(std::size_t{0}, (points_.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
            for (std::size_t k = chunk * kChunk; k < std::min(points_.size(), (chunk + 1) * kChunk); ++k)
                hits_[k] = closest_facing(index, surface_normals, points_[k].position, points_[k].normal, spacing);
        });
        if (!options_.two_way) return;
        spread_back_points();
        back_hits_.assign(back_points_.size(), {});
        tbb::parallel_for(std::size_t{0}, (back_points_.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
            for (std::size_t k = chunk * kChunk; k < std::min(back_points_.size(), (chunk + 1) * kChunk); ++k)
                back_hits_[k] = closest_facing(source_index_, source_normals_, back_points_[k].position,
                                               back_points_[k].normal, spacing);
        });
    }

    /// Every grid sample and the middle of every face, weighed by area: a sample in a crowded part of the grid, where
    /// no source point falls, is still held to the surface.
    void spread_back_points() {
        back_points_.clear(), back_weights_.clear();
        std::vector<double> area(unknowns_, 0.0);
        std::vector<Vec3d> normal(unknowns_, Vec3d{});
        std::vector<std::uint32_t> face(unknowns_, kNone);
        double total = 0;
        for (std::uint32_t f = 0; f < surface_.faces.size(); ++f) {
            const auto q = surface_.corners(f);
            const Vec3d n = cross(q[1] - q[0], q[2] - q[0]);
            const double a = 0.5 * length(n);
            total += a;
            back_points_.push_back({(q[0] + q[1] + q[2]) / 3, normalized(n, Vec3d{}), f, {1.0 / 3, 1.0 / 3, 1.0 / 3}});
            back_weights_.push_back(a);
            for (std::uint32_t s : surface_.faces[f]) {
                const std::uint32_t u = unknown_[s];
                area[u] += a / 3, normal[u] += n, face[u] = f;
            }
        }
        for (std::uint32_t u = 0; u < unknowns_; ++u) {
            if (face[u] == kNone) continue;
            SurfacePoint p{chart_.positions[sample_of_[u]], normalized(normal[u], Vec3d{}), face[u], {0, 0, 0}};
            for (int k = 0; k < 3; ++k) p.b[k] = unknown_[surface_.faces[face[u]][k]] == u ? 1 : 0;
            back_points_.push_back(p);
            back_weights_.push_back(area[u]);
        }
        // As much weight in all as the forward points have; none under a twentieth of the mean.
        const double mean = 2 * total / static_cast<double>(back_points_.size());
        const double scale = static_cast<double>(area_points_) / (2 * total);
        for (double& w : back_weights_) w = std::max(w, 0.05 * mean) * scale;
    }

    /// Normal of the metric: the surface's, but along the gap where the closest point is on an edge of the face.
    [[nodiscard]] Vec3d metric_normal(const Vec3d& gap, const Vec3d& face, const double b[3]) const {
        const bool inside = b[0] > 1e-9 && b[1] > 1e-9 && b[2] > 1e-9;
        return inside ? face : normalized(gap, face);
    }

    void step(bool worst_only) {
        std::vector<FitRow> rows;
        rows.reserve(hits_.size() + back_hits_.size());
        double largest = 0;
        for (const ClosestPoint& hit : hits_)
            if (hit.face != kNone) largest = std::max(largest, hit.distance);
        for (const ClosestPoint& hit : back_hits_)
            if (hit.face != kNone) largest = std::max(largest, hit.distance);
        // The last rounds pull hardest where more than 60 % of the largest error stands.
        const auto urgency = [&](double distance) {
            if (!worst_only || !(largest > 0)) return 1.0;
            const double share = distance / largest;
            return share > 0.6 ? 1 + 200 * (share - 0.6) : 1.0;
        };
        for (std::size_t k = 0; k < points_.size(); ++k) {
            const ClosestPoint& hit = hits_[k];
            if (hit.face == kNone) continue;
            const Face& f = surface_.faces[hit.face];
            const Vec3d gap = points_[k].position - hit.point;
            const double weight = (k < area_points_ ? 1.0 : 0.25) * urgency(hit.distance);
            rows.push_back({{unknown_[f[0]], unknown_[f[1]], unknown_[f[2]]},
                            {hit.barycentric[0], hit.barycentric[1], hit.barycentric[2]},
                            gap,
                            metric_normal(gap, face_normal(surface_, hit.face), hit.barycentric),
                            weight});
        }
        if (options_.two_way)
            for (std::size_t k = 0; k < back_points_.size(); ++k) {
                const ClosestPoint& hit = back_hits_[k];
                if (hit.face == kNone) continue;
                const Face& f = surface_.faces[back_points_[k].face];
                const double* b = back_points_[k].b;
                const Vec3d gap = hit.point - back_points_[k].position;
                rows.push_back({{unknown_[f[0]], unknown_[f[1]], unknown_[f[2]]},
                                {b[0], b[1], b[2]},
                                gap,
                                metric_normal(gap, face_normal(source_, hit.face), hit.barycentric),
                                back_weights_[k] * urgency(hit.distance)});
            }
        move(least_squares_step(rows, unknowns_, fixed_, options_.point_share, kDamping, kCgIterations));
    }

    /// Applies a step: its tangential part is clamped, then halved (and at last the whole step) at the corners of faces
    /// that it would turn.
    void move(const std::vector<Vec3d>& step) {
        std::vector<Vec3d> normal(unknowns_, Vec3d{}), along(unknowns_), across(unknowns_);
        std::vector<double> edge(unknowns_, INFINITY), slide(unknowns_, 1.0), whole(unknowns_, 1.0);
        const std::vector<Face>& faces = surface_.faces;
        for (std::uint32_t f = 0; f < faces.size(); ++f) {
            const auto q = surface_.corners(f);
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t u = unknown_[faces[f][k]];
                normal[u] += cross(q[1] - q[0], q[2] - q[0]);
                edge[u] = std::min({edge[u], length(q[(k + 1) % 3] - q[k]), length(q[(k + 2) % 3] - q[k])});
            }
        }
        for (std::uint32_t u = 0; u < unknowns_; ++u) {
            normal[u] = normalized(normal[u], Vec3d{});
            across[u] = normal[u] * dot(step[u], normal[u]);
            along[u] = step[u] - across[u];
            const double l = length(along[u]), limit = options_.max_slide * edge[u];
            if (l > limit) along[u] *= limit / l;
        }
        std::vector<Vec3d> start(unknowns_);
        for (std::uint32_t u = 0; u < unknowns_; ++u) start[u] = chart_.positions[sample_of_[u]];
        const auto moved = [&](std::uint32_t u) { return start[u] + (across[u] + along[u] * slide[u]) * whole[u]; };
        for (int pass = 0; pass < 12; ++pass) {
            bool turned = false;
            for (std::uint32_t f = 0; f < faces.size(); ++f) {
                const std::uint32_t a = unknown_[faces[f][0]], b = unknown_[faces[f][1]], c = unknown_[faces[f][2]];
                const Vec3d pa = moved(a), pb = moved(b), pc = moved(c);
                const Vec3d now = cross(pb - pa, pc - pa), was = cross(start[b] - start[a], start[c] - start[a]);
                const double after = length(now), before = length(was);
                if (dot(now, was) > 0.5 * after * before && after > 0.1 * before &&
                    !turns_against(f, now / after, was / before))
                    continue;
                turned = true;
                for (std::uint32_t u : {a, b, c}) {
                    slide[u] *= 0.5;
                    if (pass >= 5) whole[u] *= 0.25;
                    if (pass >= 9) whole[u] = 0;
                }
            }
            if (!turned) break;
        }
        for (std::size_t s = 0; s < chart_.positions.size(); ++s)
            if (unknown_[s] != kNone && !fixed_[unknown_[s]]) chart_.positions[s] = moved(unknown_[s]);
    }

    /// True if the face would look away from the source below it, more than it did. The first back points are the
    /// middles of the faces.
    [[nodiscard]] bool turns_against(std::uint32_t f, const Vec3d& now, const Vec3d& was) const {
        constexpr double kUpright = 0.3;
        if (!options_.two_way || back_hits_[f].face == kNone) return false;
        const Vec3d& source = source_normals_[back_hits_[f].face];
        return dot(now, source) < std::min(kUpright, dot(was, source));
    }

    /// Each quad takes the diagonal with the smaller squared distance to the source points over it. Quads at the
    /// chart's border keep theirs: those may be the only ones that leave the welded surface a manifold.
    void split_quads() {
        const std::uint32_t m = chart_.m, n = chart_.n;
        std::vector<std::uint32_t> quad_of_face;  // per grid triangle; strip faces have none
        for (std::uint32_t i = 0; i + 1 < m; ++i)
            for (std::uint32_t j = 0; j + 1 < n; ++j)
                if (chart_.has_quad(i, j)) quad_of_face.insert(quad_of_face.end(), 2, i * (n - 1) + j);
        std::vector<std::array<double, 2>> sums(std::size_t{m - 1} * (n - 1), {0, 0});
        for (std::size_t k = 0; k < points_.size(); ++k) {
            if (hits_[k].face >= quad_of_face.size()) continue;
            const std::uint32_t quad = quad_of_face[hits_[k].face], i = quad / (n - 1), j = quad % (n - 1);
            for (unsigned d = 0; d < 2; ++d) {
                double least = INFINITY;
                for (const Face& t : quad_triangles(i, j, n, d))
                    least =
                        std::min(least, squared_distance_to_triangle(points_[k].position, chart_.positions[t[0]],
                                                                     chart_.positions[t[1]], chart_.positions[t[2]]));
                sums[quad][d] += least;
            }
        }
        for (std::uint32_t i = 1; i + 2 < m; ++i)
            for (std::uint32_t j = 1; j + 2 < n; ++j) {
                const std::size_t quad = std::size_t{i} * (n - 1) + j;
                if (!chart_.has_quad(i, j) || sums[quad][0] == sums[quad][1]) continue;
                const unsigned wanted = sums[quad][1] < sums[quad][0], old = chart_.diagonals[quad];
                if (wanted == old) continue;
                if (keeps_orientation(quad_triangles(i, j, n, old), quad_triangles(i, j, n, wanted)))
                    chart_.diagonals[quad] = static_cast<std::uint8_t>(wanted);
            }
    }

    [[nodiscard]] bool keeps_orientation(const std::array<Face, 2>& old, const std::array<Face, 2>& fresh) const {
        const auto area = [&](const Face& f) {
            return cross(chart_.positions[f[1]] - chart_.positions[f[0]],
                         chart_.positions[f[2]] - chart_.positions[f[0]]);
        };
        const Vec3d mean = area(old[0]) + area(old[1]);
        return dot(area(fresh[0]), mean) > 0 && dot(area(fresh[1]), mean) > 0;
    }

    const TriMesh& source_;
    SampledChart& chart_;
    const FitOptions& options_;
    const model::Progress& progress_;
    ClosestPointIndex source_index_;
    std::vector<SurfacePoint> points_, back_points_;
    std::vector<double> back_weights_;
    std::size_t area_points_ = 0;
    std::vector<ClosestPoint> hits_, back_hits_;
    TriMesh surface_;
    std::vector<std::uint32_t> unknown_, sample_of_;
    std::uint32_t unknowns_ = 0;
    std::vector<char> fixed_;
    std::vector<Vec3d> source_normals_;
    SurfaceError best_;
    std::vector<Vec3d> kept_positions_;
    std::vector<std::uint8_t> kept_diagonals_;
};

/// Looks up the source, as faces of the disk, from points of the chart's surface.
class DiskLookup {
 public:
    explicit DiskLookup(const SampledChart& chart)
        : index_(chart.disk.mesh.positions, chart.disk.mesh.faces),
          normals_(face_normals(chart.disk.mesh)),
          spacing_(sample_spacing(chart.surface(), chart)) {}
    [[nodiscard]] SurfaceSample operator()(const Vec3d& p, const Vec3d& normal) const {
        const ClosestPoint hit = closest_facing(index_, normals_, p, normal, spacing_);
        return {hit.face, {hit.barycentric[0], hit.barycentric[1], hit.barycentric[2]}};
    }

 private:
    ClosestPointIndex index_;
    std::vector<Vec3d> normals_;
    double spacing_;
};

}  // namespace

FitOptions l2_fit() {
    FitOptions o;
    o.two_way = true;
    return o;
}

FitOptions best_fit() {
    FitOptions o;
    o.rounds = 10;
    o.point_share = 0.01;
    o.two_way = true;
    o.worst_rounds = 8;
    return o;
}

FitReport fit_chart(const TriMesh& component, SampledChart& chart, const FitOptions& options,
                    const model::Progress& progress) {
    const FitReport report = Fitter(component, chart, options, progress).run();
    const DiskLookup look_up(chart);
    std::vector<Vec3d> normals(chart.positions.size(), Vec3d{});
    for (const Face& f : chart.faces()) {
        const Vec3d n =
            cross(chart.positions[f[1]] - chart.positions[f[0]], chart.positions[f[2]] - chart.positions[f[0]]);
        for (std::uint32_t s : f) normals[chart.representative[s]] += n;
    }
    tbb::parallel_for(std::size_t{0}, chart.samples.size(), [&](std::size_t s) {
        if (chart.on_surface(s) && chart.representative[s] == s)
            chart.samples[s] = look_up(chart.positions[s], normalized(normals[s]));
    });
    for (std::size_t s = 0; s < chart.samples.size(); ++s)
        if (chart.representative[s] != s) chart.samples[s] = chart.samples[chart.representative[s]];
    return report;
}

SampleGrid closest_samples(const SampledChart& chart, std::uint32_t rows, std::uint32_t cols) {
    SampleGrid grid{rows, cols, std::vector<SurfaceSample>(std::size_t{rows} * cols)};
    const DiskLookup look_up(chart);
    tbb::parallel_for(std::uint32_t{0}, rows, [&](std::uint32_t r) {
        for (std::uint32_t c = 0; c < cols; ++c) {
            // Position on the chart's own grid, and the quad's triangle under it.
            const double x = static_cast<double>(r) * (chart.m - 1) / std::max(1u, rows - 1);
            const double y = static_cast<double>(c) * (chart.n - 1) / std::max(1u, cols - 1);
            const auto i = std::min(static_cast<std::uint32_t>(x), chart.m - 2),
                       j = std::min(static_cast<std::uint32_t>(y), chart.n - 2);
            if (!chart.has_quad(i, j)) continue;
            const double s = x - i, t = y - j;
            const unsigned diagonal = chart.diagonals[std::size_t{i} * (chart.n - 1) + j];
            const auto triangles = quad_triangles(i, j, chart.n, diagonal);
            // (0,0) (1,0) (1,1) | (0,0) (1,1) (0,1)   or   (0,0) (1,0) (0,1) | (1,0) (1,1) (0,1)
            const bool second = diagonal == 0 ? t > s : s + t > 1;
            const Face& f = triangles[second];
            const std::array<double, 3> b = diagonal == 0
                                                ? second ? std::array{1 - t, s, t - s} : std::array{1 - s, s - t, t}
                                            : second ? std::array{1 - t, s + t - 1, 1 - s}
                                                     : std::array{1 - s - t, s, t};
            const Vec3d p = chart.positions[f[0]] * b[0] + chart.positions[f[1]] * b[1] + chart.positions[f[2]] * b[2];
            const Vec3d n =
                cross(chart.positions[f[1]] - chart.positions[f[0]], chart.positions[f[2]] - chart.positions[f[0]]);
            grid.samples[std::size_t{r} * cols + c] = look_up(p, normalized(n));
        }
    });
    for (const SurfaceSample& s : grid.samples) grid.missing += s.face == kNone;
    return grid;
}

}  // namespace dgm::bake
