// SPDX-License-Identifier: MIT
// libdgm/src/surface/normals.cpp
// Area vectors over the welded ring (docs/methods.md section 5).
//
// Inside the grid the ring is a closed polygon and rows.h does many at a time in float. At borders and seams, and where
// float would not do, ring_normal() sums triangles in double, copies in ascending order: every copy of a class gets the
// same bits (the opposite ones where it is reversed), and no coordinate that fits a float overflows.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "surface/surface.h"

namespace dgm::detail {
namespace {
struct Sum {
    double x = 0, y = 0, z = 0;
    void add_triangle(Vec3 a, Vec3 b, Vec3 c) noexcept {
        const double ux = double{b.x} - a.x, uy = double{b.y} - a.y, uz = double{b.z} - a.z;
        const double vx = double{c.x} - a.x, vy = double{c.y} - a.y, vz = double{c.z} - a.z;
        x += uy * vz - uz * vy;
        y += uz * vx - ux * vz;
        z += ux * vy - uy * vx;
    }
};

template <class Visit>
void each_triangle_of_quad(const Surface& s, std::uint32_t i, std::uint32_t j, std::uint32_t sample,
                           Visit visit) noexcept {
    if (!s.tables.has_quad(i, j)) return;
    for (const auto& f : quad_triangles(i, j, s.tables.cols, s.tables.diagonal(i, j)))
        if (f[0] == sample || f[1] == sample || f[2] == sample) visit(f.data());
}

/// Triangles around one copy.
template <class Visit>
void each_triangle(const Surface& s, std::uint32_t sample, Visit visit) noexcept {
    const ChartTables& t = s.tables;
    if (sample < t.grid) {
        const std::uint32_t i = sample / t.cols, j = sample % t.cols;
        if (i > 0 && j > 0) each_triangle_of_quad(s, i - 1, j - 1, sample, visit);
        if (i > 0 && j + 1 < t.cols) each_triangle_of_quad(s, i - 1, j, sample, visit);
        if (i + 1 < t.rows && j > 0) each_triangle_of_quad(s, i, j - 1, sample, visit);
        if (i + 1 < t.rows && j + 1 < t.cols) each_triangle_of_quad(s, i, j, sample, visit);
    }
    if (s.face_start.empty()) return;
    for (std::uint32_t k = s.face_start[sample]; k < s.face_start[sample + 1]; ++k)
        visit(s.faces.data() + 3 * std::size_t{s.face_of[k]});
}

/// Around all copies, in ascending order, as seen from the side of `sample`.
template <class Visit>
void each_triangle_welded(const Surface& s, std::uint32_t sample, Visit visit) noexcept {
    const std::uint32_t id = s.class_id(sample);
    const std::span<const std::uint32_t> copies = id == kNone ? std::span(&sample, 1) : s.members(id);
    for (const std::uint32_t copy : copies) {
        const bool turned = s.is_reversed(copy) != s.is_reversed(sample);
        each_triangle(s, copy, [&](const std::uint32_t* f) {
            const std::uint32_t face[3] = {f[0], f[turned ? 2 : 1], f[turned ? 1 : 2]};
            visit(face);
        });
    }
}
}  // namespace

Vec3 ring_normal(const Surface& s, const ConstPlanes& shape, std::uint32_t sample) noexcept {
    Sum sum;
    each_triangle_welded(s, sample, [&](const std::uint32_t* f) {
        sum.add_triangle(Surface::at(shape, f[0]), Surface::at(shape, f[1]), Surface::at(shape, f[2]));
    });
    const double length = std::sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z);
    if (!(length > 0) || !std::isfinite(length)) return {};
    return {static_cast<float>(sum.x / length), static_cast<float>(sum.y / length), static_cast<float>(sum.z / length)};
}

RingForm ring_form(const Surface& s, const ConstPlanes& shape, const float* weight, std::uint32_t sample) noexcept {
    Sum area, slope;
    each_triangle_welded(s, sample, [&](const std::uint32_t* f) {
        const Vec3 a = Surface::at(shape, f[0]), b = Surface::at(shape, f[1]), c = Surface::at(shape, f[2]);
        area.add_triangle(a, b, c);
        const double wu = double{weight[f[1]]} - weight[f[0]], wv = double{weight[f[2]]} - weight[f[0]];
        slope.x += wu * (double{c.x} - a.x) - wv * (double{b.x} - a.x);
        slope.y += wu * (double{c.y} - a.y) - wv * (double{b.y} - a.y);
        slope.z += wu * (double{c.z} - a.z) - wv * (double{b.z} - a.z);
    });
    return {{area.x, area.y, area.z, slope.x, slope.y, slope.z}};
}

void measure_roughness(Surface& s) noexcept {
    const ConstPlanes rest = Surface::fixed(s.rest);
    for (std::uint32_t k = 0; k < s.total(); ++k) {
        const std::uint32_t id = s.class_id(k);
        if (!s.usable(k) || (id != kNone && s.members(id)[0] != k)) continue;
        const Vec3 n = Surface::at(s.rest_normal, k);
        double square = 0, area = 0;
        each_triangle_welded(s, k, [&](const std::uint32_t* f) {
            Sum face;
            face.add_triangle(Surface::at(rest, f[0]), Surface::at(rest, f[1]), Surface::at(rest, f[2]));
            const double length = std::sqrt(face.x * face.x + face.y * face.y + face.z * face.z);
            if (!(length > 0) || !std::isfinite(length)) return;
            const double x = face.x / length - n.x, y = face.y / length - n.y, z = face.z / length - n.z;
            square += (x * x + y * y + z * z) * length;
            area += length;
        });
        s.rough[k] = area > 0 ? static_cast<float>(square / area) : 0;
        if (id == kNone) continue;
        for (const std::uint32_t copy : s.members(id)) s.rough[copy] = s.rough[k];
    }
}

Result<void> build_rings(Surface& s) noexcept {
    const ChartTables& t = s.tables;
    if (!s.ring.allocate(s.allocator, std::uint64_t{t.grid} + 16))
        return Error{ErrorCode::OutOfMemory, kNoOffset, "no memory for the rings"};
    s.uniform = true;
    double area = 0;
    std::size_t quads = 0;
    for (std::uint32_t i = 0; i + 1 < t.rows; ++i)
        for (std::uint32_t j = 0; j + 1 < t.cols; ++j) {
            s.uniform = s.uniform && t.diagonal(i, j) == 0;
            if (!t.has_quad(i, j)) continue;
            Sum sum;
            for (const auto& f : quad_triangles(i, j, t.cols, t.diagonal(i, j)))
                sum.add_triangle(Surface::at(s.rest, f[0]), Surface::at(s.rest, f[1]), Surface::at(s.rest, f[2]));
            area += std::sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z) / 2;
            ++quads;
        }
    for (std::uint32_t i = 0; i < t.rows; ++i)
        for (std::uint32_t j = 0; j < t.cols; ++j) {
            std::uint8_t& ring = s.ring[std::size_t{i} * t.cols + j];
            ring = kRingIrregular;
            if (i == 0 || j == 0 || i + 1 == t.rows || j + 1 == t.cols) continue;
            if (!t.has_quad(i, j) || !t.has_quad(i, j - 1) || !t.has_quad(i - 1, j) || !t.has_quad(i - 1, j - 1))
                continue;
            ring = static_cast<std::uint8_t>((t.diagonal(i, j) == 0 ? 1 : 0) | (t.diagonal(i - 1, j) == 1 ? 2 : 0) |
                                             (t.diagonal(i - 1, j - 1) == 0 ? 4 : 0) |
                                             (t.diagonal(i, j - 1) == 1 ? 8 : 0));
        }
    const auto irregular = [&](std::uint32_t sample) {
        if (sample < t.grid) s.ring[sample] |= kRingIrregular;
    };
    for (const std::uint32_t sample : s.class_members) irregular(sample);
    for (const std::uint32_t sample : s.faces) irregular(sample);
    s.any_face = quads != 0 || !s.faces.empty();
    const double mean = quads == 0 ? 0 : area / static_cast<double>(quads);
    s.normals_of = choose_normals(*s.rows_of, s.uniform ? nullptr : s.ring.data(), 1);
    if (!(mean > 0) || !std::isfinite(mean)) return {};
    s.mean_step = std::max(static_cast<float>(std::sqrt(mean)), kMinStep);  // at most 2e18: positions are bounded
    // Squares of area vectors shall lie amid the range of float. 1 is quickest.
    if (mean < 1e-4 || mean > 1e4) {
        const int power = std::clamp(-std::ilogb(mean), -120, 120);
        s.normal_scale = static_cast<float>(std::ldexp(1.0, power));
        s.normals_of = choose_normals(*s.rows_of, s.uniform ? nullptr : s.ring.data(), s.normal_scale);
    }
    return {};
}

namespace {
NormalJob job_of(const Surface& s, const Rect& rect, const ConstPlanes& at, const Planes& out) noexcept {
    return {rect, s.tables.cols, at, out, s.uniform ? nullptr : s.ring.data(), s.normal_scale};
}

void put(Surface& s, std::uint32_t sample, Vec3 n) noexcept {
    const Vec3 old = Surface::at(s.normal, sample);
    if (std::memcmp(&old, &n, sizeof n) == 0) return;
    s.changes.note_sample(sample);
    s.normal.x[sample] = n.x;
    s.normal.y[sample] = n.y;
    s.normal.z[sample] = n.z;
}

void put_irregular(Surface& s, std::uint32_t sample) noexcept {
    if (!s.usable(sample)) return put(s, sample, {});
    const Vec3 n = ring_normal(s, Surface::fixed(s.now), sample);
    const std::uint32_t id = s.class_id(sample);
    if (id == kNone) return put(s, sample, n);
    for (const std::uint32_t copy : s.members(id))
        put(s, copy, s.is_reversed(copy) != s.is_reversed(sample) ? Vec3{-n.x, -n.y, -n.z} : n);
}

/// A sample of the grid's border, or beside a free border: its own normal and those of its border faces.
void put_around(Surface& s, std::uint32_t sample) noexcept {
    put_irregular(s, sample);
    if (s.face_start.empty()) return;
    for (std::uint32_t k = s.face_start[sample]; k < s.face_start[sample + 1]; ++k)
        for (std::uint32_t c = 0; c < 3; ++c) {
            const std::uint32_t other = s.faces[3 * std::size_t{s.face_of[k]} + c];
            if (other != sample) put_irregular(s, other);
        }
}

void update_rect(Surface& s, const Rect& moved) noexcept {
    const ChartTables& t = s.tables;
    const Rect around{moved.i0 == 0 ? 0 : moved.i0 - 1, std::min(moved.i1 + 1, t.rows - 1),
                      moved.j0 == 0 ? 0 : moved.j0 - 1, std::min(moved.j1 + 1, t.cols - 1)};
    const Rect inner{std::max(around.i0, 1u), std::min(around.i1, t.rows - 2), std::max(around.j0, 1u),
                     std::min(around.j1, t.cols - 2)};
    s.note(around);
    if (!inner.empty() && !s.normals_of(job_of(s, inner, Surface::fixed(s.now), s.normal)))
        for (std::uint32_t i = inner.i0; i <= inner.i1; ++i)
            for (std::uint32_t k = i * t.cols + inner.j0; k <= i * t.cols + inner.j1; ++k)
                if (s.normal.x[k] == 0 && s.normal.y[k] == 0 && s.normal.z[k] == 0) put_irregular(s, k);
    if (t.free_domain) {
        for (std::uint32_t i = around.i0; i <= around.i1; ++i)
            for (std::uint32_t k = i * t.cols + around.j0; k <= i * t.cols + around.j1; ++k)
                if ((s.ring[k] & kRingIrregular) != 0) put_around(s, k);
        return;
    }
    const auto row = [&](std::uint32_t i) {
        for (std::uint32_t k = i * t.cols + around.j0; k <= i * t.cols + around.j1; ++k) put_irregular(s, k);
    };
    const auto column = [&](std::uint32_t j) {
        for (std::uint32_t i = around.i0; i <= around.i1; ++i) put_irregular(s, i * t.cols + j);
    };
    if (around.i0 == 0) row(0);
    if (around.i1 == t.rows - 1) row(t.rows - 1);
    if (around.j0 == 0) column(0);
    if (around.j1 == t.cols - 1) column(t.cols - 1);
}
}  // namespace

Vec3 sample_normal(const Surface& s, const ConstPlanes& shape, std::uint32_t sample) noexcept {
    if (!s.usable(sample)) return {};
    if (sample >= s.tables.grid || (s.ring[sample] & kRingIrregular) != 0) return ring_normal(s, shape, sample);
    float x = 0, y = 0, z = 0;
    return normals_inside(s, shape, sample, 1, {&x, &y, &z}) ? Vec3{x, y, z} : ring_normal(s, shape, sample);
}

bool normals_inside(const Surface& s, const ConstPlanes& shape, std::uint32_t first, std::uint32_t count,
                    const Planes& to) noexcept {
    // The kernel writes at out + sample: lead it to these.
    const ConstPlanes here{shape.x + first, shape.y + first, shape.z + first};
    NormalJob job = job_of(s, Rect{0, 0, 0, count - 1}, here, to);
    if (job.ring != nullptr) job.ring += first;
    return s.normals_of(job);
}

void update_normals(Surface& s) noexcept {
    for (std::uint32_t k = 0; k < s.normal_dirty.count; ++k) update_rect(s, s.normal_dirty.rects[k]);
    if (s.normal_dirty.border_low <= s.normal_dirty.border_high)
        for (std::uint32_t b = s.normal_dirty.border_low; b <= s.normal_dirty.border_high; ++b) put_around(s, b);
    s.normal_dirty.clear();
}

}  // namespace dgm::detail
