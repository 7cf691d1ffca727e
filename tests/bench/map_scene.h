// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/map_scene.h
// A baked map with a tool that slides over it, and the same surface as a plain mesh.
#pragma once
#include <dgm/asset.h>
#include <dgm/deform.h>
#include <dgm/reconstruct.h>
#include <dgm/state.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "peers.h"

namespace dgm::bench {

class MapScene {
 public:
    explicit MapScene(const char* path) : name_(path), asset_(opened(path)) {
        for (std::uint32_t k = 1; k < asset_.chart_count(); ++k)
            if (samples(k) > samples(chart_)) chart_ = k;
    }
    [[nodiscard]] const char* name() const { return name_; }
    [[nodiscard]] std::uint32_t reach() const {
        const Chart chart = asset_.chart(chart_).value();
        const std::uint32_t side = std::max(chart.rows(), chart.cols());
        return side <= 100 ? 11 : side <= 400 ? 33 : 65;
    }
    [[nodiscard]] float sigma() const { return static_cast<float>(reach()) * static_cast<float>(reach()) / 4; }
    [[nodiscard]] State state(bool plain) const {
        StateOptions options;
        options.plain_loops = plain;
        auto made = State::create(asset_.chart(chart_).value(), options);
        if (!made) fail(made.error().message);
        return std::move(made).value();
    }
    [[nodiscard]] DeformTable table() const {
        KernelOptions kernel;
        kernel.sigma = sigma();
        kernel.reach = reach();
        kernel.end = KernelEnd::Compact;
        return DeformTable::create(kernel).value();
    }
    /// Below the surface by a step and a half, 0.15 grid steps a tick: inside the grid or three steps from its border.
    [[nodiscard]] Vec3 tool_at(const State& state, long tick, bool at_border) const {
        const double m = state.rows() - 1.0, n = state.cols() - 1.0, way = 0.15 * static_cast<double>(tick);
        const double room_i = std::max(m / 2 - reach() - 1, 1.0), room_j = std::max(n / 2 - reach() - 1, 1.0);
        const double t = way / std::min(room_i, room_j);
        double i = m / 2 + room_i * std::sin(t), j = n / 2 + room_j * std::sin(0.618 * t + 1);
        if (at_border) {
            i = 3;
            j = n / 2 + (n / 2 - 3) * std::sin(way / (n / 2 - 3));
        }
        const auto row = static_cast<std::uint32_t>(i), column = static_cast<std::uint32_t>(j);
        const std::uint32_t a = row * state.cols() + column;
        const float u = static_cast<float>(i - row), v = static_cast<float>(j - column);
        const PointView p = state.rest_positions();
        const Vec3 at = (1 - u) * ((1 - v) * p[a] + v * p[a + 1]) +
                        u * ((1 - v) * p[a + state.cols()] + v * p[a + state.cols() + 1]);
        return at - 1.5f * state.mean_step() * state_normal(state, a);
    }
    /// Seam copies welded.
    [[nodiscard]] Mesh mesh(const State& state) const {
        std::vector<std::uint32_t> number(state.sample_count(), kNone);
        std::vector<Vec> points;
        std::vector<std::uint32_t> corners(mesh_counts(state).value().indices);
        if (!reconstruct(state, {}, corners)) fail("no triangles");
        for (std::uint32_t& c : corners) {
            const std::uint32_t id = state.class_of(c), first = id == kNone ? c : state.class_members(id)[0];
            if (number[first] == kNone) {
                number[first] = static_cast<std::uint32_t>(points.size());
                const Vec3 p = state.rest_positions()[first];
                points.push_back({p.x, p.y, p.z});
            }
            c = number[first];
        }
        std::vector<std::array<std::uint32_t, 3>> faces;
        for (std::size_t k = 0; k < corners.size(); k += 3)
            faces.push_back({corners[k], corners[k + 1], corners[k + 2]});
        return {std::move(points), std::move(faces)};
    }

 private:
    [[noreturn]] static void fail(const char* why) {
        std::fprintf(stderr, "%s\n", why);
        std::exit(2);
    }
    static Asset opened(const char* path) {
        auto asset = Asset::open(path);
        if (!asset) fail(asset.error().message);
        return std::move(asset).value();
    }
    [[nodiscard]] std::uint32_t samples(std::uint32_t k) const { return asset_.chart(k).value().sample_count(); }
    /// Normal of the rest shape: a state's own normal() is that of the present one.
    [[nodiscard]] static Vec3 state_normal(const State& state, std::uint32_t a) {
        const PointView p = state.rest_positions();
        const Vec3 u = p[a + state.cols()] - p[a], v = p[a + 1] - p[a];
        const Vec3 n{u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
        const float length = std::sqrt(dot(n, n));
        return length > 0 ? (1 / length) * n : Vec3{0, 0, 1};
    }

    const char* name_;
    Asset asset_;
    std::uint32_t chart_ = 0;
};

}  // namespace dgm::bench
