// SPDX-License-Identifier: MIT
// libdgm/src/physics/c_api_physics.cpp
// dgm_physics.h on top of physics.h.
#include <dgm/compliance.h>
#include <dgm/dgm_physics.h>
#include <dgm/physics.h>

#include "c_api/c_api_impl.h"

struct dgm_physics : dgm::c_api::Held<dgm::Physics> {
    using Held::Held;
};

struct dgm_detail : dgm::c_api::Held<dgm::Detail> {
    using Held::Held;
};

struct dgm_compliance : dgm::c_api::Held<dgm::Compliance> {
    using Held::Held;
};

struct dgm_compliance_reader : dgm::c_api::Held<dgm::ComplianceReader> {
    using Held::Held;
};

namespace {
using dgm::ErrorCode;
using dgm::kNoOffset;
using dgm::Result;
using namespace dgm::c_api;

constexpr std::size_t kMaxScene = 64, kMaxPins = 256;

/// 0 is the default, a negative number 0.
float number(float given, float usual) noexcept {
    return given == 0 ? usual : given < 0 ? 0 : given;
}

struct Scene {
    dgm::Obstacle obstacles[kMaxScene];
    dgm::Pin pins[kMaxPins];
};
Result<dgm::StepOptions> step_options(const dgm_step_options* from, Scene& scene) noexcept {
    dgm_step_options o;
    if (auto r = get(from, o); !r) return r.error();
    if ((o.obstacles == nullptr && o.obstacle_count != 0) || (o.pins == nullptr && o.pin_count != 0)) return kNull;
    if (o.obstacle_count > kMaxScene || o.pin_count > kMaxPins)
        return dgm::Error{ErrorCode::LimitExceeded, kNoOffset, "there are more than 64 obstacles or 256 pins"};
    for (std::size_t k = 0; k < o.obstacle_count; ++k) {
        if (k > 0 && element(o.obstacles, k)->struct_size != o.obstacles->struct_size) return kBadSize;
        auto one = obstacle_of(element(o.obstacles, k));
        if (!one) return one.error();
        scene.obstacles[k] = one.value();
    }
    const auto read = get_each(o.pins, o.pin_count, [&](std::size_t k, const dgm_pin& pin) {
        scene.pins[k] = {pin.sample, vec(pin.position)};
    });
    if (!read) return read.error();
    dgm::StepOptions options;
    if (o.cycles != 0) options.cycles = o.cycles;
    options.gravity = vec(o.gravity);
    options.tool_radius = o.tool_radius;
    options.tool_layer = o.tool_layer;
#ifndef DGM_NO_FRICTION
    options.friction = o.friction;
#endif
    options.obstacles = {scene.obstacles, o.obstacle_count};
    options.pins = {scene.pins, o.pin_count};
    return options;
}

Result<void> read_tools(const dgm_tool_input* tools, std::size_t count, dgm::ToolInput* in) noexcept {
    if (tools == nullptr && count != 0) return kNull;
    if (count > kMaxScene)
        return dgm::Error{ErrorCode::LimitExceeded, kNoOffset, "there are more than 64 tools and obstacles"};
    return get_each(tools, count, [&](std::size_t k, const dgm_tool_input& t) {
        in[k] = {t.tool, static_cast<dgm::ToolKind>(t.kind), vec(t.position), t.lifted == 0};
    });
}
}  // namespace

extern "C" {

dgm_code dgm_physics_create(const dgm_state* state, const dgm_physics_options* options, const dgm_allocator* allocator,
                            dgm_physics** physics, dgm_error* error) {
    if (state == nullptr || physics == nullptr) return finish(kNull, error);
    *physics = nullptr;
    dgm_physics_options o;
    auto a = get(options, o, allocator);
    if (!a) return finish(a.error(), error);
    dgm::PhysicsOptions to;
    const dgm::Material m = dgm::stored_material(state->value).material.value_or(dgm::Material{});
    to.material = {number(o.membrane, m.membrane),     number(o.poisson, m.poisson), number(o.bending, m.bending),
                   number(o.foundation, m.foundation), number(o.density, m.density), number(o.viscosity, m.viscosity)};
    if (o.dt != 0) to.dt = o.dt;
    to.metres_per_unit = o.metres_per_unit;
    if (o.max_bytes != 0) to.max_bytes = o.max_bytes;
    to.keep_volume = o.free_volume == 0;
    to.plain_loops = o.plain_loops != 0;
    to.solver = o.solver > 1 ? dgm::Solver{2} : dgm::Solver{static_cast<std::uint8_t>(o.solver)};
    to.allocator = a.value();
    return hand_out(dgm::Physics::create(state->value, to), a.value(), physics, error);
}
void dgm_physics_destroy(dgm_physics* physics) {
    dgm::detail::destroy(physics);
}
dgm_code dgm_physics_set_dt(dgm_physics* physics, float seconds, dgm_error* error) {
    if (physics == nullptr) return finish(kNull, error);
    return finish(physics->value.set_dt(seconds).error(), error);
}
void dgm_physics_reset(dgm_physics* physics) {
    if (physics != nullptr) physics->value.reset();
}

dgm_code dgm_physics_step(dgm_state* state, dgm_physics* physics, const dgm_step_options* options,
                          const dgm_tool_input* tools, size_t tool_count, dgm_step_tool* answers,
                          dgm_step_report* report, dgm_error* error) {
    if (state == nullptr || physics == nullptr) return finish(kNull, error);
    dgm::ToolInput in[kMaxScene];
    if (auto r = read_tools(tools, tool_count, in); !r) return finish(r.error(), error);
    Scene scene;
    auto o = step_options(options, scene);
    if (!o) return finish(o.error(), error);
    dgm::StepTool out[kMaxScene];
    auto done = dgm::step(state->value, physics->value, o.value(), {in, tool_count}, {out, tool_count});
    if (!done) return finish(done.error(), error);
    for (std::size_t k = 0; answers != nullptr && k < tool_count; ++k) {
        dgm_step_tool t{};
        t.contacts = out[k].contacts;
        store(out[k].force, t.force);
        put(element(answers, k), t);
    }
    const dgm::StepReport& r = done.value();
    put(report, dgm_step_report{0, r.contacts, r.cycles, r.clamped ? 1u : 0u, r.volume_error, r.pressure, r.residual,
                                r.kinetic, r.elastic, r.layers});
    return finish({}, error);
}

dgm_code dgm_state_create_coarse(const dgm_state* fine, uint32_t stride, const dgm_state_options* options,
                                 const dgm_allocator* allocator, dgm_state** coarse, dgm_error* error) {
    if (fine == nullptr || coarse == nullptr) return finish(kNull, error);
    *coarse = nullptr;
    dgm_state_options o;
    auto a = get(options, o, allocator);
    if (!a) return finish(a.error(), error);
    dgm::StateOptions to;
    if (o.max_reach != 0) to.max_reach = o.max_reach;
    if (o.max_bytes != 0) to.max_bytes = o.max_bytes;
    if (o.max_tools != 0) to.max_tools = o.max_tools;
    to.plain_loops = o.plain_loops != 0;
    to.allocator = a.value();
    return hand_out(dgm::coarse_state(fine->value, stride, to), a.value(), coarse, error);
}
dgm_code dgm_detail_create(const dgm_state* fine, const dgm_state* coarse, uint32_t stride,
                           const dgm_allocator* allocator, dgm_detail** detail, dgm_error* error) {
    if (fine == nullptr || coarse == nullptr || detail == nullptr) return finish(kNull, error);
    *detail = nullptr;
    auto a = allocator_of(allocator);
    if (!a) return finish(a.error(), error);
    return hand_out(dgm::Detail::create(fine->value, coarse->value, stride, a.value()), a.value(), detail, error);
}
void dgm_detail_destroy(dgm_detail* detail) {
    dgm::detail::destroy(detail);
}
dgm_code dgm_detail_show(dgm_detail* detail, const dgm_state* coarse, dgm_state* fine, dgm_error* error) {
    if (detail == nullptr || coarse == nullptr || fine == nullptr) return finish(kNull, error);
    return finish(detail->value.show(coarse->value, fine->value).error(), error);
}

dgm_code dgm_compliance_create(const dgm_state* state, const dgm_physics* physics,
                               const dgm_compliance_options* options, const dgm_allocator* allocator,
                               dgm_compliance** compliance, dgm_error* error) {
    if (state == nullptr || physics == nullptr || compliance == nullptr) return finish(kNull, error);
    *compliance = nullptr;
    dgm_compliance_options o;
    auto a = get(options, o, allocator);
    if (!a) return finish(a.error(), error);
    dgm::ComplianceOptions to;
    if (o.tools != 0) to.tools = o.tools;
    if (o.columns != 0) to.columns = o.columns;
    if (o.cycles != 0) to.cycles = o.cycles;
    if (o.renewed != 0) to.renewed = o.renewed;
    if (o.max_bytes != 0) to.max_bytes = o.max_bytes;
    to.allocator = a.value();
    return hand_out(dgm::Compliance::create(state->value, physics->value, to), a.value(), compliance, error);
}
void dgm_compliance_destroy(dgm_compliance* compliance) {
    dgm::detail::destroy(compliance);
}
dgm_code dgm_compliance_publish(dgm_compliance* compliance, const dgm_state* state, dgm_physics* physics,
                                const dgm_step_options* options, const dgm_tool_input* tools, size_t tool_count,
                                dgm_compliance_report* report, dgm_error* error) {
    if (compliance == nullptr || state == nullptr || physics == nullptr) return finish(kNull, error);
    dgm::ToolInput in[kMaxScene];
    if (auto r = read_tools(tools, tool_count, in); !r) return finish(r.error(), error);
    Scene scene;
    auto o = step_options(options, scene);
    if (!o) return finish(o.error(), error);
    const auto done = compliance->value.publish(state->value, physics->value, o.value(), {in, tool_count});
    if (!done) return finish(done.error(), error);
    const dgm::ComplianceReport& r = done.value();
    put(report, dgm_compliance_report{0, r.columns, r.samples, r.left_out, r.frame});
    return finish({}, error);
}
dgm_code dgm_compliance_reader_create(const dgm_compliance* compliance, const dgm_compliance_reader_options* options,
                                      const dgm_allocator* allocator, dgm_compliance_reader** reader,
                                      dgm_error* error) {
    if (compliance == nullptr || reader == nullptr) return finish(kNull, error);
    *reader = nullptr;
    dgm_compliance_reader_options o;
    auto a = get(options, o, allocator);
    if (!a) return finish(a.error(), error);
    const dgm::ReaderOptions to{o.fade, o.damper, o.tick == 0 ? 1e-3f : o.tick, a.value()};
    return hand_out(dgm::ComplianceReader::create(compliance->value, to), a.value(), reader, error);
}
void dgm_compliance_reader_destroy(dgm_compliance_reader* reader) {
    dgm::detail::destroy(reader);
}
dgm_code dgm_compliance_tick(dgm_compliance_reader* reader, const dgm_tool_input* tools, size_t tool_count,
                             dgm_compliance_answer* answers, dgm_error* error) {
    if (reader == nullptr || (answers == nullptr && tool_count != 0)) return finish(kNull, error);
    dgm::ToolInput in[kMaxScene];
    dgm::ComplianceAnswer out[kMaxScene];
    if (auto r = read_tools(tools, tool_count, in); !r) return finish(r.error(), error);
    const auto done = dgm::compliance_tick(reader->value, {in, tool_count}, {out, tool_count});
    for (std::size_t k = 0; done.ok() && k < tool_count; ++k) {
        dgm_compliance_answer t{};
        t.contacts = out[k].contacts;
        t.frame = out[k].frame;
        store(out[k].force, t.force);
        put(element(answers, k), t);
    }
    return finish(done.error(), error);
}

}  // extern "C"
