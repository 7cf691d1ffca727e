// SPDX-License-Identifier: MIT
// libdgm/src/deform.cpp
// Paper eq. 7 with a table, and its continuation across seams.
#include <dgm/deform.h>

#include <algorithm>
#include <cmath>

#include "state_impl.h"

namespace dgm {
namespace detail {

/// Weights of whole offsets: row |di| holds dj = -(b-1) .. b-1, so that a row of the footprint reads one row in order.
struct TableImpl {
    explicit TableImpl(const Allocator& a) noexcept : allocator(a) {}
    Allocator allocator;
    KernelOptions options;
    Array<float> weights;
    [[nodiscard]] std::uint32_t width() const noexcept { return 2 * options.reach - 1; }
    [[nodiscard]] const float* row(std::uint32_t di) const noexcept {
        return weights.data() + std::size_t{di} * width() + options.reach - 1;  // at dj = 0
    }
};

namespace {
/// e^t - 1 - t without cancellation, t >= 0.
double phi(double t) noexcept {
    if (t > 0.1) return std::expm1(t) - t;
    double sum = 1;  // t^2/2 (1 + t/3 (1 + t/4 (...))): 9 terms leave 0.1^9 * 2/11!
    for (int k = 10; k >= 3; --k) sum = 1 + t / k * sum;
    return t * t / 2 * sum;
}

/// Eq. 7 without d_c, or its compact form f_c (methods section 5), which is phi(R^2 - r^2) / phi(R^2).
double kernel(const KernelOptions& o, double di, double dj) noexcept {
    const double sigma = o.sigma, b = o.reach, r2 = (di * di + dj * dj) / sigma;
    if (o.end == KernelEnd::Printed) return std::exp(-r2);
    const double R2 = b * b / sigma;
    if (!(r2 < R2)) return 0;
    if (R2 <= 1) return phi(R2 - r2) / phi(R2);
    const double rim = std::exp(-R2);
    return std::max(0.0, (std::exp(-r2) - rim * (1 + R2 - r2)) / (1 - rim * (1 + R2)));
}

float weight_at(const TableImpl& t, float di, float dj) noexcept {
    const float x = std::fabs(di), y = std::fabs(dj), b = static_cast<float>(t.options.reach);
    if (!(x < b && y < b)) return 0;
    if (x == std::floor(x) && y == std::floor(y))
        return t.row(static_cast<std::uint32_t>(x))[static_cast<std::uint32_t>(y)];
    return static_cast<float>(kernel(t.options, x, y));
}

/// Adds weight * d to samples.
class Writer {
 public:
    Writer(StateImpl& s, Vec3 d, bool plastic) noexcept : s_(s), d_{d.x, d.y, d.z}, plastic_(plastic) {}

    /// A run of `count` samples from `first` with weights w[0..count).
    void add_run(std::uint32_t first, const float* w, std::uint32_t count) const noexcept {
        for (int axis = 0; axis < 3; ++axis) {
            const std::size_t at = static_cast<std::size_t>(axis) * s_.total() + first;
            add(s_.now.data() + at, w, count, d_[axis]);
            if (plastic_) add(s_.base.data() + at, w, count, d_[axis]);
        }
    }
    /// All copies get the bits computed for the first.
    void add_class(std::span<const std::uint32_t> members, float w) const noexcept {
        add_run(members[0], &w, 1);
        for (int axis = 0; axis < 3; ++axis) {
            const std::size_t plane = static_cast<std::size_t>(axis) * s_.total();
            for (const std::uint32_t copy : members.subspan(1)) {
                s_.now[plane + copy] = s_.now[plane + members[0]];
                s_.base[plane + copy] = s_.base[plane + members[0]];
            }
        }
    }

 private:
    static void add(float* to, const float* w, std::uint32_t count, float d) noexcept {
        for (std::uint32_t k = 0; k < count; ++k) to[k] += w[k] * d;
    }
    StateImpl& s_;
    float d_[3];
    bool plastic_;
};

/// The window as a rectangle clipped by the grid: eq. 7 as it stands.
std::uint32_t deform_window(StateImpl& s, const TableImpl& t, const Writer& writer, std::uint32_t sample,
                            bool elastic) noexcept {
    const std::uint32_t ic = sample / s.tables.cols, jc = sample % s.tables.cols, r = t.options.reach - 1;
    const std::uint32_t i0 = ic > r ? ic - r : 0, i1 = std::min(ic + r, s.tables.rows - 1);
    const std::uint32_t j0 = jc > r ? jc - r : 0, j1 = std::min(jc + r, s.tables.cols - 1);
    for (std::uint32_t i = i0; i <= i1; ++i)
        writer.add_run(i * s.tables.cols + j0, t.row(i < ic ? ic - i : i - ic) - (jc - j0), j1 - j0 + 1);
    s.touch_rows(i0, i1, j0, j1, elastic);
    return (i1 - i0 + 1) * (j1 - j0 + 1);
}

/// The window unfolded across seams. Copies of a class are collected first, so that one weight, that of the copy placed
/// nearest, is written to all of them, also to those the walk did not reach.
std::uint32_t deform_unfolded(StateImpl& s, const TableImpl& t, const Writer& writer, bool elastic) noexcept {
    WalkScratch& w = s.walk;
    std::uint32_t classes = 0, samples = 0;
    for (std::uint32_t k = 0; k < w.visited_count; ++k) {
        const std::uint32_t slot = w.visited[k];
        const WalkNode& node = w.nodes[slot];
        const std::uint32_t id = s.class_id(node.sample);
        if (id == kNone) {
            const float weight = weight_at(t, node.x, node.y);
            writer.add_run(node.sample, &weight, 1);
            s.touch_sample(node.sample, elastic);
            ++samples;
        } else if (w.class_node[id] == kNone) {
            w.classes[classes++] = id;
            w.class_node[id] = slot;
        } else if (node.d2 < w.nodes[w.class_node[id]].d2) {
            w.class_node[id] = slot;
        }
    }
    for (std::uint32_t k = 0; k < classes; ++k) {
        const std::uint32_t id = w.classes[k];
        const WalkNode& node = w.nodes[w.class_node[id]];
        const auto members = s.members(id);
        writer.add_class(members, weight_at(t, node.x, node.y));
        for (const std::uint32_t copy : members) s.touch_sample(copy, elastic);
        samples += static_cast<std::uint32_t>(members.size());
        w.class_node[id] = kNone;
    }
    return samples;
}

bool is_finite(Vec3 v) noexcept {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

Vec3 clamped(Vec3 d, float d_max) noexcept {
    const double length = std::sqrt(double{d.x} * d.x + double{d.y} * d.y + double{d.z} * d.z);
    if (length <= d_max) return d;
    const double f = d_max / length;
    return {static_cast<float>(d.x * f), static_cast<float>(d.y * f), static_cast<float>(d.z * f)};
}
}  // namespace
}  // namespace detail

Result<DeformTable> DeformTable::create(const KernelOptions& options, const Allocator& allocator) noexcept {
    if (!detail::is_valid(allocator)) return Error{ErrorCode::BadArgument, kNoOffset, "the allocator is half empty"};
    if (!std::isfinite(options.sigma) || !(options.sigma > 0))
        return Error{ErrorCode::BadArgument, kNoOffset, "sigma is not a positive number"};
    if (options.reach < 1 || options.reach > kMaxReach)
        return Error{ErrorCode::BadArgument, kNoOffset, "the reach is not in 1..1024"};
    if (options.shape != KernelShape::Circular)
        return Error{ErrorCode::Unsupported, kNoOffset, "the kernel shape is not supported"};
    if (options.end != KernelEnd::Printed && options.end != KernelEnd::Compact)
        return Error{ErrorCode::Unsupported, kNoOffset, "the kernel end is not supported"};
    detail::TableImpl* impl = detail::create<detail::TableImpl>(allocator, allocator);
    if (impl == nullptr) return Error{ErrorCode::OutOfMemory, kNoOffset, "no memory for the table"};
    DeformTable table(impl);
    impl->options = options;
    const std::uint32_t b = options.reach;
    if (!impl->weights.allocate(allocator, std::uint64_t{b} * impl->width()))
        return Error{ErrorCode::OutOfMemory, kNoOffset, "no memory for the table"};
    const auto centre = [&](std::uint32_t di) {
        return impl->weights.data() + std::size_t{di} * impl->width() + b - 1;
    };
    for (std::uint32_t di = 0; di < b; ++di)
        for (std::uint32_t dj = 0; dj <= di; ++dj) {
            // Mirrored, not computed again: the same bits in all eight directions.
            const auto w = static_cast<float>(detail::kernel(options, di, dj));
            float *row = centre(di), *column = centre(dj);
            row[dj] = row[-static_cast<std::ptrdiff_t>(dj)] = w;
            column[di] = column[-static_cast<std::ptrdiff_t>(di)] = w;
        }
    return table;
}

DeformTable::DeformTable(DeformTable&& other) noexcept : impl_(std::exchange(other.impl_, nullptr)) {}
DeformTable& DeformTable::operator=(DeformTable&& other) noexcept {
    std::swap(impl_, other.impl_);
    return *this;
}
DeformTable::~DeformTable() {
    detail::destroy(impl_);
}

float DeformTable::weight(float di, float dj) const noexcept {
    return detail::weight_at(*impl_, di, dj);
}
// Entries are rounded once from double: half a unit in the last place of 1 is 2^-25, and the double's own error is far
// below the other half.
float DeformTable::error_bound() const noexcept {
    return 0x1p-24f;
}
std::uint32_t DeformTable::reach() const noexcept {
    return impl_->options.reach;
}

Result<DeformReport> deform(State& state, const DeformTable& table, const Touch& touch) noexcept {
    detail::StateImpl& s = *state.impl();
    const detail::TableImpl& t = *table.impl();
    if (!s.usable(touch.sample))
        return Error{ErrorCode::BadArgument, kNoOffset, "the contact is no sample of the surface"};
    if (!detail::is_finite(touch.displacement))
        return Error{ErrorCode::BadArgument, kNoOffset, "the displacement is not finite"};
    if (!std::isfinite(touch.d_max) || !(touch.d_max > 0))
        return Error{ErrorCode::BadArgument, kNoOffset, "d_max is not a positive number"};
    if (t.options.reach > s.max_reach)
        return Error{ErrorCode::BadArgument, kNoOffset, "the table reaches farther than the state was made for"};
    if (touch.footprint != Footprint::Grid)
        return Error{ErrorCode::Unsupported, kNoOffset, "the footprint is not supported"};
    if (touch.mode != DeformMode::Elastic && touch.mode != DeformMode::Plastic)
        return Error{ErrorCode::Unsupported, kNoOffset, "the mode is not supported"};

    DeformReport report;
    report.displacement = detail::clamped(touch.displacement, touch.d_max);
    const bool elastic = touch.mode == DeformMode::Elastic;
    const detail::Writer writer(s, report.displacement, !elastic);
    if (detail::is_plain_window(s, touch.sample, t.options.reach)) {
        report.samples = detail::deform_window(s, t, writer, touch.sample, elastic);
        return report;
    }
    if (auto r = detail::begin_walk(s, touch.sample, t.options.reach); !r) return r.error();
    for (std::uint32_t k = 0; k < s.walk.visited_count && !report.crossed_seam; ++k)
        report.crossed_seam = s.class_id(s.walk.nodes[s.walk.visited[k]].sample) != kNone;
    report.samples = detail::deform_unfolded(s, t, writer, elastic);
    detail::end_walk(s);
    return report;
}

}  // namespace dgm
