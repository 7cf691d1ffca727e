// SPDX-License-Identifier: MIT
// libdgm/src/touch/footprint.cpp
// Finds the samples that a contact moves, and how much: keys and weights in StateImpl::footprint.
#include <algorithm>
#include <cmath>

#include "touch/state_impl.h"
#include "touch/table_impl.h"

namespace dgm::detail {
namespace {
constexpr float kInfinity = __builtin_inff();

class Builder {
 public:
    Builder(StateImpl& s, const TableImpl& t, const Contact& c) noexcept : s_(s), f_(s.footprint), t_(t), contact_(c) {}

    Result<void> build() noexcept {
        f_.truncated = false;
        const std::uint32_t b = t_.options.reach;
        if (s_.tables.free_domain && !is_plain_window(s_, contact_.sample, b)) {
            if (auto r = by_walk(b); !r) return r;
        } else {
            place_frames(s_, &t_, contact_.sample, b);
            if (!s_.stiffness.empty()) soften_frames();
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
    void add_sample(std::uint32_t sample) noexcept { f_.samples[f_.sample_count++] = sample; }
    void see_class(std::uint32_t id) noexcept {
        if (f_.class_seen[id] != 0) return;
        f_.class_seen[id] = 1;
        f_.classes[f_.class_count++] = id;
    }

    template <class Visit>
    void each(Visit visit) noexcept {
        for (std::uint32_t k = 0; k < f_.frame_count; ++k) {
            const Frame& f = f_.frames[k];
            for (std::uint32_t i = f.rect.i0; i <= f.rect.i1; ++i)
                for (std::uint32_t j = f.rect.j0; j <= f.rect.j1; ++j) visit(f, i, j, i * s_.tables.cols + j);
        }
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
            const float form = static_cast<float>(t_.a) * node.x * node.x + static_cast<float>(t_.b) * node.x * node.y +
                               static_cast<float>(t_.c) * node.y * node.y;
            const float stiffness = softness(node.sample);
            f_.key[node.sample] = form;
            f_.weight[node.sample] = stiffness == 1 ? t_.weight(node.x, node.y) : profile(form, stiffness);
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
    f.frame_count = f.sample_count = f.class_count = 0;
}

}  // namespace dgm::detail
