// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_calls_parts.cpp
// Kernels and meshes of fuzz_calls.
#include <algorithm>
#include <vector>

#include <dgm/limits.h>

#include "call_checks.h"
#include "fuzz_calls.h"

namespace dgm::test {
namespace {

VertexTarget random_target(Dice& dice) {
    VertexTarget t;
    const auto format = [&] { return static_cast<VertexFormat>(dice.below(dice.one_in(40) ? 5 : 3)); };
    const auto place = [&](std::size_t usual) {
        return dice.one_in(4) ? kNoAttribute : dice.one_in(20) ? dice.below(60) : usual;
    };
    t.stride = dice.of({std::size_t{32}, std::size_t{32}, std::size_t{40}, std::size_t{33}, std::size_t{12}});
    t.position_offset = place(0);
    t.normal_offset = place(12);
    t.uv_offset = place(24);
    t.position_format = format();
    t.normal_format = format();
    t.uv_format = format();
    t.origin = {dice.real(-2, 2), dice.one_in(8) ? dice.absurd() : 0, 0};
    t.step = {dice.size(1e-38f, 3e38f), 1e-3f, dice.one_in(9) ? dice.absurd() : 1};
    return t;
}

template <class Surface>
void reconstruct_surface(Dice& dice, const Surface& surface) {
    ReconstructOptions options;
    options.lod_stride = dice.one_in(2) ? 1 : dice.below(40);
    options.topology = dice.one_in(3) ? IndexTopology::Strips : IndexTopology::Triangles;
    const auto counts = mesh_counts(surface, options);
    if (!counts) return;
    const std::size_t short_by = dice.one_in(10) ? dice.below(9) : 0;
    const auto wanted = static_cast<std::size_t>(counts.value().indices);
    constexpr std::uint32_t kUnwritten = 0xDEADBEEFu;  // and behind it is the heap's red zone
    std::vector<std::uint32_t> indices(wanted - std::min(wanted, short_by), kUnwritten);
    VertexTarget target = random_target(dice);
    std::vector<std::byte> memory(std::size_t{counts.value().vertices} * target.stride - (dice.one_in(10) ? 1 : 0));
    target.memory = memory;
    const auto done = reconstruct(surface, target, indices, options);
    if (!done || indices.empty()) return;
    promise(done.value().indices == indices.size(), "another number of indices than counted");
    const bool strips = options.topology == IndexTopology::Strips;
    for (const std::uint32_t v : indices)
        promise(v < done.value().vertices || (strips && v == kRestart), "an index names no vertex");
}
}  // namespace

KernelOptions random_kernel(Dice& dice, std::vector<float>& values) {
    KernelOptions k;
    k.shape = dice.of({KernelShape::Circular, KernelShape::Circular, KernelShape::Elliptic, KernelShape::User});
    k.end = dice.of({KernelEnd::Printed, KernelEnd::Compact});
    k.reach = dice.one_in(8) ? dice.of({1u, 2u, 40u}) : dice.between(1, 12);
    k.sigma = dice.one_in(2) ? dice.real(1, 30) : dice.size(kMinSigma, kMaxSigma);
    k.radius_a = dice.one_in(2) ? dice.real(1, 9) : dice.size(kMinKernelRadius, kMaxKernelRadius);
    k.radius_b = dice.one_in(2) ? k.radius_a * dice.of({1.0f, 3.0f, 0.01f, kMaxKernelRatio}) : dice.real(1, 9);
    k.angle = dice.one_in(6) ? 1e30f : dice.real(-4, 4);
    if (dice.one_in(30)) *dice.of({&k.sigma, &k.radius_a, &k.radius_b, &k.angle}) = dice.absurd();
    values.assign(dice.between(2, 9), 0.5f);
    for (float& v : values) v = dice.one_in(4) ? dice.of({0.0f, 1.0f, -1.0f, 1e-45f, -1e-30f}) : dice.real(-1, 1);
    if (dice.one_in(20)) values[0] = dice.absurd();
    k.values = values;
    return k;
}

void reconstruct_any(Dice& dice, const Chart& chart) {
    reconstruct_surface(dice, chart);
}
void reconstruct_any(Dice& dice, const State& state) {
    reconstruct_surface(dice, state);
}

}  // namespace dgm::test
