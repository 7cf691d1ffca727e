// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/metrics/surface_error.cpp
// Two one-sided measurements: sample one surface, ask the other for the closest point.
//
// Samples are stratified along the cumulative area of the faces (one jittered sample a stratum, so a face's share of
// samples is its share of area to within one) and follow the golden-ratio sequence across: a two-triangle square gets a
// Fibonacci lattice, a scan with more faces than samples gets jitter. They come out in face order, so each query can
// start from the last one's face. Results go into an array and are summed in a fixed order: the same bits for any
// number of threads.
#include "geometry/metrics/surface_error.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <unordered_set>
#include <vector>

#include "geometry/mesh/half_edges.h"
#include "geometry/mesh/infinity.h"
#include "geometry/metrics/same_places.h"
#include "geometry/spatial/closest_point.h"
#include "math/portable.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {
constexpr std::size_t kBlock = 2048;       // queries that share a chain of hints
constexpr std::size_t kProgressSteps = 8;  // a direction, between reports

struct Sample {
    Vec3d point;
    std::uint32_t face;
    double r1, r2;  // barycentric: 1 - r1, r1 (1 - r2), r1 r2
};

/// A place and its squared distance, in the unit of the measure.
struct Top {
    double squared = 0;
    Vec3d at;
    void take_higher(const Top& other) {
        if (other.squared > squared) *this = other;
    }
};

struct OneSided {
    double rms = 0, hausdorff = 0;
    Vec3d hausdorff_at;
    double normals = 0, face_normals = 0, bump_normals = std::numeric_limits<double>::quiet_NaN();  // degrees
    std::uint64_t samples = 0;
};

/// SplitMix64: a counter-based generator, so that sample k does not depend on who draws it.
std::uint64_t scramble(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}
double unit_interval(std::uint64_t bits) {
    return static_cast<double>(bits >> 11) * 0x1p-53;
}

/// Fixed-order pairwise sum: error grows with log n, and only n decides the order.
double pairwise_sum(std::span<const double> x) {
    if (x.size() <= 64) {
        double sum = 0;
        for (const double v : x) sum += v;
        return sum;
    }
    const std::size_t half = x.size() / 2;
    return pairwise_sum(x.first(half)) + pairwise_sum(x.subspan(half));
}

bool usable(const TriMesh& mesh, const Face& f) {
    for (const std::uint32_t v : f)
        if (v >= mesh.positions.size() || !is_finite(mesh.positions[v])) return false;
    return true;
}

/// Area of each face (0 for faces that cannot be used) in units of `unit` squared.
std::vector<double> face_areas(const TriMesh& mesh, double unit) {
    std::vector<double> areas(mesh.faces.size(), 0.0);
    for (std::size_t f = 0; f < areas.size(); ++f) {
        if (!usable(mesh, mesh.faces[f])) continue;
        const auto [a, b, c] = mesh.corners(f);
        const double area = 0.5 * length(cross((b - a) / unit, (c - a) / unit));
        if (std::isfinite(area)) areas[f] = area;
    }
    return areas;
}

std::vector<Sample> area_samples(const TriMesh& mesh, std::span<const double> areas, std::uint64_t count,
                                 std::uint64_t seed) {
    std::vector<Sample> samples;
    const double total = pairwise_sum(areas);
    if (!(total > 0) || count == 0) return samples;
    samples.reserve(count);
    const double stratum = total / static_cast<double>(count);
    const std::uint64_t golden = 0x9e3779b97f4a7c15u;  // 2^64 / phi
    std::size_t face = 0, last = areas.size();
    while (!(areas[last - 1] > 0)) --last;
    double before = 0;  // area of the faces before `face`
    for (std::uint64_t k = 0; k < count; ++k) {
        const double target = (static_cast<double>(k) + unit_interval(scramble(seed ^ scramble(k)))) * stratum;
        while (face + 1 < last && before + areas[face] <= target) before += areas[face++];
        const double t = areas[face] > 0 ? std::clamp((target - before) / areas[face], 0.0, 1.0) : 0.0;
        Sample s{{}, static_cast<std::uint32_t>(face), std::sqrt(t), unit_interval(scramble(seed) + golden * k)};
        const auto [a, b, c] = mesh.corners(face);
        s.point = a + (b - a) * (s.r1 * (1 - s.r2)) + (c - a) * (s.r1 * s.r2);
        samples.push_back(s);
    }
    return samples;
}

/// The farthest samples, and the farthest of other faces: where the largest distance is looked for. A large face may
/// have several tops, and a small one the highest. Samples nearer than `kRounding` lie on the other surface for all
/// that can be said: which of them is the farthest changes with the frame the meshes are given in.
std::vector<std::uint32_t> farthest(std::span<const Sample> samples, std::span<const double> squared,
                                    std::size_t tops) {
    constexpr std::size_t kLooked = 8192;
    constexpr double kRounding = 0x1p-22;  // of the unit: a few times the rounding of a position stored as float
    std::vector<std::uint32_t> order, out;
    for (std::uint32_t k = 0; k < samples.size(); ++k)
        if (squared[k] > kRounding * kRounding) order.push_back(k);
    const auto looked = order.begin() + static_cast<std::ptrdiff_t>(std::min(kLooked, order.size()));
    std::partial_sort(order.begin(), looked, order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return squared[a] != squared[b] ? squared[a] > squared[b] : a < b;
    });
    std::unordered_set<std::uint32_t> taken;
    for (auto k = order.begin(); k != looked && out.size() < 2 * tops; ++k)
        if (taken.insert(samples[*k].face).second || out.size() < tops) out.push_back(*k);
    return out;
}

/// Every vertex that a usable face names, with such a face, in vertex order.
std::vector<Sample> vertex_samples(const TriMesh& mesh) {
    constexpr auto kNone = ClosestPointIndex::kNoFace;
    std::vector<std::uint32_t> face_of(mesh.positions.size(), kNone);
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        if (!usable(mesh, mesh.faces[f])) continue;
        for (const std::uint32_t v : mesh.faces[f])
            if (face_of[v] == kNone) face_of[v] = static_cast<std::uint32_t>(f);
    }
    std::vector<Sample> samples;
    for (std::size_t v = 0; v < face_of.size(); ++v)
        if (face_of[v] != kNone) samples.push_back({mesh.positions[v], face_of[v], 0, 0});
    return samples;
}

/// `count` points along the edge of a face that begins at `corner`, evenly.
void append_along(const TriMesh& mesh, std::uint32_t face, std::uint32_t corner, std::uint64_t count,
                  std::vector<Sample>& samples) {
    const auto corners = mesh.corners(face);
    const std::uint32_t next = (corner + 1) % 3;
    for (std::uint64_t k = 0; k < count; ++k) {
        const double t = (static_cast<double>(k) + 0.5) / static_cast<double>(count);
        std::array<double, 3> at{};
        at[corner] = 1 - t;
        at[next] = t;
        const double r1 = at[1] + at[2];
        samples.push_back({corners[corner] * (1 - t) + corners[next] * t, face, r1, r1 > 0 ? at[2] / r1 : 0});
    }
}

/// The faces that can be used, and their numbers in the mesh.
struct UsableFaces {
    explicit UsableFaces(const TriMesh& mesh) {
        for (std::size_t f = 0; f < mesh.faces.size(); ++f)
            if (usable(mesh, mesh.faces[f])) {
                faces.push_back(mesh.faces[f]);
                named.push_back(static_cast<std::uint32_t>(f));
            }
    }
    std::vector<Face> faces;
    std::vector<std::uint32_t> named;
};

/// Points along the edges with a face on one side only, as evenly as four or fewer an edge can be. Two surfaces may
/// agree but where the border of one cuts a corner of the other's: in slivers that no sample by area falls into.
std::vector<Sample> border_samples(const TriMesh& mesh, std::uint64_t at_most) {
    const auto [faces, named] = UsableFaces(mesh);
    const std::vector<std::uint32_t> opposite = opposite_half_edges(faces);
    const auto edges = static_cast<std::uint64_t>(std::count(opposite.begin(), opposite.end(), kNone));
    std::vector<Sample> samples;
    if (edges == 0) return samples;
    const std::uint64_t each = std::clamp<std::uint64_t>(at_most / edges, 1, 4);
    samples.reserve(edges * each);
    for (std::uint32_t h = 0; h < opposite.size(); ++h) {
        if (opposite[h] != kNone) continue;
        append_along(mesh, named[h / 3], h % 3, each, samples);
    }
    return samples;
}

/// Points along creases, a side of a random point's share of the area apart and `at_most` in all: a surface that cuts
/// creases has its tops on them, sharper than points by area find on large facets. Shorter edges have their ends alone.
std::vector<Sample> crease_samples(const TriMesh& mesh, double spacing, std::uint64_t at_most) {
    constexpr double kCosine = 0.98;  // 11 degrees
    constexpr double kLong = 4;       // spacings
    const auto [faces, named] = UsableFaces(mesh);
    const auto normal = [&mesh](std::uint32_t f) {
        const auto [a, b, c] = mesh.corners(f);
        return normalized(cross(b - a, c - a), {});
    };
    const std::vector<std::uint32_t> opposite = opposite_half_edges(faces);
    std::vector<std::pair<std::uint32_t, double>> creases;  // half edge, length
    double all = 0;
    for (std::uint32_t h = 0; h < opposite.size(); ++h) {
        if (opposite[h] == kNone || opposite[h] < h) continue;
        const auto corners = mesh.corners(named[h / 3]);
        const double along = length(corners[(h + 1) % 3] - corners[h % 3]);
        if (!(along > kLong * spacing) || !(dot(normal(named[h / 3]), normal(named[opposite[h] / 3])) < kCosine))
            continue;
        creases.emplace_back(h, along);
        all += along;
    }
    std::vector<Sample> samples;
    if (creases.size() > at_most) return samples;
    spacing = std::max(spacing, all / static_cast<double>(at_most));
    for (const auto& [h, along] : creases) {
        const auto each = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(along / spacing));
        append_along(mesh, named[h / 3], h % 3, each, samples);
    }
    return samples;
}

std::vector<Vec3d> points_of(const std::vector<Sample>& samples) {
    std::vector<Vec3d> out;
    out.reserve(samples.size());
    for (const Sample& s : samples) out.push_back(s.point);
    return out;
}

/// Calls run(samples, answers, false) for one sample at each place, and gives the others its answer: where thousands of
/// charts meet at one edge, thousands of faces are as near to it.
template <class Run>
void run_places(const std::vector<Sample>& samples, std::span<double> out, const Run& run) {
    const std::vector<std::uint32_t> first = first_at_same_place(points_of(samples));
    std::vector<Sample> asked;
    for (std::uint32_t k = 0; k < samples.size(); ++k)
        if (first[k] == k) asked.push_back(samples[k]);
    std::vector<double> answers(asked.size());
    run(asked, answers, false);
    for (std::size_t k = 0, next = 0; k < samples.size(); ++k) out[k] = first[k] == k ? answers[next++] : out[first[k]];
}

/// Interpolated corner normal, or the face's; zero if there is none.
Vec3d normal_at(const TriMesh& mesh, std::size_t face, const double (&bary)[3], bool use_corners) {
    if (use_corners) {
        Vec3d n;
        for (std::size_t k = 0; k < 3; ++k) n += mesh.corner_normals[3 * face + k] * bary[k];
        return normalized(n, {});
    }
    const auto [a, b, c] = mesh.corners(face);
    return normalized(cross(b - a, c - a), {});
}

/// Angle between unit vectors in degrees, good to the last bits for small angles too.
double angle_degrees(const Vec3d& a, const Vec3d& b) {
    return math::atan2(length(cross(a, b)), dot(a, b)) * (180 / std::numbers::pi);
}

class Direction {
 public:
    Direction(const TriMesh& from, const TriMesh& to, const ClosestPointIndex& index, double unit, bool with_normals)
        : from_(from),
          to_(to),
          index_(index),
          unit_(unit),
          with_normals_(with_normals),
          use_corners_(from.corner_normals.size() == 3 * from.faces.size() &&
                       to.corner_normals.size() == 3 * to.faces.size()) {}

    OneSided measure(const SurfaceErrorOptions& options, const model::Progress& progress, double progress_from,
                     double progress_to) {
        const auto [surface, vertices, border, creases, spacing] = points(options);
        std::vector<double> squared(surface.size()), vertex_squared(vertices.size()), border_squared(border.size()),
            crease_squared(creases.size());
        if (with_normals_) angles_squared_.assign(surface.size(), kNoAngles);
        shading_ = &options.shading;

        const std::size_t total = surface.size() + vertices.size() + border.size() + creases.size();
        std::size_t done = 0;
        const auto run = [&](std::span<const Sample> samples, std::span<double> out, bool angles) {
            const std::size_t step = std::max(kBlock, total / kProgressSteps / kBlock * kBlock);
            for (std::size_t begin = 0; begin < samples.size(); begin += step) {
                progress.update("measure", progress_from + (progress_to - progress_from) * static_cast<double>(done) /
                                                               static_cast<double>(total));
                const std::size_t end = std::min(samples.size(), begin + step);
                const std::size_t blocks = (end - begin + kBlock - 1) / kBlock;
                tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t b) {
                    const std::size_t first = begin + b * kBlock;
                    measure_block(samples, out, first, std::min(end, first + kBlock), angles);
                });
                done += end - begin;
            }
        };
        run(surface, squared, with_normals_);
        run_places(vertices, vertex_squared, run);
        run_places(border, border_squared, run);
        run_places(creases, crease_squared, run);

        OneSided result;
        result.samples = total;
        Top worst;
        const auto take = [&worst](std::span<const Sample> samples, std::span<const double> known) {
            for (std::size_t k = 0; k < known.size(); ++k) worst.take_higher({known[k], samples[k].point});
        };
        take(surface, squared);
        take(vertices, vertex_squared);
        take(border, border_squared);
        take(creases, crease_squared);
        if (options.vertices) {
            worst.take_higher(highest(surface, squared, options.tops));
            worst.take_higher(highest(border, border_squared, options.tops));
            worst.take_higher(highest(creases, crease_squared, options.tops, spacing));
        }
        result.hausdorff = std::sqrt(worst.squared) * unit_;
        result.hausdorff_at = worst.at;
        const std::vector<double>& weighted = squared.empty() ? vertex_squared : squared;
        if (!weighted.empty())
            result.rms = std::sqrt(pairwise_sum(weighted) / static_cast<double>(weighted.size())) * unit_;
        if (with_normals_) {
            std::erase(angles_squared_, kNoAngles);
            result.normals = rms_of(0);
            result.face_normals = rms_of(1);
            if (*shading_) result.bump_normals = rms_of(2);
        }
        return result;
    }

 private:
    struct Points {
        std::vector<Sample> surface, vertices, border, creases;
        double spacing = 0;  ///< side of a random point's share of the area
    };
    [[nodiscard]] Points points(const SurfaceErrorOptions& options) const {
        Points out;
        const std::vector<double> areas = face_areas(from_, unit_);
        out.surface = area_samples(from_, areas, *options.samples, options.seed);
        // A mesh without any area is measured by its vertices alone.
        if (options.vertices || out.surface.empty()) out.vertices = vertex_samples(from_);
        if (!options.vertices) return out;
        out.border = border_samples(from_, *options.samples / 4);
        if (out.surface.empty()) return out;
        out.spacing = std::sqrt(pairwise_sum(areas) / static_cast<double>(out.surface.size())) * unit_;
        out.creases = crease_samples(from_, out.spacing, *options.samples / 4);
        return out;
    }

    using Angles = std::array<double, 3>;  // to the stored, the face's and the bump's normal
    static constexpr Angles kNoAngles{-1, -1, -1};

    [[nodiscard]] double rms_of(std::size_t kind) const {
        if (angles_squared_.empty()) return 0;
        std::vector<double> squares(angles_squared_.size());
        for (std::size_t k = 0; k < squares.size(); ++k) squares[k] = angles_squared_[k][kind];
        return std::sqrt(pairwise_sum(squares) / static_cast<double>(squares.size()));
    }

    /// The place that is found uphill from a sample on its face: by steps towards the corners and away
    /// from them, halved where none leads up [Hooke, Jeeves 1961]. Samples alone find a sharp maximum to a few percent
    /// of its height, each seed others; from there any seed climbs to the same top.
    /// @param reach  of the first step; infinity: half of the face
    [[nodiscard]] Top climb(const Sample& sample, double squared, double reach) const {
        constexpr int kRounds = 10;
        const auto corners = from_.corners(sample.face);
        const double longest = std::max(
            {length(corners[1] - corners[0]), length(corners[2] - corners[1]), length(corners[0] - corners[2])});
        std::array<double, 3> at{1 - sample.r1, sample.r1 * (1 - sample.r2), sample.r1 * sample.r2};
        std::uint32_t hint = ClosestPointIndex::kNoFace;
        double step = std::min(0.5, reach / longest);
        Top top{squared, sample.point};
        for (int round = 0; round < kRounds; ++round) {
            const std::array<double, 3> from = at;
            bool up = false;
            for (std::size_t corner = 0; corner < 3; ++corner)
                for (const double way : {step, -step}) {
                    std::array<double, 3> to = from;
                    for (std::size_t k = 0; k < 3; ++k) to[k] += way * ((k == corner ? 1.0 : 0.0) - from[k]);
                    for (double& b : to) b = std::max(b, 0.0);
                    const double sum = to[0] + to[1] + to[2];
                    for (double& b : to) b /= sum;
                    const Vec3d point = corners[0] * to[0] + corners[1] * to[1] + corners[2] * to[2];
                    const ClosestPoint found = index_.query(point, hint);
                    hint = found.face;
                    const double d = found.distance / unit_;
                    if (d * d > top.squared) {
                        top = {d * d, point};
                        at = to;
                        up = true;
                    }
                }
            if (!up) step /= 2;
        }
        return top;
    }

    /// The highest place that is found uphill from the farthest samples.
    [[nodiscard]] Top highest(std::span<const Sample> samples, std::span<const double> squared, std::size_t most,
                              double reach = kInfinity) const {
        const std::vector<std::uint32_t> far = farthest(samples, squared, most);
        std::vector<Top> tops(far.size());
        tbb::parallel_for(std::size_t{0}, far.size(),
                          [&](std::size_t k) { tops[k] = climb(samples[far[k]], squared[far[k]], reach); });
        Top out;
        for (const Top& top : tops) out.take_higher(top);
        return out;
    }

    void measure_block(std::span<const Sample> samples, std::span<double> out, std::size_t begin, std::size_t end,
                       bool angles) {
        std::uint32_t hint = ClosestPointIndex::kNoFace;
        for (std::size_t k = begin; k < end; ++k) {
            const Sample& s = samples[k];
            const ClosestPoint found = index_.query(s.point, hint);
            hint = found.face;
            const double d = found.distance / unit_;  // squares neither over- nor underflow in this unit
            out[k] = d * d;
            if (!angles || found.face == ClosestPointIndex::kNoFace) continue;
            const Vec3d here = normal_at(from_, s.face, {1 - s.r1, s.r1 * (1 - s.r2), s.r1 * s.r2}, use_corners_);
            const Vec3d there = normal_at(to_, found.face, found.barycentric, use_corners_);
            if (here == Vec3d{} || there == Vec3d{}) continue;
            const Vec3d flat = use_corners_ ? normal_at(to_, found.face, found.barycentric, false) : there;
            const Vec3d bumped = *shading_ ? (*shading_)(found.face, found.barycentric) : there;
            const double stored = angle_to(here, there);
            const double face = flat == Vec3d{} ? stored : angle_to(here, flat);
            const double bump = bumped == Vec3d{} ? stored : angle_to(here, bumped);
            angles_squared_[k] = {stored * stored, face * face, bump * bump};
        }
    }

    /// Across the seam of a surface with one side normals are opposite: there the lines count.
    [[nodiscard]] double angle_to(const Vec3d& here, const Vec3d& there) const {
        const double angle = angle_degrees(here, there);
        return from_.points.empty() ? angle : std::min(angle, 180 - angle);
    }

    const TriMesh& from_;
    const TriMesh& to_;
    const ClosestPointIndex& index_;
    double unit_;
    bool with_normals_, use_corners_;
    const std::function<Vec3d(std::uint32_t, const double (&)[3])>* shading_ = nullptr;
    std::vector<Angles> angles_squared_;
};

/// Bounding-box diagonal of the vertices that usable faces name. @throws model::Error kNoFaces if there are none
double diagonal_of(const TriMesh& mesh, const char* name) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Vec3d low{kInfinity, kInfinity, kInfinity}, high = -low;
    for (const Face& f : mesh.faces) {
        if (!usable(mesh, f)) continue;
        for (const std::uint32_t v : f)
            for (int k = 0; k < 3; ++k) {
                low[k] = std::min(low[k], mesh.positions[v][k]);
                high[k] = std::max(high[k], mesh.positions[v][k]);
            }
    }
    if (!is_finite(low))
        throw model::Error(model::codes::kNoFaces, std::string("nothing to measure: the ") + name + " has " +
                                                       std::to_string(mesh.faces.size()) +
                                                       " faces, none with finite corners");
    const Vec3d size = high - low;
    return math::hypot(size.x, size.y, size.z);
}
}  // namespace

double SurfaceError::psnr() const {
    constexpr double kCap = 300;  // dB
    if (!(rms > 0)) return kCap;
    if (!(diagonal > 0)) return 0;
    return std::min(kCap, 20 * math::log10(diagonal / rms));
}

std::uint64_t surface_samples(const TriMesh& source, const TriMesh& map, std::uint64_t most) {
    return std::min(most, std::max(kLeastSurfaceSamples, kSamplesPerFace * (source.faces.size() + map.faces.size())));
}

SurfaceError measure_surface_error(const TriMesh& source, const TriMesh& map, const SurfaceErrorOptions& asked,
                                   const model::Progress& progress) {
    SurfaceErrorOptions options = asked;
    if (!options.samples) options.samples = surface_samples(source, map);
    SurfaceError out;
    out.diagonal = diagonal_of(source, "source");
    const double map_diagonal = diagonal_of(map, "map");
    const double unit = std::max({out.diagonal, map_diagonal, std::numeric_limits<double>::min()});

    OneSided forward, backward;
    {
        const ClosestPointIndex index(map.positions, map.faces);
        forward = Direction(source, map, index, unit, true).measure(options, progress, 0, 0.5);
    }
    {
        std::optional<ClosestPointIndex> own;
        const ClosestPointIndex& index =
            options.source_index != nullptr ? *options.source_index : own.emplace(source.positions, source.faces);
        backward = Direction(map, source, index, unit, false).measure(options, progress, 0.5, 1);
    }
    out.rms_forward = forward.rms;
    out.rms_backward = backward.rms;
    out.rms = std::max(forward.rms, backward.rms);
    out.hausdorff_forward = forward.hausdorff;
    out.hausdorff_backward = backward.hausdorff;
    out.hausdorff = std::max(forward.hausdorff, backward.hausdorff);
    out.hausdorff_at = (forward.hausdorff < backward.hausdorff ? backward : forward).hausdorff_at;
    out.normal_rms_degrees = forward.normals;
    out.normal_rms_face_degrees = forward.face_normals;
    out.normal_rms_bump_degrees = forward.bump_normals;
    out.samples = forward.samples + backward.samples;
    return out;
}

}  // namespace dgm::bake
