// SPDX-License-Identifier: GPL-3.0-or-later
// cli/scene/tick_time.cpp
#include "scene/tick_time.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <vector>

#include <dgm/asset.h>
#include <dgm/state.h>
#include <dgm/tick.h>

#include "math/portable.h"
#include "model/codes.h"

namespace dgm::scene {
namespace {

template <class T>
T value_of(Result<T> result) {
    if (!result) throw model::Error(model::codes::kInternal, result.error().message);
    return std::move(result.value());
}

dgm::Footprint runtime_footprint(Footprint footprint) {
    switch (footprint) {
        case Footprint::kGrid:
            return dgm::Footprint::Grid;
        case Footprint::kGeodesic:
            return dgm::Footprint::Geodesic;
        case Footprint::kSurface:
        case Footprint::kMetric:  // its earlier name
            break;
    }
    return dgm::Footprint::Surface;
}

}  // namespace

Asset open_baked(const std::filesystem::path& dgm) {
    auto asset = Asset::open(dgm.string().c_str());
    if (!asset) throw model::Error(model::codes::kInternal, asset.error().message, dgm.string());
    return std::move(asset.value());
}

std::vector<BakedChart> charts_of(const Asset& asset) {
    std::vector<BakedChart> out;
    for (std::uint32_t c = 0; c < asset.chart_count(); ++c) {
        const Chart chart = value_of(asset.chart(c));
        BakedChart& baked = out.emplace_back(BakedChart{chart.rows(), chart.cols(), {}});
        for (std::uint32_t k = 0; k < chart.layer_count(); ++k) {
            const LayerView layer = value_of(chart.layer(k));
            baked.layers.push_back({layer.name, layer.type, {layer.shape, layer.shape + layer.rank}, layer.bytes});
        }
    }
    return out;
}

TickTime measure_tick(const Asset& asset, Footprint footprint, Reach reach) {
    constexpr std::uint32_t kTicks = 2000, kWarmUp = 200;
    std::uint32_t largest = 0, samples = 0;
    for (std::uint32_t c = 0; c < asset.chart_count(); ++c) {
        const Chart chart = value_of(asset.chart(c));
        if (chart.sample_count() > samples) {
            samples = chart.sample_count();
            largest = c;
        }
    }
    const Chart chart = value_of(asset.chart(largest));
    StateOptions options{.max_reach = kMaxReach, .max_tools = 1};
    const auto box = chart.bbox();
    const double diagonal = math::hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2]);
    // Only a state knows the length of a step, and the memory of the timed one follows from the reach in steps.
    const double mean_step = value_of(State::create(chart, {.max_reach = 1})).mean_step();
    const double radius = reach.percent ? reach.value / 100 * diagonal : reach.value;
    const double steps = mean_step > 0 ? std::ceil(radius / mean_step) : 1;
    TickTime out;
    out.reach = static_cast<std::uint32_t>(std::clamp(steps, 2.0, static_cast<double>(kMaxReach)));
    options.max_reach = out.reach;
    State state = value_of(State::create(chart, options));
    out.state_bytes = state.usage().bytes;
    const float width = static_cast<float>(out.reach) / 2.5F;
    const DeformTable table =
        value_of(DeformTable::create({.end = KernelEnd::Compact, .sigma = width * width, .reach = out.reach}));
    TickOptions tick_options;
    tick_options.d_max = static_cast<float>(mean_step) * 2;
    tick_options.footprint = runtime_footprint(footprint);
    std::minstd_rand random(1);
    std::vector<double> times;
    std::uint32_t at = state.sample_count() / 2;
    ToolOutput touched;
    for (std::uint32_t t = 0; t < kTicks; ++t) {
        // A step of at most three samples either way, at a sample that is on the surface.
        const auto cols = static_cast<std::int64_t>(state.cols());
        const std::int64_t step =
            (static_cast<std::int64_t>(random() % 7) - 3) * cols + static_cast<int>(random() % 7) - 3;
        const std::int64_t next = std::clamp<std::int64_t>(at + step, 0, std::int64_t{state.sample_count()} - 1);
        if (state.on_surface(static_cast<std::uint32_t>(next))) at = static_cast<std::uint32_t>(next);
        const Vec3 p = state.rest_positions()[at], n = state.normal(at);
        const auto depth = static_cast<float>(mean_step);
        const ToolInput tool{.position = {p.x - depth * n.x, p.y - depth * n.y, p.z - depth * n.z}};
        const auto start = std::chrono::steady_clock::now();
        const auto done = tick(state, table, tick_options, {&tool, 1}, {&touched, 1});
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        if (!done) throw model::Error(model::codes::kInternal, done.error().message);
        out.samples = std::max(out.samples, done.value().samples);
        if (t >= kWarmUp) times.push_back(seconds.count());
    }
    std::sort(times.begin(), times.end());
    out.ticks = static_cast<std::uint32_t>(times.size());
    out.median = times[times.size() / 2];
    out.p99 = times[times.size() * 99 / 100];
    return out;
}

}  // namespace dgm::scene
