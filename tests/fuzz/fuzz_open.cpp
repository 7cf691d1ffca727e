// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_open.cpp
// Bytes from strangers: open, then everything that takes an Asset.
#include "fuzz_open.h"

#include <dgm/collide.h>
#include <dgm/deform.h>
#include <dgm/reconstruct.h>
#include <dgm/validate.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <vector>

#include "dgm_builder.h"

namespace {

void require(bool claim) {
    if (!claim) std::abort();
}

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
        static_cast<void>(state.normal(touch.sample));
        if (k % 4 == 0) state.release();
    }
    check_seams(state);
    state.reset();
    check_seams(state);
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
    dgm::KernelOptions kernel;
    kernel.reach = 7;
    const auto table = dgm::DeformTable::create(kernel);
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
        if (!state) continue;
        exercise_mesh(state.value());
        exercise_state(state.value(), table.value());
    }
}
}  // namespace

void exercise_runtime(const std::uint8_t* data, std::size_t size) {
    std::vector<std::byte> bytes(size);
    if (size != 0) std::memcpy(bytes.data(), data, size);
    exercise(bytes);
    mend_hashes(bytes);
    exercise(bytes);
}
