// SPDX-License-Identifier: MIT
// libdgm/src/physics/coarse.cpp
// Physics on every k-th sample of a state, shown on all of them.
//
// A sample between coarse ones moves by  sum w (u + D (o + m / 2))  over the corners of its coarse quad: w their
// bilinear weights, u displacement and D its gradient at a corner, o from the bilinear point of the rest corners to the
// sample at rest, m from the corner to that point. So what lies between coarse samples at rest turns and stretches
// with them, and the second part bends the quads: with the same D everywhere it is 0 in the sum. A rigid motion is
// shown exactly, an affine map of a flat sheet too, and what has not moved to the bit.
//
// D of a triangle takes its edges and unit normal at rest to those now; a corner has the mean by area over the
// triangles around its class.
#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/physics_impl.h"

namespace dgm {
namespace detail {
namespace {

constexpr Error unsupported(const char* message) noexcept {
    return {ErrorCode::Unsupported, kNoOffset, message};
}
constexpr Error kNoMemory{ErrorCode::OutOfMemory, kNoOffset, "no memory for the coarse state"};

std::uint32_t coarse_count(std::uint32_t fine, std::uint32_t stride) noexcept {
    return (fine - 2) / stride + 2;
}
/// The last coarse row is the last fine one, whatever the stride.
std::uint32_t fine_of(std::uint32_t k, std::uint32_t fine, std::uint32_t stride) noexcept {
    return std::min(k * stride, fine - 1);
}

/// Layers of a coarse chart.
struct Layers {
    Array<float> geometry, deformation, contact;
    Array<std::uint8_t> diagonals;
    Array<std::uint32_t> seams;
};

double squared(const StateImpl& s, std::uint32_t a, std::uint32_t b) noexcept {
    const Double3 way = widen(StateImpl::at(s.rest, a)) - widen(StateImpl::at(s.rest, b));
    return dot(way, way);
}

// What runs once a state is cold: built small.

/// Coarse samples that are one point: chains that lead to the first of each.
struct Welds {
    Array<std::uint32_t> to;
    [[nodiscard]] std::uint32_t first(std::uint32_t k) const noexcept {
        while (to[k] != k) k = to[k];
        return k;
    }
    void join(std::uint32_t a, std::uint32_t b) noexcept {
        a = first(a);
        b = first(b);
        to[std::max(a, b)] = std::min(a, b);
    }
};

/// Where three or more sides of a seam meet between coarse samples, there would be a hole: the coarse samples beside
/// such a node move onto it.
[[gnu::cold]] void weld_node(const StateImpl& s, std::uint32_t stride, const ChartTables& t,
                             std::span<const std::uint32_t> members, Welds& welds, Array<float>& geometry) noexcept {
    const auto place = [&](std::uint32_t k, std::uint32_t fine) {
        return k + 1 == fine ? (fine - 2) / stride + 1 : k / stride;
    };
    std::uint32_t before = kNone;
    for (const std::uint32_t member : members) {
        const std::uint32_t i = member / s.tables.cols, j = member % s.tables.cols;
        const bool along_row = i == 0 || i + 1 == s.tables.rows;
        const std::uint32_t low = place(i, s.tables.rows) * t.cols + place(j, s.tables.cols);
        const std::uint32_t high = low + (along_row ? 1 : t.cols);
        welds.join(low, high);
        if (before != kNone) welds.join(before, low);
        before = low;
    }
    const Vec3 at = StateImpl::at(s.rest, members[0]);
    float* to = geometry.data() + 3 * std::size_t{welds.first(before)};
    to[0] = at.x;
    to[1] = at.y;
    to[2] = at.z;
}

/// Joins coarse samples as the classes of the state do, and lists the pairs. @return Unsupported: torn.
[[gnu::cold]] Result<void> take_seams(const StateImpl& s, std::uint32_t stride, const Array<std::uint32_t>& coarse_of,
                                      const ChartTables& t, Layers& to) noexcept {
    Welds welds;
    if (!welds.to.allocate(s.allocator, t.grid)) return kNoMemory;
    for (std::uint32_t k = 0; k < t.grid; ++k) welds.to[k] = k;
    // Nodes last: what they move is then one with its copies.
    for (const bool nodes : {false, true})
        for (std::uint32_t id = 0; id < s.class_count; ++id) {
            const auto members = s.members(id);
            std::uint32_t last = kNone;
            std::size_t found = 0;
            for (const std::uint32_t member : members) {
                const std::uint32_t c = coarse_of[member];
                if (c == kNone) continue;
                ++found;
                if (last != kNone) welds.join(last, c);
                last = c;
            }
            if (found != 0 && found != members.size())
                return unsupported("the seams of the map do not meet at this stride");
            if (nodes && found == 0 && members.size() > 2) weld_node(s, stride, t, members, welds, to.geometry);
        }
    std::size_t count = 0, at = 0;
    for (std::uint32_t k = 0; k < t.grid; ++k) count += welds.to[k] != k ? 2 : 0;
    if (!to.seams.allocate(s.allocator, count)) return kNoMemory;
    for (std::uint32_t k = 0; k < t.grid; ++k) {
        if (welds.to[k] == k) continue;
        const std::uint32_t first = welds.first(k);
        to.seams[at++] = first;
        to.seams[at++] = k;
        for (std::size_t c = 0; c < 3; ++c)
            to.geometry[3 * std::size_t{k} + c] = to.geometry[3 * std::size_t{first} + c];
    }
    return {};
}

[[gnu::cold]] Result<void> take_layers(const StateImpl& s, std::uint32_t stride, ChartTables& t, Layers& to) noexcept {
    const std::uint32_t n = s.tables.cols;
    const Allocator& a = s.allocator;
    Array<std::uint32_t> coarse_of;  // by fine sample
    if (!coarse_of.allocate(a, s.tables.grid, kNone) || !to.geometry.allocate(a, 3 * std::uint64_t{t.grid}) ||
        !to.diagonals.allocate(a, std::uint64_t{t.rows - 1} * (t.cols - 1)) ||
        (!s.stiffness.empty() && !to.deformation.allocate(a, 4 * std::uint64_t{t.grid})) ||
        (!s.mobility.empty() && !to.contact.allocate(a, 2 * std::uint64_t{t.grid})))
        return kNoMemory;
    for (std::uint32_t i = 0; i < t.rows; ++i)
        for (std::uint32_t j = 0; j < t.cols; ++j) {
            const std::uint32_t fi = fine_of(i, s.tables.rows, stride), fj = fine_of(j, n, stride), f = fi * n + fj;
            const std::size_t c = std::size_t{i} * t.cols + j;
            coarse_of[f] = static_cast<std::uint32_t>(c);
            to.geometry[3 * c] = s.rest.x[f];
            to.geometry[3 * c + 1] = s.rest.y[f];
            to.geometry[3 * c + 2] = s.rest.z[f];
            if (!s.stiffness.empty()) to.deformation[4 * c + 3] = s.stiffness[f];
            if (!s.mobility.empty()) to.contact[2 * c + 1] = s.mobility[f];
            if (i + 1 == t.rows || j + 1 == t.cols) continue;
            // The shorter diagonal; those of the map where its quads are the same.
            const std::uint32_t below = fine_of(i + 1, s.tables.rows, stride) * n, right = fine_of(j + 1, n, stride);
            const bool other = stride == 1 ? s.tables.diagonal(i, j) != 0
                                           : squared(s, below + fj, fi * n + right) < squared(s, f, below + right);
            to.diagonals[std::size_t{i} * (t.cols - 1) + j] = other ? 1 : 0;
        }
    if (auto r = take_seams(s, stride, coarse_of, t, to); !r) return r;
    t.geometry.f32 = to.geometry.data();
    t.diagonals = to.diagonals.data();
    t.deformation = to.deformation.data();
    t.contact = to.contact.data();
    t.seams = {to.seams.data(), to.seams.size()};
    if (s.material[0] > 0) t.material = {s.material, s.material[5] > 0 ? kMaterialValues : 1};
    return {};
}

Double3 rest_of(const StateImpl& s, std::uint32_t k) noexcept {
    return widen(StateImpl::at(s.rest, k));
}
Double3 now_of(const StateImpl& s, std::uint32_t k) noexcept {
    return widen(StateImpl::at(s.now, k));
}
Double3 unit(Double3 v) noexcept {
    const double l = std::sqrt(dot(v, v));
    return l > 0 ? (1 / l) * v : Double3{};
}
}  // namespace

/// A 3 x 3 matrix by columns.
struct Gradient3 {
    Double3 x, y, z;
};
Double3 operator*(const Gradient3& m, Double3 v) noexcept {
    return v.x * m.x + v.y * m.y + v.z * m.z;
}
struct DetailImpl {
    explicit DetailImpl(const Allocator& a) noexcept : allocator(a) {}
    Allocator allocator;
    std::uint32_t stride = 1, rows = 0, cols = 0, coarse_rows = 0, coarse_cols = 0;
    Array<double> area;         ///< of the triangles around a coarse class, by coarse sample
    Array<Gradient3> gradient;  ///< of the displacement, by coarse sample; at first members of classes

    [[nodiscard]] bool fits(const StateImpl& fine, const StateImpl& coarse) const noexcept {
        return fine.tables.rows == rows && fine.tables.cols == cols && coarse.tables.rows == coarse_rows &&
               coarse.tables.cols == coarse_cols;
    }
};

namespace {

/// f(corners) of both triangles of every quad.
template <class F>
void each_triangle(const StateImpl& s, F f) noexcept {
    const std::uint32_t n = s.tables.cols;
    for (std::uint32_t i = 0; i + 1 < s.tables.rows; ++i)
        for (std::uint32_t j = 0; j + 1 < n; ++j) {
            const std::uint32_t a = i * n + j, b = a + n, c = b + 1, d = a + 1;
            const bool other = s.tables.diagonal(i, j) != 0;
            const std::uint32_t one[3] = {a, b, other ? d : c}, two[3] = {other ? b : a, c, d};
            f(one);
            f(two);
        }
}

void measure_gradients(DetailImpl& d, const StateImpl& s) noexcept {
    for (Gradient3& g : d.gradient) g = {};
    each_triangle(s, [&](const std::uint32_t(&c)[3]) {
        const Double3 x = rest_of(s, c[0]), y = now_of(s, c[0]);
        const Double3 e1 = rest_of(s, c[1]) - x, e2 = rest_of(s, c[2]) - x;
        const Double3 way1 = (now_of(s, c[1]) - y) - e1, way2 = (now_of(s, c[2]) - y) - e2;
        const Double3 across = cross(e1, e2), normal = unit(across);
        const double doubled = std::sqrt(dot(across, across));
        if (!(doubled > 0)) return;
        const Double3 turned = unit(cross(e1 + way1, e2 + way2)) - normal;
        // Area times the gradient: the dual basis of the edges is (e2 x n, n x e1) over twice the area.
        const Double3 g1 = 0.5 * cross(e2, normal), g2 = 0.5 * cross(normal, e1), g3 = (0.5 * doubled) * normal;
        const auto column = [&](double a, double b, double n) { return a * way1 + b * way2 + n * turned; };
        const Gradient3 m{column(g1.x, g2.x, g3.x), column(g1.y, g2.y, g3.y), column(g1.z, g2.z, g3.z)};
        for (const std::uint32_t k : c) {
            Gradient3& to = d.gradient[s.representative(k)];
            to = {to.x + m.x, to.y + m.y, to.z + m.z};
        }
    });
    for (std::size_t k = 0; k < d.gradient.size(); ++k) {
        if (!(d.area[k] > 0)) continue;
        const double by = 1 / d.area[k];
        Gradient3& g = d.gradient[k];
        g = {by * g.x, by * g.y, by * g.z};
    }
}

/// Corners of the coarse interval around a fine row or column, and the weight of the second.
struct Interval {
    std::uint32_t low, high;
    double weight;
};
Interval interval(std::uint32_t k, std::uint32_t fine, std::uint32_t coarse, std::uint32_t stride) noexcept {
    const std::uint32_t low = std::min(k / stride, coarse - 2), from = low * stride;
    const double length = fine_of(low + 1, fine, stride) - from;
    return {low, low + 1, (k - from) / length};
}

Double3 displacement(const DetailImpl& d, const StateImpl& fine, const StateImpl& coarse, std::uint32_t i,
                     std::uint32_t j) noexcept {
    const Interval r = interval(i, d.rows, d.coarse_rows, d.stride), c = interval(j, d.cols, d.coarse_cols, d.stride);
    const std::uint32_t at[4] = {r.low * d.coarse_cols + c.low, r.low * d.coarse_cols + c.high,
                                 r.high * d.coarse_cols + c.low, r.high * d.coarse_cols + c.high};
    const double weight[4] = {(1 - r.weight) * (1 - c.weight), (1 - r.weight) * c.weight, r.weight * (1 - c.weight),
                              r.weight * c.weight};
    Double3 middle, sum;
    for (int k = 0; k < 4; ++k) middle = middle + weight[k] * rest_of(coarse, at[k]);
    const Double3 off = rest_of(fine, i * d.cols + j) - middle;
    for (int k = 0; k < 4; ++k) {
        if (weight[k] == 0) continue;
        const Double3 x = rest_of(coarse, at[k]);
        const Double3 way = off + 0.5 * (middle - x);
        sum = sum + weight[k] * ((now_of(coarse, at[k]) - x) + d.gradient[coarse.representative(at[k])] * way);
    }
    return sum;
}
}  // namespace
}  // namespace detail

[[gnu::cold]] Result<State> coarse_state(const State& fine, std::uint32_t stride,
                                         const StateOptions& options) noexcept {
    using namespace detail;
    const StateImpl& s = *fine.impl();
    if (stride < 1) return Error{ErrorCode::BadArgument, kNoOffset, "the stride is 0"};
    if (s.tables.free_domain) return unsupported("free domains have no coarse states");
    if (!s.reversed.empty()) return unsupported("a surface with one side has no coarse states");
    ChartTables t;
    t.rows = s.tables.rows < 2 ? 1 : coarse_count(s.tables.rows, stride);
    t.cols = s.tables.cols < 2 ? 1 : coarse_count(s.tables.cols, stride);
    if (t.rows < 3 || t.cols < 3) return unsupported("the stride leaves fewer than 3 x 3 samples");
    t.grid = t.total = t.rows * t.cols;
    Layers layers;
    if (auto r = take_layers(s, stride, t, layers); !r) return r.error();
    auto made = create_state(t, options);
    if (!made) return made.error();
    if (made.value().impl()->open_surface != s.open_surface)
        return unsupported("the seams of the map do not meet at this stride");
    return std::move(made).value();
}

[[gnu::cold]] Result<Detail> Detail::create(const State& fine, const State& coarse, std::uint32_t stride,
                                            const Allocator& allocator) noexcept {
    using namespace detail;
    const StateImpl &f = *fine.impl(), &c = *coarse.impl();
    if (!is_valid(allocator)) return Error{ErrorCode::BadArgument, kNoOffset, "the allocator is half empty"};
    if (stride < 1 || f.tables.rows < 2 || f.tables.cols < 2 || f.total() != f.tables.grid ||
        c.tables.rows != coarse_count(f.tables.rows, stride) || c.tables.cols != coarse_count(f.tables.cols, stride))
        return Error{ErrorCode::BadArgument, kNoOffset, "the coarse state is not of this state and stride"};
    DetailImpl* d = detail::create<DetailImpl>(allocator, allocator);
    if (d == nullptr) return kNoMemory;
    Detail made(d);
    d->stride = stride;
    d->rows = f.tables.rows;
    d->cols = f.tables.cols;
    d->coarse_rows = c.tables.rows;
    d->coarse_cols = c.tables.cols;
    if (!d->area.allocate(allocator, c.total()) || !d->gradient.allocate(allocator, c.total())) return kNoMemory;
    each_triangle(c, [&](const std::uint32_t(&k)[3]) {
        const Double3 across = cross(rest_of(c, k[1]) - rest_of(c, k[0]), rest_of(c, k[2]) - rest_of(c, k[0]));
        for (const std::uint32_t s : k) d->area[c.representative(s)] += 0.5 * std::sqrt(dot(across, across));
    });
    return made;
}

Detail::Detail(Detail&& other) noexcept : impl_(std::exchange(other.impl_, nullptr)) {}
Detail& Detail::operator=(Detail&& other) noexcept {
    std::swap(impl_, other.impl_);
    return *this;
}
Detail::~Detail() {
    detail::destroy(impl_);
}

Result<void> Detail::show(const State& coarse, State& fine) noexcept {
    using namespace detail;
    fine.release();
    const StateImpl& c = *coarse.impl();
    StateImpl& f = *fine.impl();
    DetailImpl& d = *impl_;
    if (!d.fits(f, c)) return Error{ErrorCode::BadArgument, kNoOffset, "the states are not those of the detail"};
    measure_gradients(d, c);
    for (std::uint32_t i = 0; i < d.rows; ++i)
        for (std::uint32_t j = 0; j < d.cols; ++j) {
            const std::uint32_t k = i * d.cols + j, first = f.representative(k);
            Vec3 to = StateImpl::at(f.now, first);  // copies come after their representative
            if (first == k) {
                const Double3 way = displacement(d, f, c, i, j);
                to = dot(way, way) > 0 ? narrow(rest_of(f, k) + way) : StateImpl::at(f.rest, k);  // -0 stays -0
            }
            f.now.x[k] = to.x;
            f.now.y[k] = to.y;
            f.now.z[k] = to.z;
        }
    f.touch_all();
    return {};
}

}  // namespace dgm
