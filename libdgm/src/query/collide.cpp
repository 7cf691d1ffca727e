// SPDX-License-Identifier: MIT
// libdgm/src/query/collide.cpp
// Nearest sample and hit test, paper section 5.1.
#include <dgm/collide.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <dgm/deform.h>

#include "touch/state_impl.h"

namespace dgm {
namespace detail {
namespace {

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
