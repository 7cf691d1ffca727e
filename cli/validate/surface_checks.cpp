// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/surface_checks.cpp
#include "validate/surface_checks.h"

#include <dgm/octahedral.h>

#include <cmath>
#include <cstring>

#include "math/portable.h"
#include "model/codes.h"
#include "model/element.h"
#include "validate/side_checks.h"
#include "validate/surface.h"
#include "validate/table_checks.h"

namespace dgm::validate {
namespace {
using bake::Reconstruction;
using bake::Topology;
using model::Chart;
using model::element;
using model::Face;
using model::Layer;
using model::Vec2d;
using model::Vec3d;
namespace codes = model::codes;

/// True if samples a and b hold the same bytes in the grid layer or, beyond the grid, in its border twin. Where one
/// stands in each, the decoded values decide (`same_value`).
bool same_sample(const Surface& s, const Layer& grid_layer, const Layer* border_layer, std::size_t sample_bytes,
                 std::size_t a, std::size_t b, bool same_value) {
    const std::size_t grid = std::size_t{s.m} * s.n;
    if ((a < grid) != (b < grid)) return same_value;
    const Layer* layer = a < grid ? &grid_layer : border_layer;
    if (layer == nullptr) return true;
    const std::size_t base = a < grid ? 0 : grid;
    const std::size_t bytes = layer->type == grid_layer.type ? sample_bytes
                                                             : sample_bytes / layout::element_size(grid_layer.type) *
                                                                   layout::element_size(layer->type);
    return std::memcmp(layer->bytes.data() + (a - base) * bytes, layer->bytes.data() + (b - base) * bytes, bytes) == 0;
}

void check_seams(const Surface& s, FindingList& findings) {
    const Layer& geometry = *s.chart.find("geometry");
    const Layer* normal = s.chart.find("normal");
    const std::vector<Vec3d>& positions = s.reconstruction.mesh.positions;
    std::size_t torn = 0, first_torn = 0, bent = 0, first_bent = 0;
    const auto& weld = s.reconstruction.weld;
    for (std::size_t copy = 0; copy < weld.size(); ++copy) {
        const std::size_t rep = weld[copy];
        if (rep == copy) continue;
        if (!same_sample(s, geometry, s.chart.find("border_geometry"), 3 * layout::element_size(geometry.type), rep,
                         copy, positions[rep] == positions[copy]) &&
            torn++ == 0)
            first_torn = copy;
        const bool reversed = !s.reconstruction.reversed.empty() && s.reconstruction.reversed[copy] != 0;
        if (normal != nullptr &&
            !(reversed ? opposite_normals(s, rep, copy)
                       : same_sample(s, *normal, s.chart.find("border_normal"), 2 * sizeof(std::int16_t), rep, copy,
                                     true)) &&
            bent++ == 0)
            first_bent = copy;
    }
    if (torn > 0)
        findings.error(codes::kSeamGap, s.path("geometry"),
                       fmt::format("{} differs from its mate, {}; {} of the seam's copies do",
                                   s.sample_text(first_torn), s.sample_text(weld[first_torn]), torn),
                       {s.reconstruction.seam_gap, 0});
    if (bent > 0)
        findings.warning(codes::kSeamGap, s.path("normal"),
                         fmt::format("the normal of {} differs from that of its mate, {}; {} of the seam's copies do",
                                     s.sample_text(first_bent), s.sample_text(weld[first_bent]), bent));
}

/// Strip faces and seam pairs may name samples of the surface only.
void check_masked_samples(const Surface& s, FindingList& findings) {
    if (s.mask == nullptr) return;
    const std::size_t grid = std::size_t{s.m} * s.n;
    const auto check = [&](const char* name, const model::Code& code) {
        const Layer* layer = s.chart.find(name);
        if (layer == nullptr) return;
        std::size_t bad = 0, first = 0;
        const std::size_t count = layer->bytes.size() / sizeof(std::uint32_t);
        for (std::size_t k = 0; k < count; ++k) {
            const auto sample = element<std::uint32_t>(*layer, k);
            if (sample < grid && element<std::uint8_t>(*s.mask, sample) == 0 && bad++ == 0) first = k;
        }
        if (bad > 0)
            findings.error(code, s.path(name) + element_text(layer->shape, first),
                           fmt::format("{} is not on the surface; so are {} of {} entries",
                                       s.sample_text(element<std::uint32_t>(*layer, first)), bad, count));
    };
    check("border_faces", codes::kBadValue);
    check("seams", codes::kBadSeamTable);
}

/// Twice the area of all faces, and of each vertex the sum of its faces' normals times twice their area.
struct FaceSums {
    double area = 0;
    std::vector<Vec3d> normals;
};

/// Faces that have shrunk to a line or a point still draw, but have no normal.
FaceSums check_areas(const Surface& s, FindingList& findings) {
    FaceSums sums{0, std::vector<Vec3d>(s.local.size())};
    std::size_t flat = 0;
    for (const Face& f : s.reconstruction.mesh.faces) {
        const Vec3d normal = cross(s.local[f[1]] - s.local[f[0]], s.local[f[2]] - s.local[f[0]]);
        if (normal == Vec3d{}) ++flat;
        sums.area += length(normal);
        for (const std::uint32_t v : f) sums.normals[v] = sums.normals[v] + normal;
    }
    if (flat > 0)
        findings.warning(codes::kBadTopology, s.path("geometry"),
                         fmt::format("{} of {} faces have no area", flat, s.reconstruction.mesh.faces.size()),
                         {static_cast<double>(flat), 0});
    return sums;
}

/// Normals may bend away from the faces they are drawn on, but not most of them.
void check_normals(const Surface& s, const Layer& normal, const FaceSums& sums, FindingList& findings) {
    std::size_t against = 0, counted = 0, first = 0;
    for (std::size_t k = 0; k < s.grid(); ++k) {
        if (s.in_face[k] == 0) continue;
        const auto code = [&](std::size_t c) {
            return static_cast<std::int16_t>(element<std::uint16_t>(normal, 2 * k + c));
        };
        const auto stored = dgm::decode_octahedral(code(0), code(1));
        ++counted;
        if (dot(sums.normals[k], Vec3d{stored[0], stored[1], stored[2]}) < 0 && against++ == 0) first = k;
    }
    if (2 * against > counted)
        findings.warning(
            codes::kBadNormal, s.path("normal") + element_text(normal.shape, 2 * first),
            fmt::format("{} of {} normals look against the faces around them, here first", against, counted),
            {static_cast<double>(against), 0.5 * static_cast<double>(counted)});
}

/// Samples that cost memory and are never drawn.
void check_loose_samples(const Surface& s, FindingList& findings) {
    std::size_t loose = 0, first = 0;
    for (std::size_t k = 0; k < s.local.size(); ++k) {
        const bool on_surface = k >= s.grid() || s.on_surface(k / s.n, k % s.n);
        if (on_surface && s.in_face[k] == 0 && loose++ == 0) first = k;
    }
    if (loose > 0)
        findings.warning(codes::kLooseSamples, s.path(first < s.grid() ? "mask" : "border_geometry"),
                         fmt::format("{} is in no triangle; of such samples there are {}", s.sample_text(first), loose),
                         {static_cast<double>(loose), 0});
}

/// The strip winds like the lattice, counter-clockwise in (u, v). Slivers may turn by the rounding to float.
void check_strip(const Surface& s, FindingList& findings) {
    const Layer* faces = s.chart.find("border_faces");
    const Layer* border_uv = s.chart.find("border_uv");
    if (faces == nullptr || border_uv == nullptr) return;
    constexpr double kRounding = 4 * 0x1p-24;
    const auto uv_of = [&](std::size_t k) {
        if (k < s.grid())
            return Vec2d{static_cast<double>(k / s.n) / (s.m - 1), static_cast<double>(k % s.n) / (s.n - 1)};
        return Vec2d{element<float>(*border_uv, 2 * (k - s.grid())),
                     element<float>(*border_uv, 2 * (k - s.grid()) + 1)};
    };
    std::size_t flipped = 0, first = 0;
    double worst = 0;
    for (std::size_t t = 0; t < faces->shape[0]; ++t) {
        const Vec2d a = uv_of(element<std::uint32_t>(*faces, 3 * t)),
                    b = uv_of(element<std::uint32_t>(*faces, 3 * t + 1)),
                    c = uv_of(element<std::uint32_t>(*faces, 3 * t + 2));
        const Vec2d e = b - a, f = c - a;
        const double area = cross(e, f), slack = kRounding * (math::hypot(e.x, e.y) + math::hypot(f.x, f.y));
        if (area >= -slack) continue;
        if (flipped++ == 0) first = t;
        worst = std::min(worst, area / 2);
    }
    // Space is not folded there, as the topology has shown: only lookups by (u, v) are off by so much.
    if (flipped > 0)
        findings.warning(
            codes::kFlippedFaces, s.path("border_faces") + fmt::format("[{}]", first),
            fmt::format("{} of the strip's {} triangles are turned over in (u, v), here first; measured is "
                        "the worst area",
                        flipped, faces->shape[0]),
            {worst, 0});
}

/// A cut opens the surface along the border of the square: inside it, no two samples are one point.
void check_seam_places(const Surface& s, FindingList& findings) {
    const Layer* seams = s.chart.find("seams");
    if (seams == nullptr || s.chart.domain != model::Domain::kSquare) return;
    std::size_t inside = 0, first = 0;
    const std::size_t count = 2 * seams->shape[0];
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t sample = element<std::uint32_t>(*seams, k), i = sample / s.n, j = sample % s.n;
        const bool border = i == 0 || j == 0 || i + 1 == s.m || j + 1 == s.n;
        if (!border && inside++ == 0) first = k;
    }
    if (inside > 0)
        findings.error(codes::kBadSeamTable, s.path("seams") + element_text(seams->shape, first),
                       fmt::format("{} is not on the border of the square; so are {} of {} entries",
                                   s.sample_text(element<std::uint32_t>(*seams, first)), inside, count));
}

/// True if the surface is the whole grid, and only samples on its border are joined.
bool is_plain_grid(const Surface& s) {
    if (s.chart.domain != model::Domain::kSquare || s.m < 4 || s.n < 4) return false;
    const auto& weld = s.reconstruction.weld;
    for (std::size_t i = 1; i + 1 < s.m; ++i)
        for (std::size_t k = sample_index(i, 1, s.n); k < sample_index(i, s.n - 1, s.n); ++k)
            if (weld[k] != k) return false;
    return true;
}

/// Topology of the welded surface. Inside the border a plain grid is a disk, and closing a loop with a disk changes
/// neither components nor genus: the quads along the border suffice.
Topology welded_topology(const Surface& s) {
    const std::vector<Face>& faces = s.reconstruction.welded_faces;
    if (!is_plain_grid(s)) return bake::measure_topology(s.local.size(), faces);
    std::vector<Face> ring;
    for (std::size_t i = 0; i + 1 < s.m; ++i) {
        const bool whole_row = i == 0 || i + 2 == s.m;
        for (std::size_t j = 0; j + 1 < s.n; j += whole_row ? 1 : s.n - 2) {
            const std::size_t quad = i * (s.n - 1) + j;
            ring.push_back(faces[2 * quad]);
            ring.push_back(faces[2 * quad + 1]);
        }
    }
    Topology t = bake::measure_topology(s.local.size(), ring);
    if (!t.manifold || t.degenerate_faces > 0) return bake::measure_topology(s.local.size(), faces);
    if (t.boundary_loops > 0) --t.boundary_loops;  // the one that the disk closes
    return t;
}

Topology check_topology(const Surface& s, FindingList& findings) {
    const Topology t = welded_topology(s);
    const std::string place = s.path("geometry");
    if (s.reconstruction.mesh.faces.empty())
        findings.error(codes::kBadTopology, place, "the reconstruction has no faces");
    if (t.degenerate_faces > 0)
        findings.error(codes::kBadTopology, place, "faces name one surface point twice",
                       {static_cast<double>(t.degenerate_faces), 0});
    if (!t.manifold)
        findings.error(codes::kBadTopology, place, "an edge has more than two faces, or a vertex more than one fan");
    else
        check_sides(s, t.oriented, findings);
    return t;
}

void check_bounds(const Surface& s, FindingList& findings) {
    const auto& b = s.chart.bbox;
    const Vec3d offset{s.chart.offset[0], s.chart.offset[1], s.chart.offset[2]};
    const Box stored{Vec3d{b[0], b[1], b[2]} - offset, Vec3d{b[3], b[4], b[5]} - offset};
    const double slack =
        kFloatSlack * s.bounds.diagonal() + 4 * std::numeric_limits<double>::epsilon() * length(offset);
    const double off = std::max(stored.protrusion(s.bounds), s.bounds.protrusion(stored));
    if (!(off <= slack))
        findings.error(codes::kBadBounds, s.path(""), "bbox is not the box of the reconstruction", {off, slack});
}

}  // namespace

Topology check_surface(const Chart& chart, std::size_t chart_index, const Reconstruction& reconstruction,
                       FindingList& findings) {
    const Surface s(chart, chart_index, reconstruction);
    const Topology topology = check_topology(s, findings);
    check_masked_samples(s, findings);
    check_seam_places(s, findings);
    check_seams(s, findings);
    check_loose_samples(s, findings);
    check_strip(s, findings);
    if (!s.finite) return topology;  // reported with the layer; distances would only repeat it
    const FaceSums sums = check_areas(s, findings);
    check_bounds(s, findings);
    if (const Layer* normal = chart.find("normal")) check_normals(s, *normal, sums, findings);
    check_tables(s, sums.area / 2, findings);
    return topology;
}

}  // namespace dgm::validate
