// SPDX-License-Identifier: MIT
// libdgm/src/touch/kernel_table.cpp
// Kernels of deform.h and their tables.
#include <algorithm>
#include <cmath>
#include <cstring>

#include <dgm/limits.h>

#include "base/portable_math.h"
#include "file/asset_impl.h"
#include "rows/rows.h"
#include "touch/table_impl.h"

namespace dgm {
namespace detail {
namespace {
constexpr std::uint32_t kEntries = 4096;
constexpr Error kNoMemory{ErrorCode::OutOfMemory, kNoOffset, "no memory for the table"};

/// e^t - 1 - t without cancellation, 0 <= t <= 1.
double phi(double t) noexcept {
    double sum = 1;  // t^2/2 (1 + t/3 (1 + t/4 (...))): 16 factors leave 2/19!, 8 leave 0.1^9 * 2/11!
    for (int k = t > 0.1 ? 18 : 10; k >= 3; --k) sum = 1 + t / k * sum;
    return t * t / 2 * sum;
}

/// Eq. 7 without d_c, or its compact form f_c (docs/methods.md section 5), which is phi(R^2 - r^2) / phi(R^2).
double gaussian(double r2, double sigma, double reach, KernelEnd end) noexcept {
    const double q = r2 / sigma;
    if (end == KernelEnd::Printed) return portable_exp(-q);
    const double R2 = reach * reach / sigma;
    if (!(q < R2)) return 0;
    if (R2 <= 1) return phi(R2 - q) / phi(R2);
    const double rim = portable_exp(-R2);
    return std::max(0.0, (portable_exp(-q) - rim * (1 + R2 - q)) / (1 - rim * (1 + R2)));
}

double kernel(const TableImpl& t, double r2) noexcept {
    if (t.options.shape != KernelShape::User) return gaussian(r2, t.sigma, t.options.reach, t.options.end);
    const double at = std::sqrt(r2) / t.options.reach * static_cast<double>(t.values.size() - 1);
    const double last = static_cast<double>(t.values.size() - 1);
    if (!(at < last)) return at == last ? t.values[t.values.size() - 1] : 0;
    const auto k = static_cast<std::size_t>(at);
    return t.values[k] + (at - static_cast<double>(k)) * (double{t.values[k + 1]} - t.values[k]);
}

double distance2(const TableImpl& t, double x, double y) noexcept {
    return t.a * x * x + t.b * x * y + t.c * y * y;
}

Result<void> check(const KernelOptions& o) noexcept {
    const auto bad = [](const char* message) { return Error{ErrorCode::BadArgument, kNoOffset, message}; };
    if (o.reach < 1 || o.reach > kMaxReach) return bad("the reach is not in 1..1024");
    if (o.end != KernelEnd::Printed && o.end != KernelEnd::Compact)
        return Error{ErrorCode::Unsupported, kNoOffset, "the kernel end is not supported"};
    const auto in_range = [](float radius) { return radius >= kMinKernelRadius && radius <= kMaxKernelRadius; };
    switch (o.shape) {
        case KernelShape::Circular:
            if (!(o.sigma >= kMinSigma && o.sigma <= kMaxSigma)) return bad("sigma is not in 1e-6 .. 1e12");
            return {};
        case KernelShape::Elliptic:
            if (!in_range(o.radius_a) || !in_range(o.radius_b)) return bad("a radius is not in 1e-3 .. 1e6");
            if (std::max(o.radius_a, o.radius_b) > kMaxKernelRatio * std::min(o.radius_a, o.radius_b))
                return bad("a radius is more than 1e4 times the other");
            if (!std::isfinite(o.angle)) return bad("the angle is not finite");
            return {};
        case KernelShape::User:
            if (o.values.size() < 2 || o.values.size() > 65536) return bad("a user table has 2 .. 65536 weights");
            for (const float v : o.values)
                if (!(v >= -1 && v <= 1)) return bad("a weight of the user table is not in -1 .. 1");
            return {};
    }
    return Error{ErrorCode::Unsupported, kNoOffset, "the kernel shape is not supported"};
}

void set_form(TableImpl& t) noexcept {
    const KernelOptions& o = t.options;
    t.sigma = o.sigma;
    if (o.shape != KernelShape::Elliptic) return;
    const double longer = std::max(o.radius_a, o.radius_b);
    t.sigma = longer * longer;
    const double p = longer / o.radius_a, q = longer / o.radius_b;
    const auto [sine, cosine] = portable_sine(o.angle);
    // x' = cosine x + sine y along axis a, y' = -sine x + cosine y along axis b.
    t.a = p * p * cosine * cosine + q * q * sine * sine;
    t.b = 2 * (p * p - q * q) * cosine * sine;
    t.c = p * p * sine * sine + q * q * cosine * cosine;
    t.mirrored = false;
}

/// Equal offsets up to sign get one computed value: the same bits in all directions.
bool fill_rows(TableImpl& t) noexcept {
    const auto b = static_cast<std::int32_t>(t.options.reach);
    const std::uint64_t rows = t.mirrored ? t.options.reach : t.width();
    if (!t.weights.allocate(t.allocator, rows * t.width())) return false;
    if (!t.mirrored && !t.turned.allocate(t.allocator, rows * t.width())) return false;
    const auto at = [&](Array<float>& to, std::int32_t di, std::int32_t dj) -> float& {
        return to[static_cast<std::size_t>(t.mirrored ? di : di + b - 1) * t.width() +
                  static_cast<std::size_t>(dj + b - 1)];
    };
    if (t.mirrored) {
        for (std::int32_t di = 0; di < b; ++di)
            for (std::int32_t dj = 0; dj <= di; ++dj) {
                const auto w = static_cast<float>(kernel(t, double(di) * di + double(dj) * dj));
                at(t.weights, di, dj) = at(t.weights, di, -dj) = w;
                at(t.weights, dj, di) = at(t.weights, dj, -di) = w;
            }
        return true;
    }
    for (std::int32_t di = 0; di < b; ++di)
        for (std::int32_t dj = 1 - b; dj < b; ++dj) {
            const auto w = static_cast<float>(kernel(t, distance2(t, di, dj)));
            at(t.weights, di, dj) = at(t.weights, -di, -dj) = w;
            at(t.turned, dj, di) = at(t.turned, -dj, -di) = w;
        }
    return true;
}

/// Distances up to where the window or the weight ends.
bool fill_profile(TableImpl& t) noexcept {
    const double b = t.options.reach;
    double end = b;
    if (t.options.shape != KernelShape::User && t.options.end == KernelEnd::Printed) {
        const double corner = std::sqrt(2 * (t.a + t.c)) * b;          // no form is larger on the window
        end = std::min(corner, std::max(b, std::sqrt(28 * t.sigma)));  // e^-28 is far below a float's half ulp at 1
    }
    if (!t.entries.allocate(t.allocator, kEntries)) return false;
    t.spacing = static_cast<float>(end / (kEntries - 1));
    for (std::uint32_t k = 0; k < kEntries; ++k) {
        const double r = double{t.spacing} * k;
        t.entries[k] = static_cast<float>(kernel(t, r * r));
    }
    return true;
}
/// A chord c means a distance in c .. c (1 + e), e = 1 / sqrt(1 - slant^2) - 1. Weights change by at most |r w'(r)| e.
void fill_tolerances(TableImpl& t) noexcept {
    const std::size_t last = t.entries.size() - 1;
    double steepest = 0;
    for (std::size_t k = 0; k < last; ++k)
        steepest = std::max(steepest, static_cast<double>(k + 1) * std::fabs(double{t.entries[k + 1]} - t.entries[k]));
    for (TableImpl::Tolerance& tolerance : t.tolerance) {
        const double longer = 1 + tolerance.share / std::max(steepest, 1e-6);
        tolerance.slant2 = std::min(static_cast<float>(1 - 1 / (longer * longer)), kSteep * kSteep);
        const auto from = static_cast<std::size_t>(std::min(t.options.reach / double{t.spacing}, double(last)));
        float low = 0, high = 0;  // beyond the reach there is 0
        std::size_t k = from;
        for (; k > 0; --k) {
            low = std::min(low, t.entries[k]);
            high = std::max(high, t.entries[k]);
            if (high - low > tolerance.share) break;
        }
        tolerance.quiet = t.spacing * static_cast<float>(k + 1);
    }
}

void fill_hash(TableImpl& t) noexcept {
    const KernelOptions& o = t.options;
    const float numbers[4] = {o.sigma, o.radius_a, o.radius_b, o.angle};
    const std::uint32_t choices[3] = {static_cast<std::uint32_t>(o.shape), static_cast<std::uint32_t>(o.end), o.reach};
    const Hash parts[3] = {hash_bytes(numbers, sizeof numbers), hash_bytes(choices, sizeof choices),
                           hash_bytes(t.values.data(), t.values.size() * sizeof(float))};
    const Hash all = hash_bytes(parts, sizeof parts);
    std::memcpy(t.hash, all.data(), sizeof t.hash);
}
}  // namespace

float TableImpl::weight(float di, float dj) const noexcept {
    const float x = std::fabs(di), y = std::fabs(dj), reach = static_cast<float>(options.reach);
    if (!(x < reach && y < reach)) return 0;
    if (x == std::floor(x) && y == std::floor(y))
        return row(static_cast<std::int32_t>(di))[static_cast<std::int32_t>(dj)];
    return static_cast<float>(kernel(*this, distance2(*this, di, dj)));
}
}  // namespace detail

Result<DeformTable> DeformTable::create(const KernelOptions& options, const Allocator& allocator) noexcept {
    if (!detail::is_valid(allocator)) return Error{ErrorCode::BadArgument, kNoOffset, "the allocator is half empty"};
    if (auto r = detail::check(options); !r) return r.error();
    detail::TableImpl* impl = detail::create<detail::TableImpl>(allocator, allocator);
    if (impl == nullptr) return detail::kNoMemory;
    DeformTable table(impl);
    impl->options = options;
    impl->options.values = {};
    if (options.shape == KernelShape::User) {
        if (!impl->values.allocate(allocator, options.values.size())) return detail::kNoMemory;
        std::memcpy(impl->values.data(), options.values.data(), options.values.size_bytes());
        impl->options.values = {impl->values.data(), impl->values.size()};
    }
    detail::set_form(*impl);
    if (!detail::fill_rows(*impl) || !detail::fill_profile(*impl)) return detail::kNoMemory;
    detail::fill_tolerances(*impl);
    detail::fill_hash(*impl);
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
    return impl_->weight(di, dj);
}
// Entries are rounded once from double: half a unit in the last place of 1 is 2^-25, and the double's own error is far
// below the other half.
float DeformTable::error_bound() const noexcept {
    return 0x1p-24f;
}
float DeformTable::profile(float distance) const noexcept {
    return distance >= 0 ? impl_->profile(distance) : 0;
}
// exp(-r^2) has |f''| <= 2, so h^2 / 8 * 2; the compact form is the same curve less a parabola with slope below that,
// over 1 - rim, which is the larger the nearer R is to 0: there f_c -> (1 - r^2/R^2)^2, |f''| <= 8 / R^2. A user table
// is linear between its own entries: a kink between two of ours is missed by at most half the largest step of either.
float DeformTable::profile_error_bound() const noexcept {
    const detail::TableImpl& t = *impl_;
    if (t.options.shape == KernelShape::User) {
        float step = 0;
        for (std::size_t k = 0; k + 1 < t.entries.size(); ++k)
            step = std::max(step, std::fabs(t.entries[k + 1] - t.entries[k]));
        return step + 0x1p-22f;
    }
    const double h2 = double{t.spacing} * t.spacing / t.sigma, b = t.options.reach, R2 = b * b / t.sigma;
    const double steepest = t.options.end == KernelEnd::Compact ? std::max(4.0, 8 / R2) : 2.0;
    return static_cast<float>(h2 / 8 * steepest) + 0x1p-22f;
}
std::uint32_t DeformTable::reach() const noexcept {
    return impl_->options.reach;
}

}  // namespace dgm
