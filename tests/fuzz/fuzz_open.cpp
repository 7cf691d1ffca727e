// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_open.cpp
// The runtime: open the bytes, as they are and with their hashes made right, and make every call that may follow.
// Promises: seam copies never differ, no index is out of range.
// Twice a target: by itself without the calls on states, at thousands of inputs a second; and as fuzz_run.cpp with
// them.
#include <dgm/collide.h>
#include <dgm/contact.h>
#include <dgm/deform.h>
#include <dgm/pick.h>
#include <dgm/reconstruct.h>
#include <dgm/snapshot.h>
#include <dgm/tick.h>
#include <dgm/validate.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <vector>

#include "dgm_builder.h"
#include "target.h"

#ifndef DGM_FUZZ_CALL_STATES
#define DGM_FUZZ_CALL_STATES 0
#endif

namespace {
using dgm::test::require;
constexpr bool kCallStates = DGM_FUZZ_CALL_STATES != 0;

/// Makes the two hashes fit, as far as the header names a range inside the bytes: else no mutation would get past them.
void mend_hashes(std::vector<std::byte>& bytes) {
    dgm::layout::FileHeader header;
    if (bytes.size() < sizeof header) return;
    std::memcpy(&header, bytes.data(), sizeof header);
    header.file_bytes = bytes.size();
    if (header.index_offset <= bytes.size() && header.index_bytes <= bytes.size() - header.index_offset)
        dgm::test::hash_to(header.index_hash, bytes.data() + header.index_offset, header.index_bytes);
    dgm::test::hash_to(header.header_hash, &header, offsetof(dgm::layout::FileHeader, header_hash));
    std::memcpy(bytes.data(), &header, sizeof header);
}

void check_seams(const dgm::State& state) {
    const dgm::PointView p = state.positions();
    for (std::uint32_t id = 0; id < state.class_count(); ++id)
        for (const std::uint32_t copy : state.class_members(id)) {
            const dgm::Vec3 a = p[copy], b = p[state.class_members(id)[0]];
            require(std::memcmp(&a, &b, sizeof a) == 0);
        }
}

void exercise_state(dgm::State& state, const dgm::DeformTable& table) {
    const std::uint32_t count = state.sample_count();
    for (std::uint32_t k = 0; k < 12; ++k) {
        dgm::Touch touch;
        touch.sample = static_cast<std::uint32_t>(std::uint64_t{count} * k / 11);  // the last one is out of range
        touch.displacement = {1.0f * static_cast<float>(k), -2, 0.5f};
        touch.d_max = 3;
        touch.mode = k % 3 == 0 ? dgm::DeformMode::Plastic : dgm::DeformMode::Elastic;
        const bool sound = state.on_surface(touch.sample);
        require(dgm::deform(state, table, touch).ok() == sound);
        if (!sound) continue;
        const dgm::Vec3 here = state.positions()[touch.sample];
        const auto near = dgm::nearest_sample(state, here), tracked = dgm::track_sample(state, here, touch.sample, 2);
        require(near.ok() == tracked.ok());
        require(!near.ok() || state.on_surface(near.value().sample));
        const auto hit = dgm::pick_ray(state, {here.x, here.y, here.z + 2}, touch.displacement);
        require(!hit.ok() || (state.on_surface(hit.value().sample) && hit.value().distance >= 0));
        static_cast<void>(state.normal(touch.sample));
        if (k % 4 == 0) state.release();
    }
    check_seams(state);
    state.reset();
    check_seams(state);
}

/// The haptic loop with three tools of three kinds, and what a reader sees of it.
void exercise_loop(dgm::State& state, const dgm::DeformTable& table) {
    auto snapshots = dgm::Snapshots::create(state);
    if (!snapshots) return;
    std::vector<float> copied(std::size_t{3} * state.sample_count());
    std::vector<dgm::ToolInput> tools(3);
    std::vector<dgm::ToolOutput> outputs(tools.size());
    for (std::uint32_t turn = 0; turn < 4; ++turn) {
        for (std::uint32_t k = 0; k < tools.size(); ++k) {
            const std::uint32_t sample = (turn * 7 + k * 5) % state.sample_count();
            tools[k] = {k, static_cast<dgm::ToolKind>(k), state.positions()[sample], turn != 3};
            tools[k].position.z -= 0.125f * static_cast<float>(turn);
        }
        dgm::TickOptions options;
        options.footprint = static_cast<dgm::Footprint>(turn % 3);
        options.rule = turn % 2 == 0 ? dgm::ContactRule::Smooth : dgm::ContactRule::Printed;
        options.relax_rate = turn == 2 ? 10.0f : options.relax_rate;
        if (!dgm::tick(state, table, options, tools, outputs).ok()) break;
        for (const dgm::ToolOutput& out : outputs)
            require((out.sample == dgm::kNone || state.on_surface(out.sample)) &&
                    (out.contact == dgm::kNone || state.on_surface(out.contact)));
        if (snapshots.value().publish(state, turn)) require(snapshots.value().read(copied, copied).ok());
        check_seams(state);
    }
    state.release();
}

/// Every kind of obstacle, put where it cuts the shape.
void exercise_contact(dgm::State& state) {
    auto solver = dgm::ContactSolver::create(state);
    if (!solver) return;
    const dgm::Vec3 middle = state.positions()[state.sample_count() / 2];
    for (std::uint32_t kind = 0; kind < 4; ++kind) {
        dgm::Obstacle obstacle;
        obstacle.kind = static_cast<dgm::ObstacleKind>(kind);
        obstacle.point = middle;
        obstacle.end = {middle.x + 1, middle.y, middle.z};
        obstacle.radius = 0.5f;
        obstacle.half = {0.5f, 0.25f, 1};
        dgm::ContactOptions options;
        options.bulge = static_cast<dgm::Bulge>(kind % 3);
        options.max_depth = kind == 3 ? 0.01f : options.max_depth;
        static_cast<void>(dgm::obstacle_distance(obstacle, middle).ok());
        static_cast<void>(dgm::resolve_contact(state, solver.value(), obstacle, options).ok());
        check_seams(state);
        static_cast<void>(solver.value().volume(state));
    }
    state.reset();
}

template <class Surface>
void exercise_mesh(const Surface& surface) {
    const auto counts = dgm::mesh_counts(surface);
    if (!counts || counts.value().indices > 1u << 22) return;
    std::vector<std::byte> vertices(std::size_t{counts.value().vertices} * 32);
    std::vector<std::uint32_t> indices(static_cast<std::size_t>(counts.value().indices));
    dgm::VertexTarget target{vertices, 32, 0, 12, 24};
    if (dgm::reconstruct(surface, target, indices).ok())
        require(std::all_of(indices.begin(), indices.end(), [&](auto v) { return v < counts.value().vertices; }));
    target.normal_offset = dgm::kNoAttribute;
    static_cast<void>(dgm::reconstruct(surface, target, {}).ok());
    for (const std::uint32_t stride : {2u, 5u}) {
        dgm::ReconstructOptions options;
        options.lod_stride = stride;
        options.topology = stride == 5 ? dgm::IndexTopology::Strips : options.topology;
        const auto thinned = dgm::mesh_counts(surface, options);
        if (!thinned || thinned.value().indices > indices.size()) continue;
        std::vector<std::uint32_t> fewer(static_cast<std::size_t>(thinned.value().indices));
        if (dgm::reconstruct(surface, {}, fewer, options).ok() && stride == 2)
            require(std::all_of(fewer.begin(), fewer.end(), [&](auto v) { return v < counts.value().vertices; }));
    }
}

/// Made once: it depends on no input, and to make it costs more than to open most inputs.
const dgm::DeformTable& small_table() {
    static const auto table = [] {
        dgm::KernelOptions kernel;
        kernel.reach = 7;
        return dgm::DeformTable::create(kernel);
    }();
    return table.value();
}

void exercise(std::span<const std::byte> bytes) {
    dgm::OpenOptions options;
    options.max_samples = 1u << 20;  // a header may claim any grid; geometry has to back it, masks and seams need not
    options.max_charts = 64;
    auto asset = dgm::Asset::open_memory(bytes, options);
    if (!asset) {
        require(asset.error().code != dgm::ErrorCode::Ok);
        return;
    }
    static_cast<void>(asset.value().verify().ok());
    for (std::uint32_t c = 0; c < asset.value().chart_count(); ++c) {
        const dgm::Chart chart = asset.value().chart(c).value();
        for (std::uint32_t l = 0; l < chart.layer_count(); ++l) {
            const dgm::LayerView layer = chart.layer(l).value();
            require(layer.bytes == 0 ||
                    (layer.data >= bytes.data() && layer.data + layer.bytes <= bytes.data() + bytes.size()));
            require(chart.find(layer.name).ok());
        }
        exercise_mesh(chart);
        const bool valid = dgm::validate_chart(chart).ok();
        dgm::StateOptions state_options;
        state_options.max_reach = 8;
        auto state = dgm::State::create(chart, state_options);
        require(state.ok() == valid);
        if (!state || !kCallStates) continue;
        exercise_mesh(state.value());
        exercise_state(state.value(), small_table());
        exercise_loop(state.value(), small_table());
        exercise_contact(state.value());
    }
}
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::vector<std::byte> bytes(size);
    if (size != 0) std::memcpy(bytes.data(), data, size);
    exercise(bytes);
    mend_hashes(bytes);
    exercise(bytes);
    return 0;
}
