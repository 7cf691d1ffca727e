// SPDX-License-Identifier: MIT
// libdgm/src/collide.cpp
// Nearest sample and hit test, paper section 5.1.
#include <dgm/collide.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <dgm/deform.h>

#include "state_impl.h"

namespace dgm {
namespace detail {
namespace {

/// Squared distances to samples and to boxes, rounded alike: for a point inside a box each |gap| is at most the
/// sample's |difference|, subtraction, squaring and adding round monotonically, so a box never seems farther than a
/// sample in it, and pruning by `box > best` is exact.
float sample_d2(Vec3 p, Vec3 tool) noexcept {
    const float x = p.x - tool.x, y = p.y - tool.y, z = p.z - tool.z;
    return x * x + y * y + z * z;
}
float box_d2(const Box& box, Vec3 tool) noexcept {
    const float x = std::max(std::max(box.low[0] - tool.x, tool.x - box.high[0]), 0.0f);
    const float y = std::max(std::max(box.low[1] - tool.y, tool.y - box.high[1]), 0.0f);
    const float z = std::max(std::max(box.low[2] - tool.z, tool.z - box.high[2]), 0.0f);
    return x * x + y * y + z * z;
}

/// Where squares of floats overflow nothing was nearer than infinity: look at all samples in double.
Result<Nearest> answer(const StateImpl& s, const ConstPlanes& p, Vec3 tool, const Best& best) noexcept {
    if (best.sample != kNone) return Nearest{best.sample, std::sqrt(best.d2)};
    double nearest = std::numeric_limits<double>::infinity();
    Nearest found;
    for (std::uint32_t k = 0; k < s.total(); ++k) {
        if (!s.usable(k)) continue;
        const double x = double{p.x[k]} - tool.x, y = double{p.y[k]} - tool.y, z = double{p.z[k]} - tool.z;
        const double d = std::sqrt(x * x + y * y + z * z);
        if (!(d < nearest)) continue;
        nearest = d;
        found = {k, d < std::numeric_limits<float>::max() ? static_cast<float>(d) : std::numeric_limits<float>::max()};
    }
    if (found.sample == kNone) return Error{ErrorCode::NotFound, kNoOffset, "the chart has no sample to be near to"};
    return found;
}

/// The tile's own samples.
void search_leaf(const StateImpl& s, const ConstPlanes& p, std::uint32_t tile, Vec3 tool, const Rect* except,
                 Best& best) noexcept {
    const ChartTables& t = s.tables;
    const Rect r = s.tile_rect(tile);
    const auto search = [&](const Rect& part) {
        if (part.empty()) return;
        if (t.mask == nullptr)
            return s.rows_of->nearest({part, t.cols, p, {tool.x, tool.y, tool.z}}, best.d2, best.sample);
        for (std::uint32_t i = part.i0; i <= part.i1; ++i)
            for (std::uint32_t k = i * t.cols + part.j0; k <= i * t.cols + part.j1; ++k)
                if (t.on_surface(k)) best.offer(sample_d2(StateImpl::at(p, k), tool), k);
    };
    if (except == nullptr || !except->meets(r)) {
        search(r);
    } else {
        const Rect& e = *except;
        const std::uint32_t i0 = std::max(r.i0, e.i0), i1 = std::min(r.i1, e.i1);
        if (r.i0 < e.i0) search({r.i0, e.i0 - 1, r.j0, r.j1});
        if (e.i1 < r.i1) search({e.i1 + 1, r.i1, r.j0, r.j1});
        if (r.j0 < e.j0) search({i0, i1, r.j0, e.j0 - 1});
        if (e.j1 < r.j1) search({i0, i1, e.j1 + 1, r.j1});
    }
    for (std::uint32_t b = s.tile_border_start[tile]; b < s.tile_border_start[tile + 1]; ++b)
        best.offer(sample_d2(StateImpl::at(p, s.tile_border[b]), tool), s.tile_border[b]);
}

struct Entry {
    float d2;
    std::uint32_t level, node;
};

/// The window of half size a around `last`, across seams.
Result<void> search_around(StateImpl& s, std::uint32_t last, std::uint32_t a, Vec3 tool, Best& best) noexcept {
    const ConstPlanes p = StateImpl::fixed(s.now);
    const NearestJob job{{}, s.tables.cols, p, {tool.x, tool.y, tool.z}};
    const auto search = [&](const Rect& r) {
        NearestJob here = job;
        here.rect = r;
        s.rows_of->nearest(here, best.d2, best.sample);
    };
    if (is_plain_window(s, last, a + 1)) {
        search(s.window(last, a + 1));
        return {};
    }
    if (!s.tables.free_domain) {
        place_frames(s, nullptr, last, a + 1);
        for (std::uint32_t k = 0; k < s.footprint.frame_count; ++k) search(s.footprint.frames[k].rect);
        end_footprint(s);
        return {};
    }
    if (auto r = begin_walk(s, last, a + 1); !r) return r;
    for (std::uint32_t k = 0; k < s.walk.visited_count; ++k) {
        const std::uint32_t sample = s.walk.nodes[s.walk.visited[k]].sample;
        best.offer(sample_d2(s.point(sample), tool), sample);
    }
    end_walk(s);
    return {};
}
}  // namespace

bool is_finite(Vec3 v) noexcept {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool is_place(Vec3 v) noexcept {
    return std::fabs(v.x) <= kMaxCoordinate && std::fabs(v.y) <= kMaxCoordinate && std::fabs(v.z) <= kMaxCoordinate;
}

/// Depth first, nearest child first.
void search_pyramid(const StateImpl& s, const Pyramid& p, Vec3 tool, Best& best, const Rect* except) noexcept {
    Entry stack[4 * kMaxLevels];  // a visited node leaves at most three siblings behind on each level
    std::uint32_t depth = 0;
    stack[depth++] = {0, p.levels - 1, 0};
    while (depth != 0) {
        const Entry e = stack[--depth];
        if (e.d2 > best.d2) continue;
        if (e.level == 0) {
            search_leaf(s, p.at, e.node, tool, except, best);
            continue;
        }
        const std::uint32_t level = e.level - 1, r = e.node / p.cols[e.level] * 2, c = e.node % p.cols[e.level] * 2;
        const std::uint32_t first = depth;
        for (std::uint32_t i = r; i < std::min(r + 2, p.rows[level]); ++i)
            for (std::uint32_t j = c; j < std::min(c + 2, p.cols[level]); ++j) {
                const std::uint32_t node = i * p.cols[level] + j;
                const float d2 = box_d2(p.boxes[p.start[level] + node], tool);
                if (d2 > best.d2) continue;
                std::uint32_t at = depth++;
                for (; at > first && stack[at - 1].d2 < d2; --at) stack[at] = stack[at - 1];
                stack[at] = {d2, level, node};
            }
    }
}
}  // namespace detail

namespace {
constexpr Error kBadTool{ErrorCode::BadArgument, kNoOffset, "a coordinate of the tool is beyond 1e18"};
}

Result<Nearest> nearest_sample(State& state, Vec3 tool) noexcept {
    detail::StateImpl& s = *state.impl();
    if (!detail::is_place(tool)) return kBadTool;
    detail::refit(s, s.now_boxes);
    detail::Best best;
    detail::search_pyramid(s, s.now_boxes, tool, best);
    return detail::answer(s, detail::StateImpl::fixed(s.now), tool, best);
}

Result<Nearest> track_sample(State& state, Vec3 tool, std::uint32_t last, std::uint32_t a) noexcept {
    detail::StateImpl& s = *state.impl();
    if (!detail::is_place(tool)) return kBadTool;
    if (!s.usable(last)) return Error{ErrorCode::BadArgument, kNoOffset, "the last sample is not on the surface"};
    if (a >= s.max_reach)
        return Error{ErrorCode::BadArgument, kNoOffset, "the window is larger than the state was made for"};
    detail::Best best;
    if (auto r = detail::search_around(s, last, a, tool, best); !r) return r.error();
    return detail::answer(s, detail::StateImpl::fixed(s.now), tool, best);
}

Result<Tracked> track_nearest(State& state, Vec3 tool, std::uint32_t last, std::uint32_t a) noexcept {
    auto local = track_sample(state, tool, last, a);
    if (!local) return local.error();
    detail::StateImpl& s = *state.impl();
    detail::refit(s, s.now_boxes);
    detail::Best best{detail::sample_d2(s.point(local.value().sample), tool), local.value().sample};
    const float window_d2 = best.d2;
    detail::search_pyramid(s, s.now_boxes, tool, best);
    return Tracked{best.sample, std::sqrt(best.d2), best.d2 < window_d2};
}

Result<bool> hit_test(Vec3 tool_vector, Vec3 normal) noexcept {
    if (!detail::is_finite(tool_vector) || !detail::is_finite(normal))
        return Error{ErrorCode::BadArgument, kNoOffset, "a vector of the hit test is not finite"};
    // In double: no product of floats overflows or vanishes there, so the sign is right.
    return double{tool_vector.x} * normal.x + double{tool_vector.y} * normal.y + double{tool_vector.z} * normal.z < 0;
}

}  // namespace dgm
