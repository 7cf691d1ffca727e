// SPDX-License-Identifier: MIT
// libdgm/src/footprint.cpp
// Which samples a contact moves, and how much: keys and weights in StateImpl::footprint.
#include <algorithm>
#include <cmath>

#include "state_impl.h"
#include "table_impl.h"

namespace dgm::detail {
namespace {
constexpr float kInfinity = __builtin_inff();
constexpr float kBeyond = 1;  ///< mean steps that a front goes on beyond the reach

class Builder {
 public:
    Builder(StateImpl& s, const TableImpl& t, const Contact& c) noexcept
        : s_(s), f_(s.footprint), t_(t), contact_(c), reach_(static_cast<float>(t.options.reach)) {}

    Result<void> build() noexcept {
        f_.truncated = false;
        if (contact_.footprint == Footprint::Geodesic) {
            by_front();
            return {};
        }
        const bool metric = contact_.footprint == Footprint::Metric;
        std::uint32_t b = t_.options.reach;
        if (metric) b = metric_window();
        if (s_.tables.free_domain && !is_plain_window(s_, contact_.sample, b)) {
            if (auto r = by_walk(b); !r) return r;
        } else {
            // With another distance than eq. 7's the nearest place is still the one nearest in grid steps.
            place_frames(s_, metric ? nullptr : &t_, contact_.sample, b);
            if (metric) measure_frames();
            if (!s_.stiffness.empty() && !metric) soften_frames();
        }
        weld();
        return {};
    }

 private:
    [[nodiscard]] float softness(std::uint32_t sample) const noexcept {
        return s_.stiffness.empty() || sample >= s_.tables.grid ? 1 : s_.stiffness[sample];
    }
    /// Weight at a kernel distance, its sigma being `stiffness` times the kernel's.
    [[nodiscard]] float profile(float r2, float stiffness) const noexcept {
        if (stiffness == 1) return t_.profile(std::sqrt(r2));
        if (stiffness == 0) return r2 == 0 ? t_.profile(0) : 0;
        return t_.profile(std::sqrt(r2 / stiffness));
    }
    /// Kernel distance^2 and weight of a sample at offset (x, y) scaled to a length, all in kernel steps; cut at b.
    void set_by_length(std::uint32_t sample, float x, float y, float length2) noexcept {
        float r2 = length2;
        if (!t_.mirrored && length2 > 0) {
            const float flat2 = x * x + y * y;
            if (flat2 > 0)
                r2 = (static_cast<float>(t_.a) * x * x + static_cast<float>(t_.b) * x * y +
                      static_cast<float>(t_.c) * y * y) *
                     (length2 / flat2);
        }
        f_.key[sample] = length2;
        f_.weight[sample] = length2 < reach_ * reach_ ? profile(r2, softness(sample)) : 0;
    }

    void add_sample(std::uint32_t sample) noexcept { f_.samples[f_.sample_count++] = sample; }
    void see_class(std::uint32_t id) noexcept {
        if (f_.class_seen[id] != 0) return;
        f_.class_seen[id] = 1;
        f_.classes[f_.class_count++] = id;
    }

    // Geodesic

    void by_front() noexcept {
        f_.frame_count = 0;
        // The way to a sample at the rim may lead between two that are out of reach.
        begin_geodesic(s_, contact_.sample, reach_ * contact_.step + kBeyond * s_.mean_step);
        const GeodesicScratch& g = s_.geodesic;
        const ConstPlanes p = StateImpl::fixed(s_.rest);
        const Vec3 centre = StateImpl::at(p, contact_.sample);
        const bool even = t_.mirrored && s_.stiffness.empty();
        Vec3 u{}, v{};
        if (!t_.mirrored) tangents(u, v);
        const float per_step = 1 / contact_.step;
        for (std::uint32_t k = 0; k < g.touched_count; ++k) {
            const std::uint32_t first = g.touched[k], id = s_.class_id(first);
            const float d = g.nodes[first].distance * per_step;
            if (d > reach_) continue;
            if (even) {
                f_.weight[first] = d < reach_ ? t_.profile(d) : 0;
            } else {
                float x = 0, y = 0;
                if (!t_.mirrored) {
                    const Vec3 e = StateImpl::at(p, first) - centre;
                    x = dot(e, u);
                    y = dot(e, v);
                }
                set_by_length(first, x, y, d * d);
            }
            if (id == kNone) {
                add_sample(first);
                continue;
            }
            see_class(id);
            for (const std::uint32_t copy : s_.members(id)) {
                f_.weight[copy] = f_.weight[first];
                add_sample(copy);
            }
        }
        end_geodesic(s_);
        frame_samples();
    }

    /// Away from seams: rows of a rectangle are quicker than samples one by one, unless it holds much else. The rest of
    /// it weighs 0.
    void frame_samples() noexcept {
        if (f_.class_count != 0 || f_.sample_count == 0) return;
        Rect r{kNone, 0, kNone, 0};
        const double rows_of = 1.0 / s_.tables.cols;
        for (std::uint32_t k = 0; k < f_.sample_count; ++k) {
            const std::uint32_t sample = f_.samples[k];
            if (sample >= s_.tables.grid) return;
            const auto i = static_cast<std::uint32_t>((sample + 0.5) * rows_of), j = sample - i * s_.tables.cols;
            r = {std::min(r.i0, i), std::max(r.i1, i), std::min(r.j0, j), std::max(r.j1, j)};
        }
        if (RectList::area(r) > 2 * std::uint64_t{f_.sample_count}) return;
        f_.listed = f_.sample_count;
        f_.sample_count = 0;
        f_.frames[f_.frame_count++] = {1, 0, 0, 0, r};
    }

    /// Unit tangents of the rest surface at the contact: u along +i, v a quarter turn from it towards +j. Kernels with
    /// a direction take it from the straight line to the sample, laid into this plane.
    void tangents(Vec3& u, Vec3& v) const noexcept {
        const ConstPlanes p = StateImpl::fixed(s_.rest);
        const Vec3 n = sample_normal(s_, p, contact_.sample);
        Vec3 e{};
        if (contact_.sample < s_.tables.grid) {
            const std::uint32_t i = contact_.sample / s_.tables.cols, step = s_.tables.cols;
            const std::uint32_t before =
                i > 0 && s_.usable(contact_.sample - step) ? contact_.sample - step : contact_.sample;
            const std::uint32_t after =
                i + 1 < s_.tables.rows && s_.usable(contact_.sample + step) ? contact_.sample + step : contact_.sample;
            e = StateImpl::at(p, after) - StateImpl::at(p, before);
        }
        e = e - dot(e, n) * n;
        if (!(dot(e, e) > 0)) {
            e = std::fabs(n.x) < 0.5f ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
            e = e - dot(e, n) * n;
        }
        u = (1 / std::sqrt(dot(e, e))) * e;
        v = {n.y * u.z - n.z * u.y, n.z * u.x - n.x * u.z, n.x * u.y - n.y * u.x};
    }

    // Metric

    struct Form {
        float e, f, g;
        [[nodiscard]] float of(float x, float y) const noexcept { return e * x * x + 2 * f * x * y + g * y * y; }
    };
    [[nodiscard]] Form form_at(std::uint32_t sample) const noexcept {
        const float* m = s_.metric.data() + 3 * std::size_t{sample};
        return {m[0], m[1], m[2]};
    }
    /// Border samples of a free domain have no form of their own: that of a grid sample in their quad.
    [[nodiscard]] Form form_of(std::uint32_t sample) const noexcept {
        if (sample < s_.tables.grid) return form_at(sample);
        const auto p = s_.place(sample);
        const std::uint32_t i = static_cast<std::uint32_t>(p.x), j = static_cast<std::uint32_t>(p.y);
        for (const std::uint32_t di : {0u, 1u})
            for (const std::uint32_t dj : {0u, 1u})
                if (i + di < s_.tables.rows && j + dj < s_.tables.cols &&
                    s_.tables.on_surface((i + di) * s_.tables.cols + j + dj))
                    return form_at((i + di) * s_.tables.cols + j + dj);
        return {0, 0, 0};
    }

    /// (G(contact) + G(sample)) / 2 >= G(contact) / 2, so no sample in reach is farther than this many steps.
    std::uint32_t metric_window() noexcept {
        const Form c = form_of(contact_.sample);
        const double mean = 0.5 * (double{c.e} + c.g), half = 0.5 * (double{c.e} - c.g);
        const double smallest = mean - std::sqrt(half * half + double{c.f} * c.f);
        const double length = double{reach_} * contact_.step;
        const double steps = smallest > 0 ? std::ceil(length * std::sqrt(2 / smallest)) + 1 : 1e9;
        if (steps <= s_.max_reach) return static_cast<std::uint32_t>(std::max(steps, 1.0));
        f_.truncated = true;
        return s_.max_reach;
    }

    /// (x, y): offset in the contact's chart; (cosine, sine): turn of the sample's chart in it.
    void measure(std::uint32_t sample, float x, float y, float cosine, float sine) noexcept {
        const Form at_contact = form_of(contact_.sample), here = form_of(sample);
        const float hx = cosine * x + sine * y, hy = cosine * y - sine * x;
        const float per_step2 = 1 / (contact_.step * contact_.step);
        const float d2 = 0.5f * (at_contact.of(x, y) + here.of(hx, hy)) * per_step2;
        float fx = x, fy = y;
        if (!t_.mirrored && at_contact.e > 0) {  // components in the contact's tangent plane, x along +i
            const float root = std::sqrt(at_contact.e);
            fx = root * x + at_contact.f / root * y;
            fy = std::sqrt(std::max(at_contact.g - at_contact.f * at_contact.f / at_contact.e, 0.0f)) * y;
        }
        set_by_length(sample, fx, fy, std::max(d2, 0.0f));
    }

    template <class Visit>
    void each(Visit visit) noexcept {
        for (std::uint32_t k = 0; k < f_.frame_count; ++k) {
            const Frame& f = f_.frames[k];
            for (std::uint32_t i = f.rect.i0; i <= f.rect.i1; ++i)
                for (std::uint32_t j = f.rect.j0; j <= f.rect.j1; ++j) visit(f, i, j, i * s_.tables.cols + j);
        }
    }

    /// Keys turn from grid steps to lengths. The frame in which a sample lies nearest is found by its key, so keys are
    /// changed to marks first and to lengths when all are known.
    void measure_frames() noexcept {
        each([&](const Frame& f, std::uint32_t i, std::uint32_t j, std::uint32_t k) {
            const auto x =
                static_cast<float>(f.c * static_cast<std::int32_t>(i) - f.s * static_cast<std::int32_t>(j) + f.x);
            const auto y =
                static_cast<float>(f.s * static_cast<std::int32_t>(i) + f.c * static_cast<std::int32_t>(j) + f.y);
            if (f_.key[k] != x * x + y * y) return;
            measure(k, x, y, static_cast<float>(f.c), static_cast<float>(f.s));
            f_.key[k] = -1 - f_.key[k];
        });
        each([&](const Frame&, std::uint32_t, std::uint32_t, std::uint32_t k) {
            if (f_.key[k] < 0) f_.key[k] = -1 - f_.key[k];
        });
    }

    /// Eq. 7 with sigma times the sample's stiffness.
    void soften_frames() noexcept {
        each([&](const Frame&, std::uint32_t, std::uint32_t, std::uint32_t k) {
            if (s_.stiffness[k] != 1 && f_.key[k] < kInfinity) f_.weight[k] = profile(f_.key[k], s_.stiffness[k]);
        });
    }

    // Free border

    Result<void> by_walk(std::uint32_t b) noexcept {
        f_.frame_count = 0;
        if (auto r = begin_walk(s_, contact_.sample, b); !r) return r;
        for (std::uint32_t k = 0; k < s_.walk.visited_count; ++k) {
            const WalkNode& node = s_.walk.nodes[s_.walk.visited[k]];
            if (contact_.footprint == Footprint::Metric) {
                measure(node.sample, node.x, node.y, node.cosine, node.sine);
            } else {
                const float form = static_cast<float>(t_.a) * node.x * node.x +
                                   static_cast<float>(t_.b) * node.x * node.y +
                                   static_cast<float>(t_.c) * node.y * node.y;
                const float stiffness = softness(node.sample);
                f_.key[node.sample] = form;
                f_.weight[node.sample] = stiffness == 1 ? t_.weight(node.x, node.y) : profile(form, stiffness);
            }
            add_sample(node.sample);
            const std::uint32_t id = s_.class_id(node.sample);
            if (id != kNone) see_class(id);
        }
        end_walk(s_);
        return {};
    }

    /// All copies of a class take the values of the nearest one, also those that lie outside every frame.
    void weld() noexcept {
        for (std::uint32_t k = 0; k < f_.class_count; ++k) {
            const auto members = s_.members(f_.classes[k]);
            float key = kInfinity, weight = 0;
            for (const std::uint32_t copy : members)
                if (f_.key[copy] < key) {
                    key = f_.key[copy];
                    weight = f_.weight[copy];
                }
            for (const std::uint32_t copy : members) {
                if (f_.key[copy] == kInfinity) add_sample(copy);
                f_.key[copy] = key;
                f_.weight[copy] = weight;
            }
        }
    }

    StateImpl& s_;
    FootprintScratch& f_;
    const TableImpl& t_;
    const Contact contact_;
    const float reach_;
};
}  // namespace

Result<void> begin_footprint(StateImpl& s, const TableImpl& table, const Contact& contact) noexcept {
    Result<void> r = Builder(s, table, contact).build();
    if (!r) end_footprint(s);
    return r;
}

void end_footprint(StateImpl& s) noexcept {
    FootprintScratch& f = s.footprint;
    for (std::uint32_t k = 0; k < f.frame_count; ++k) {
        const Rect& r = f.frames[k].rect;
        for (std::uint32_t i = r.i0; i <= r.i1; ++i) {
            const std::size_t at = std::size_t{i} * s.tables.cols + r.j0;
            std::fill_n(f.key.data() + at, r.width(), kInfinity);
            std::fill_n(f.weight.data() + at, r.width(), 0.0f);
        }
    }
    for (std::uint32_t k = 0; k < f.sample_count; ++k) {
        f.key[f.samples[k]] = kInfinity;
        f.weight[f.samples[k]] = 0;
    }
    for (std::uint32_t k = 0; k < f.class_count; ++k) f.class_seen[f.classes[k]] = 0;
    f.frame_count = f.sample_count = f.class_count = f.listed = 0;
}

}  // namespace dgm::detail
