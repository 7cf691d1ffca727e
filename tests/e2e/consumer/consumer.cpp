// SPDX-License-Identifier: GPL-3.0-or-later
// tests/e2e/consumer/consumer.cpp
// The same walk as consumer.c through the C++ interface, without exceptions and RTTI.
#include <dgm/collide.h>
#include <dgm/contact.h>
#include <dgm/deform.h>
#include <dgm/force.h>
#include <dgm/reconstruct.h>
#include <dgm/snapshot.h>
#include <dgm/tick.h>
#include <dgm/validate.h>

#include <cstdio>
#include <vector>

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    auto asset = dgm::Asset::open(argv[1], {.verify_hashes = true});
    if (!asset) {
        std::fprintf(stderr, "%s: %s\n", dgm::error_name(asset.error().code), asset.error().message);
        return 1;
    }
    const dgm::Chart chart = asset.value().chart(0).value();
    if (!dgm::validate_chart(chart)) return 3;
    const auto counts = dgm::mesh_counts(chart);
    if (!counts || counts.value().vertices != 17 * 33) return 4;
    auto state = dgm::State::create(chart);
    auto table = dgm::DeformTable::create({.sigma = 10, .reach = 6});
    if (!state || !table) return 5;
    const auto nearest = dgm::nearest_sample(state.value(), {0.9f, 0.01f, 1.0f});
    if (!nearest || nearest.value().sample != 8 * 33) return 6;
    const auto done = dgm::deform(state.value(), table.value(),
                                  {.sample = nearest.value().sample, .displacement = {-0.25f, 0, 0}, .d_max = 0.5f});
    if (!done || !done.value().crossed_seam) return 7;
    const auto force = dgm::contact_force(done.value().displacement, 0.5f, 8);
    if (!force || force.value().x != 1.0f) return 8;
    std::vector<float> vertices(3 * counts.value().vertices);
    std::vector<std::uint32_t> indices(counts.value().indices);
    dgm::VertexTarget target;
    target.memory = std::as_writable_bytes(std::span(vertices));
    if (!dgm::reconstruct(state.value(), target, indices)) return 9;
    if (vertices[3 * 8 * 33] != vertices[3 * (8 * 33 + 32)]) return 10;
    const auto solver = dgm::ContactSolver::create(state.value());
    if (!solver) return 11;
    dgm::Obstacle plane;
    plane.normal = {-1, 0, 0};
    plane.point = {0.5f, 0, 0};
    const auto contact = dgm::resolve_contact(state.value(), solver.value(), plane);
    if (!contact || contact.value().samples == 0) return 12;
    auto snapshots = dgm::Snapshots::create(state.value());
    if (!snapshots || !snapshots.value().publish(state.value()) || !snapshots.value().read(vertices, {})) return 13;
    if (vertices[8 * 33] > 0.5f + 1e-5f) return 14;
    std::printf("%u vertices, force %g\n", counts.value().vertices, static_cast<double>(force.value().x));
    return 0;
}
