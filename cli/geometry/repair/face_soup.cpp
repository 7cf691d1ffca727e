// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/face_soup.cpp
#include "geometry/repair/face_soup.h"

#include <cmath>
#include <limits>

#include "model/codes.h"

namespace dgm::bake {
namespace {

using model::Error;
namespace codes = model::codes;

template <class Keep>
std::uint64_t keep_if(FaceSoup& soup, Keep keep) {
    std::size_t n = 0;
    for (std::size_t f = 0; f < soup.faces.size(); ++f) {
        if (!keep(f)) continue;
        soup.faces[n] = soup.faces[f];
        soup.source_face[n] = soup.source_face[f];
        ++n;
    }
    const std::uint64_t dropped = soup.faces.size() - n;
    soup.faces.resize(n);
    soup.source_face.resize(n);
    return dropped;
}

std::vector<bool> used_vertices(const FaceSoup& soup) {
    std::vector<bool> used(soup.positions.size(), false);
    for (const Face& face : soup.faces)
        for (const std::uint32_t v : face) used[v] = true;
    return used;
}

}  // namespace

FaceSoup usable_faces(const TriMesh& source, RepairCounts& counts) {
    FaceSoup soup;
    std::uint64_t not_finite = 0, out_of_range = 0;
    for (std::uint32_t f = 0; f < source.faces.size(); ++f) {
        bool in_range = true, finite = true;
        for (const std::uint32_t v : source.faces[f]) {
            if (v >= source.positions.size()) {
                in_range = false;
            } else if (!is_finite(source.positions[v])) {
                finite = false;
            }
        }
        if (!in_range) {
            ++out_of_range;
        } else if (!finite) {
            ++not_finite;
        } else {
            soup.faces.push_back(source.faces[f]);
            soup.source_face.push_back(f);
        }
    }
    add_count(counts, "faces with a corner out of range dropped", out_of_range);
    add_count(counts, "faces with a non-finite corner dropped", not_finite);
    if (soup.faces.empty())
        throw Error(codes::kNoFaces, source.faces.empty() ? "the file holds no faces"
                                     : not_finite > 0     ? "every face has a NaN or infinite corner"
                                                          : "no face refers to existing vertices");
    soup.positions = source.positions;
    return soup;
}

Frame normalise(FaceSoup& soup, RepairCounts& counts) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    Vec3d lo{inf, inf, inf}, hi{-inf, -inf, -inf};
    const std::vector<bool> used = used_vertices(soup);
    std::uint64_t unused = 0;
    for (std::size_t v = 0; v < used.size(); ++v) {
        if (!used[v]) {
            ++unused;
            continue;
        }
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], soup.positions[v][k]);
            hi[k] = std::max(hi[k], soup.positions[v][k]);
        }
    }
    add_count(counts, "unused vertices left out", unused);
    const Vec3d size = hi - lo;
    const double extent = std::max({size.x, size.y, size.z});
    if (!(extent > 0))
        throw Error(codes::kNoFaces, "all vertices coincide")
            .with_hint("look at the mesh in a modeller: it is one point");
    if (!std::isfinite(extent))
        throw Error(codes::kScaleOutOfRange, "the bounding box overflows double precision; supported: 1e-15 to 1e15");
    Frame frame;
    frame.diagonal = extent * length(size / extent);  // in this order: 1e200 squared would overflow
    frame.centre = lo + size * 0.5;
    for (std::size_t v = 0; v < used.size(); ++v)
        soup.positions[v] = used[v] ? (soup.positions[v] - frame.centre) / frame.diagonal : Vec3d{};
    return frame;
}

void drop_repeated_corners(FaceSoup& soup, RepairCounts& counts) {
    add_count(counts, "faces that repeat a corner dropped", keep_if(soup, [&](std::size_t f) {
                  const Face& q = soup.faces[f];
                  return q[0] != q[1] && q[1] != q[2] && q[2] != q[0];
              }));
}

void drop_duplicate_faces(FaceSoup& soup, RepairCounts& counts) {
    std::vector<std::pair<Face, std::uint32_t>> sorted;
    sorted.reserve(soup.faces.size());
    for (std::uint32_t f = 0; f < soup.faces.size(); ++f) {
        Face q = soup.faces[f];
        std::sort(q.begin(), q.end());
        sorted.emplace_back(q, f);
    }
    std::sort(sorted.begin(), sorted.end());
    std::vector<bool> duplicate(soup.faces.size(), false);
    for (std::size_t k = 1; k < sorted.size(); ++k)
        if (sorted[k].first == sorted[k - 1].first) duplicate[sorted[k].second] = true;
    add_count(counts, "faces that stand twice dropped", keep_if(soup, [&](std::size_t f) { return !duplicate[f]; }));
}

}  // namespace dgm::bake
