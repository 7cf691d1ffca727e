// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/tick_allocation_test.cpp
// Per-tick calls take no memory: malloc and its relatives are replaced for this program and for libdgm.so alike.
#include <gtest/gtest.h>

#include <dgm/changed.h>
#include <dgm/cloth.h>
#include <dgm/collide.h>
#include <dgm/compliance.h>
#include <dgm/contact.h>
#include <dgm/deform.h>
#include <dgm/force.h>
#include <dgm/physics.h>
#include <dgm/pick.h>
#include <dgm/reconstruct.h>
#include <dgm/snapshot.h>
#include <dgm/tick.h>

#include <atomic>
#include <cerrno>

#include "contact_shapes.h"

namespace {
std::atomic<long> g_allocations{0};
}

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void* malloc(std::size_t n) {
    ++g_allocations;
    return __libc_malloc(n);
}
void* calloc(std::size_t n, std::size_t m) {
    ++g_allocations;
    return __libc_calloc(n, m);
}
void* realloc(void* p, std::size_t n) {
    ++g_allocations;
    return __libc_realloc(p, n);
}
void* aligned_alloc(std::size_t a, std::size_t n) {
    ++g_allocations;
    return __libc_memalign(a, n);
}
int posix_memalign(void** p, std::size_t a, std::size_t n) {
    ++g_allocations;
    *p = __libc_memalign(a, n);
    return *p == nullptr ? ENOMEM : 0;
}
}

namespace dgm::test {
namespace {

TEST(Tick, TakesNoMemory) {
    const long before_setup = g_allocations;
    State state = make_state(grid_chart(65, 65, sheet, octahedral_seams(65)));
    EXPECT_GT(g_allocations, before_setup) << "the hook does not see the library";
    KernelOptions kernel;
    kernel.reach = 33;
    kernel.sigma = 100;
    const DeformTable table = DeformTable::create(kernel).value();
    std::vector<float> vertices(65 * 65 * 6);
    std::vector<std::uint32_t> indices(64 * 64 * 6);
    const VertexTarget target{std::as_writable_bytes(std::span(vertices)), 24, 0, 12};
    ChangedRange ranges[4];
    std::uint64_t cursor = 0;
    std::size_t met = 0, changed = 0;
    bool sound = true;
    const long before = g_allocations;
    std::uint32_t last = 0;
    for (int k = 0; k < 2000; ++k) {
        const Vec3 tool{float(k % 67), float(k * 7 % 65), 0.5f};
        state.release();
        const auto near = k % 3 == 0 ? nearest_sample(state, tool) : track_sample(state, tool, last, 4);
        sound = sound && near.ok();
        if (!near) break;
        last = near.value().sample;
        const auto hit = hit_test(tool - state.positions()[last], state.normal(last));
        sound = sound && hit.ok() && contact_force({0.1f, 0, 0.2f}, 1, 3).ok();
        Touch touch;
        touch.sample = last;
        touch.displacement = {0, 0, -0.5f};
        touch.d_max = 1;
        touch.mode = k % 5 == 0 ? DeformMode::Plastic : DeformMode::Elastic;
        sound = sound && deform(state, table, touch).ok();
        met += pick_ray(state, tool + Vec3{0, 0, 40}, {0, 0, -1}).ok() ? 1 : 0;
        changed += changed_rows(state, cursor, ranges).value();
        if (k % 100 == 0) sound = sound && reconstruct(state, target, indices).ok();
    }
    state.reset();
    const long after = g_allocations;
    EXPECT_TRUE(sound);
    EXPECT_GT(met, 1000u);
    EXPECT_GE(changed, 2000u);
    EXPECT_EQ(after, before);
}

TEST(Tick, WholeTurnsTakeNoMemory) {
    for (const bool seams : {false, true}) {
        ChartSpec chart = seams ? grid_chart(65, 65, sheet, octahedral_seams(65)) : free_chart(65, 65, sheet);
        State state = State::create(Opened(build({chart})).chart()).value();
        KernelOptions kernel;
        kernel.reach = 9;
        const DeformTable table = DeformTable::create(kernel).value();
        TickOptions o;
        ToolOutput out[3];
        bool sound = true;
        const long before = g_allocations;
        for (int k = 0; k < 3000; ++k) {
            o.footprint = static_cast<Footprint>(k / 100 % 4);
            o.mode = k % 500 < 20 ? DeformMode::Plastic : DeformMode::Elastic;
            o.relax_rate = k % 300 < 150 ? 30.0f : std::numeric_limits<float>::infinity();
            ToolInput in[3];
            for (std::uint32_t t = 0; t < 3; ++t) {
                in[t].tool = t;
                in[t].kind = static_cast<ToolKind>(t);
                in[t].position = {float((k + 20 * t) % 67), float(k * 7 % 65), 0.4f - 0.1f * float(k % 9)};
            }
            sound = sound && tick(state, table, o, {in, 1 + std::size_t(k % 3)}, out).ok();
        }
        const long after = g_allocations;
        EXPECT_TRUE(sound);
        EXPECT_EQ(after, before);
    }
}

TEST(Tick, ContactsAndSnapshotsTakeNoMemory) {
    State ball = make_state(sphere_chart(65)), cloth = make_state(free_chart(33, 33, sheet));
    const ContactSolver of_ball = ContactSolver::create(ball).value(), of_cloth = ContactSolver::create(cloth).value();
    Snapshots shots = Snapshots::create(ball).value();
    std::vector<float> positions(3 * ball.sample_count());
    std::vector<std::uint32_t> indices(6 * 64 * 64);
    bool sound = true;
    const long before = g_allocations;
    for (int k = 0; k < 300; ++k) {
        ball.release();
        cloth.release();
        Obstacle plane{.point = {0, 0, -0.9f}}, bump{.kind = ObstacleKind::Sphere, .point = {16, 16, -3}, .radius = 4};
        Obstacle body{.kind = ObstacleKind::Surface, .point = {0.1f, 0, 1.9f}, .surface = &cloth};
        plane.point.z += 1e-4f * static_cast<float>(k);
        sound = sound && resolve_contact(ball, of_ball, plane).ok() && resolve_contact(cloth, of_cloth, bump).ok();
        if (k % 100 == 0) sound = sound && resolve_contact(ball, of_ball, body).ok();
        ball.update_normals();
        sound = sound && shots.publish(ball).ok() && shots.read(positions, {}).ok();
        if (k % 100 == 0) sound = sound && reconstruct(ball, {}, indices, {4, IndexTopology::Strips}).ok();
    }
    const long after = g_allocations;
    EXPECT_TRUE(sound);
    EXPECT_EQ(after, before);
}

TEST(Tick, FramesOfClothTakeNoMemory) {
    State state = make_state(grid_chart(33, 33, [](double i, double j) {
        return Point{float(i / 32), float(j / 32), 0};
    }));
    ClothOptions options;
    options.metres_per_unit = 1;
    options.self_contact = true;
    Cloth cloth = Cloth::create(state, options).value();
    bool sound = true;
    StepTool answers[2];
    Obstacle plane;
    plane.point = {0, 0, -0.1f};
    const Pin pin{40, state.positions()[40]};
    std::uint32_t contacts = 0;
    const long before = g_allocations;
    for (int k = 0; k < 100; ++k) {
        ClothStep o;
        o.gravity = {0, 0, -9.81f};
        o.tool_radius = 0.1f;
        o.obstacles = {&plane, 1};
        if (k % 3 == 0) o.pins = {&pin, 1};
        ToolInput in[2];
        in[0].position = {0.5f, 0.5f, 0.2f - 0.01f * float(k % 40)};
        in[1].tool = 1;
        in[1].kind = ToolKind::Grasp;
        in[1].engaged = k % 50 < 30;
        in[1].position = {1, 0.2f, 0.01f * float(k % 50)};
        const auto done = step(state, cloth, o, in, answers);
        sound = sound && done.ok();
        if (done) contacts += done.value().contacts;
        if (k == 50) sound = sound && cloth.take_shape(state).ok();
        state.update_normals();
    }
    const long after = g_allocations;
    EXPECT_TRUE(sound);
    EXPECT_GT(contacts, 0u);
    EXPECT_EQ(after, before);
}
TEST(Tick, StepsOfPhysicsTakeNoMemory) {
    State state = make_state(sphere_chart(33));
    PhysicsOptions options;
    options.metres_per_unit = 0.1;
    options.solver = Solver::Factors;  // multigrid in the steps with pins and after set_dt()
    options.material = Material{};
    options.material->viscosity = 1e-3f;
    Physics physics = Physics::create(state, options).value();
    bool sound = true;
    StepTool answers[2];
    Obstacle plane;
    plane.point = {0, 0, -0.95f};
    const Pin pin{40, state.positions()[40]};
    std::uint32_t contacts = 0;
    const State coarse = coarse_state(state, 4).value();
    Detail detail = Detail::create(state, coarse, 4).value();
    ComplianceOptions two;
    two.tools = 2;
    Compliance compliance = Compliance::create(state, physics, two).value();
    ComplianceReader reader = ComplianceReader::create(compliance).value();
    ComplianceAnswer felt[2];
    std::uint32_t columns = 0;
    const long before = g_allocations;
    for (int k = 0; k < 200; ++k) {
        if (k % 50 == 0) sound = sound && detail.show(coarse, state).ok();
        StepOptions o;
        o.tool_radius = 0.2f;
        o.obstacles = {&plane, 1};
        if (k % 3 == 0) o.pins = {&pin, 1};
        ToolInput in[2];
        in[0].position = {0, 0, 1.2f - 0.01f * float(k % 40)};
        in[1].tool = 1;
        in[1].kind = ToolKind::Grasp;
        in[1].engaged = k % 50 < 30;
        in[1].position = {1, 0.002f * float(k % 50), 0};
        const auto done = step(state, physics, o, in, answers);
        sound = sound && done.ok();
        if (done) contacts += done.value().contacts;
        if (k % 10 == 0) {
            const auto published = compliance.publish(state, physics, o, in);
            sound = sound && published.ok() && compliance_tick(reader, in, felt).ok();
            if (published) columns += published.value().columns;
        }
        if (k % 20 == 0) sound = sound && physics.set_dt(k % 40 == 0 ? 1e-3f : 1e-2f).ok();
        state.update_normals();
    }
    physics.reset();
    const long after = g_allocations;
    EXPECT_TRUE(sound);
    EXPECT_GT(contacts, 0u);
    EXPECT_GT(columns, 0u);
    EXPECT_EQ(after, before);
}

}  // namespace
}  // namespace dgm::test
