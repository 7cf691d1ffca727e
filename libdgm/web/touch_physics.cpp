// SPDX-License-Identifier: MIT
// libdgm/web/touch_physics.cpp
// Physics for a page: the functions of dgm_physics.h, of plain numbers, as touch.cpp has the rest.
#include <dgm/dgm_physics.h>

#include "touch_shared.h"

using namespace touch;

/// The physics of a body; `dt` seconds a step. 0: see the error.
TOUCH_API dgm_physics* touch_physics(const Body* body, double metres_per_unit, float dt, float membrane, float bending,
                                     float foundation) {
    auto options = sized<dgm_physics_options>();
    options.metres_per_unit = metres_per_unit, options.dt = dt;
    options.membrane = membrane, options.bending = bending, options.foundation = foundation;
    dgm_physics* physics = nullptr;
    dgm_physics_create(state_of(body), &options, nullptr, &physics, &error);
    return physics;
}
TOUCH_API void touch_physics_free(dgm_physics* physics) {
    dgm_physics_destroy(physics);
}
TOUCH_API void touch_physics_reset(dgm_physics* physics) {
    dgm_physics_reset(physics);
}

/// One step with the tools 0 .. tool_count - 1 of touch_tool() and touch_places(), balls of `radius`, and an obstacle
/// as touch_obstacle() has it; none if `kind` is above 2. Answers: contacts, 1 if nothing moved because numbers ran
/// away, residual, kinetic and elastic energy, volume error; then of each tool: contacts, force (3).
TOUCH_API std::uint32_t touch_step(Body* body, dgm_physics* physics, std::uint32_t cycles, std::uint32_t tool_count,
                                   float radius, std::uint32_t kind, float px, float py, float pz, float qx, float qy,
                                   float qz, float obstacle_radius) {
    dgm_step_tool felt[kMostTools];
    for (dgm_step_tool& tool : felt) tool = sized<dgm_step_tool>();
    for (std::uint32_t k = 0; k < tool_count; ++k)
        for (std::uint32_t c = 0; c < 3; ++c) tools[k].position[c] = places[3 * k + c];
    const dgm_obstacle obstacle = obstacle_of(kind, {px, py, pz}, {qx, qy, qz}, obstacle_radius);
    auto options = sized<dgm_step_options>();
    options.cycles = cycles, options.tool_radius = radius;
    options.obstacles = &obstacle, options.obstacle_count = kind <= DGM_OBSTACLE_KIND_CAPSULE ? 1 : 0;
    auto report = sized<dgm_step_report>();
    if (dgm_physics_step(state_of(body), physics, &options, tools, tool_count, felt, &report, &error) != DGM_OK)
        return error.code;
    answers[0] = report.contacts, answers[1] = report.clamped, answers[2] = report.residual;
    answers[3] = report.kinetic, answers[4] = report.elastic, answers[5] = report.volume_error;
    for (std::uint32_t k = 0; k < tool_count; ++k) {
        answers[6 + 4 * k] = felt[k].contacts;
        for (int c = 0; c < 3; ++c) answers[7 + 4 * k + c] = static_cast<double>(felt[k].force[c]);
    }
    return DGM_OK;
}
